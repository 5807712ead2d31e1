"""Python in a user's own file, and by what rule it runs.

Python that the user names runs. Python that a file names (experiment, controller, session, run.json) runs only where it
lies in the working folder or below, links followed, or within :func:`trust`: whoever reads a file of names marks them
with :func:`leadscrew.names.from_file`, and :func:`module_of` decides.
"""

from __future__ import annotations

import hashlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from leadscrew import names
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import CodeNotTrusted, DataError, NameUnknown

_loaded: dict[Path, tuple[int, ModuleType]] = {}
_trusting: list[None] = []
"""An item for each :func:`trust` that is open."""


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


def load(reference: str) -> Any:
    """The object that ``path/file.py:name`` names.

    Raises:
        CodeNotTrusted: a file names it, and it may not run.
        DataError: no such file, or it does not load; names the line.
        NameUnknown: no such name in it; names the nearest.
    """
    path, name = names.parts(reference)
    module = module_of(path, reference.file if isinstance(reference, names.FromFile) else None)
    public = {k: v for k, v in vars(module).items() if not k.startswith("_")}
    if not name:
        raise NameUnknown(f"{path}: say which object, as {path}:NAME; it has {_listed(public)}")
    if name not in public:
        raise NameUnknown(f"{path} has no {name!r}{nearest(name, _ours(public))}")
    return public[name]


def digest(path: Path) -> str:
    """SHA-256 of a file; empty where there is none."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


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
