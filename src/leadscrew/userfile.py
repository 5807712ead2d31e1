"""Objects from a user's own file, named ``path/file.py:name``; or a file that is a controller: of a fuzzy system, or
one that ``leadscrew tune`` wrote.

Python that the user names runs. Python that a file names (experiment, controller, session, run.json) runs only where it
lies in the working folder or below, links followed, or within :func:`trust`: whoever reads a file of names marks them
with :func:`from_file`, and :func:`module_of` decides.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, Self

from leadscrew.kernel.errors import CodeNotTrusted, DataError, NameUnknown
from leadscrew.kernel.sheet import nearest

_REFERENCE = re.compile(r"(?P<path>.*\.(?:py|(?i:fis|fll|fcl|fml|xml)|toml))(?::(?P<name>[^:/\\]*))?", re.DOTALL)
_loaded: dict[Path, tuple[int, ModuleType]] = {}
_controllers: dict[tuple[Path, str, str | None, str, str], Any] = {}
_trusting: list[None] = []
"""An item for each :func:`trust` that is open."""


class FromFile(str):
    """A name that a file gives; :func:`absolute`, copies and pickles keep the mark, methods of ``str`` do not."""

    file: str

    def __new__(cls, name: str, file: str = "") -> Self:
        made = super().__new__(cls, name)
        made.file = file
        return made


def from_file(name: str, file: Path) -> FromFile:
    """The name as ``file`` gives it: absolute, with its path looked for beside the file."""
    return FromFile(absolute(name, file.resolve().parent), str(file))


@contextmanager
def trust() -> Iterator[None]:
    """Within it, Python that a file names runs wherever it lies: for files that you have read.

    It holds for all threads of the process.
    """
    _trusting.append(None)
    try:
        yield
    finally:
        _trusting.pop()


def trusting() -> bool:
    """Whether a :func:`trust` is open."""
    return bool(_trusting)


def _check(python: Path, named_by: str) -> None:
    """Refuses Python that a file names and that may not run; ``python`` without links.

    Raises:
        CodeNotTrusted: names both files, and how to allow it.
    """
    folder = Path.cwd().resolve()
    if not trusting() and not python.is_relative_to(folder):
        raise CodeNotTrusted(
            f"{named_by}: names the Python file {python}, which was not run because it lies outside the working folder "
            f"{folder}; read it, then add --trust (in Python: with leadscrew.trust()), or work in its folder"
        )


def is_reference(text: str) -> bool:
    """Whether a name means an object in a file; a controller's name may mean a controller file besides."""
    return _REFERENCE.fullmatch(text) is not None and not is_controller_file(text)


def absolute(reference: str, folder: Path | None = None) -> str:
    """The reference with its path made absolute, from ``folder`` or the working directory; other names unchanged.

    The mark of a name that a file gives is kept.
    """
    found = _REFERENCE.fullmatch(reference)
    if found is None:
        return reference
    try:
        path = ((folder or Path()) / Path(found["path"]).expanduser()).resolve()
    except (OSError, RuntimeError, ValueError):  # whoever opens it says what is wrong
        return reference
    made = f"{path}:{found['name']}" if found["name"] else str(path)
    return FromFile(made, reference.file) if isinstance(reference, FromFile) else made


def load(reference: str) -> Any:
    """The object that ``path/file.py:name`` names; of a fuzzy system's file the controller, ``name`` its output.

    Raises:
        CodeNotTrusted: a file names it, and it may not run.
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
    module = module_of(Path(found["path"]), reference.file if isinstance(reference, FromFile) else None)
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


def module_of(path: Path, named_by: str | None = None) -> ModuleType:
    """A file as a module, read anew when it has changed; what lies beside it can be imported by it.

    ``named_by`` is the file that names it; None where the user does.

    Raises:
        CodeNotTrusted: a file names it, and it may not run.
        DataError: no such file, or it does not load; names the line.
    """
    try:
        whole = path.expanduser().resolve(strict=True)
        stamp = whole.stat().st_mtime_ns
    except (OSError, RuntimeError, ValueError):
        raise DataError(f"there is no file {str(path)!r}") from None
    if named_by is not None:
        _check(whole, named_by)
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
