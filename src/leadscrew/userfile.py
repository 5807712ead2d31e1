"""Objects from a user's own file, named ``path/file.py:name``; or a file that is a controller: of a fuzzy system, or
one that ``leadscrew tune`` wrote.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any

from leadscrew.kernel.errors import DataError, NameUnknown
from leadscrew.kernel.sheet import nearest

_REFERENCE = re.compile(r"(?P<path>.*\.(?:py|(?i:fis|fll|fcl|fml|xml)|toml))(?::(?P<name>[^:/\\]*))?", re.DOTALL)
_loaded: dict[Path, tuple[int, ModuleType]] = {}
_controllers: dict[tuple[Path, str, str | None, str, str], Any] = {}


def is_reference(text: str) -> bool:
    """Whether a name means an object in a file; a controller's name may mean a controller file besides."""
    return _REFERENCE.fullmatch(text) is not None and not is_controller_file(text)


def absolute(reference: str, folder: Path | None = None) -> str:
    """The reference with its path made absolute, from ``folder`` or the working directory; other names unchanged."""
    found = _REFERENCE.fullmatch(reference)
    if found is None:
        return reference
    path = ((folder or Path()) / Path(found["path"]).expanduser()).resolve()
    return f"{path}:{found['name']}" if found["name"] else str(path)


def load(reference: str) -> Any:
    """The object that ``path/file.py:name`` names; of a fuzzy system's file the controller, ``name`` its output.

    Raises:
        DataError: no such file, or it does not load; names the line.
        ValueRefused: a fuzzy system that cannot be a controller; says why.
        NameUnknown: no such name in it; names the nearest.
    """
    found = _REFERENCE.fullmatch(reference)
    if found is None:
        raise DataError(f"{reference!r}: expected path/file.py:name")
    if is_data(reference):
        return fuzzy_controller(reference)
    if is_controller_file(reference):
        from leadscrew import controller_file

        return controller_file.block(Path(found["path"]).expanduser())
    module = module_of(Path(found["path"]))
    public = {k: v for k, v in vars(module).items() if not k.startswith("_")}
    if not found["name"]:
        raise NameUnknown(f"{found['path']}: say which object, as {found['path']}:NAME; it has {_listed(public)}")
    if found["name"] not in public:
        raise NameUnknown(f"{found['path']} has no {found['name']!r}{nearest(found['name'], _ours(public))}")
    return public[found["name"]]


def is_data(reference: str) -> bool:
    """Whether a name means a file that is not Python: a fuzzy system."""
    found = _REFERENCE.fullmatch(reference)
    return found is not None and not found["path"].endswith((".py", ".toml"))


def is_controller_file(reference: str) -> bool:
    """Whether a controller's name means a file with its parameters, as ``leadscrew tune`` writes it."""
    return reference.endswith(".toml")


def stem(reference: str) -> str:
    """What is made of a controller of this name is called: as the object is, or as the file that is not Python."""
    if is_data(reference) or is_controller_file(reference):
        found = _REFERENCE.fullmatch(reference)
        assert found is not None
        return re.sub(r"\W", "_", Path(found["path"]).stem)
    return reference.rsplit(":", 1)[-1].rsplit(".", 1)[-1]


def digests(*references: str | None) -> dict[str, str]:
    """SHA-256 of the files that are not Python, by path: of these no source stands in a manifest."""
    found = {}
    for reference in references:
        if reference is not None and (is_data(reference) or is_controller_file(reference)):
            match = _REFERENCE.fullmatch(absolute(reference))
            assert match is not None
            found[match["path"]] = digest(Path(match["path"]))
            if is_controller_file(reference):
                found |= digests(_base(Path(match["path"])))
    return found


def _base(path: Path) -> str | None:
    """The controller that a controller file changes; none where it cannot be read."""
    from leadscrew import controller_file

    try:
        return controller_file.read(path).controller
    except DataError:
        return None


def digest(path: Path) -> str:
    """SHA-256 of a file; empty where there is none."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


def fuzzy_controller(reference: str, command: str = "", feedback: str = "") -> Any:
    """The controller of a fuzzy system's file, made once as long as the file stays as it is.

    ``command`` and ``feedback`` are the fields of these signals that it takes, where they have several.
    """
    from leadscrew.fuzzy.block import from_file

    found = _REFERENCE.fullmatch(reference)
    assert found is not None
    whole, output = Path(found["path"]).expanduser(), found["name"]
    key = (whole.resolve(), digest(whole), output, command, feedback)
    if key not in _controllers:
        _controllers[key] = from_file(whole, output, command=command, feedback=feedback)
    return _controllers[key]


def _ours(public: dict[str, Any]) -> list[str]:
    """The names worth offering: not modules, classes or what a block file imports."""
    helpers = ("leadscrew.kernel.", "typing", "__future__", "annotated_types")
    return [
        k
        for k, v in public.items()
        if (not isinstance(v, ModuleType | type) and not str(getattr(v, "__module__", "")).startswith(helpers))
        or type(v).__name__ in ("Block", "Study", "Loop")
    ]


def _listed(public: dict[str, Any]) -> str:
    return ", ".join(_ours(public)) or "none"


def module_of(path: Path) -> ModuleType:
    """A file as a module, read anew when it has changed; what lies beside it can be imported by it.

    Raises:
        DataError: no such file, or it does not load; names the line.
    """
    try:
        whole = path.expanduser().resolve(strict=True)
        stamp = whole.stat().st_mtime_ns
    except (OSError, RuntimeError, ValueError):
        raise DataError(f"there is no file {str(path)!r}") from None
    if whole in _loaded and _loaded[whole][0] == stamp:
        return _loaded[whole][1]
    name = f"leadscrew_user_{whole.stem}_{hashlib.sha256(str(whole).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, whole)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    if str(whole.parent) not in sys.path:
        sys.path.append(str(whole.parent))
    # NamedTuples look up their annotations through sys.modules.
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise DataError(f"{path}{_line(error, whole)} does not load: {type(error).__name__}: {error}") from error
    _loaded[whole] = (stamp, module)
    return module


def _line(error: Exception, path: Path) -> str:
    if isinstance(error, SyntaxError) and error.lineno:
        return f":{error.lineno}"
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    return f":{lines[-1]}" if lines else ""
