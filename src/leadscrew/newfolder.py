"""A folder that appears only when it is complete: written beside, then renamed.

A link stays, and the folder that it points to is filled or replaced. A new folder has the permissions that the umask
leaves, one that replaces another those that it had.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

from leadscrew.kernel.errors import DataError
from leadscrew.unfinished import hold, new_folder, place, remove_old


def appearing(folder: str | Path) -> AbstractContextManager[Path]:
    """A place to write to, which becomes ``folder`` at the end; what fails on the way leaves nothing behind.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    return _written(Path(folder), _is_taken, replaces=False)


def replacing(folder: str | Path, is_ours: Callable[[Path], bool], what: str) -> AbstractContextManager[Path]:
    """As :func:`appearing`; an older folder of the same kind stays until the new one stands, and is then removed.

    Raises:
        DataError: see :func:`replaceable`; or the disk refuses.
    """
    return _written(Path(folder), _holds_else(is_ours, what), replaces=True)


def replaceable(folder: str | Path, is_ours: Callable[[Path], bool], what: str) -> Path:
    """The folder, if :func:`replacing` may write there; ``what``: the kind of folder that it may replace.

    Raises:
        DataError: it holds something else, is a file, or cannot be written.
    """
    named = Path(folder)
    target = place(named)
    with _refusals(named):
        _begun(named, target, _holds_else(is_ours, what)).rmdir()
    return named


def _is_taken(target: Path) -> str:
    taken = target.exists() and (not target.is_dir() or any(target.iterdir()))
    return "exists already; choose another folder or remove it" if taken else ""


def _holds_else(is_ours: Callable[[Path], bool], what: str) -> Callable[[Path], str]:
    def refusal(target: Path) -> str:
        if target.exists() and not target.is_dir():
            return "is not a folder; choose another place for the report"
        if target.exists() and any(target.iterdir()) and not is_ours(target):
            return f"holds something that is not {what}; choose another folder"
        return ""

    return refusal


@contextmanager
def _refusals(named: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise DataError(f"{named} cannot be written: {error.strerror or error}") from None


def _begun(named: Path, target: Path, refusal: Callable[[Path], str]) -> Path:
    """The new folder beside its place; ``refusal`` says why the place cannot be taken."""
    if why := refusal(target):
        raise DataError(f"{named} {why}")
    if target.parent.exists() and not target.parent.is_dir():
        raise DataError(f"{named} cannot be written: {target.parent} is not a folder")
    target.parent.mkdir(parents=True, exist_ok=True)
    return new_folder(target)


@contextmanager
def _written(named: Path, refusal: Callable[[Path], str], replaces: bool) -> Iterator[Path]:
    target = place(named)
    with _refusals(named), ExitStack() as done:
        beside = _begun(named, target, refusal)
        done.callback(shutil.rmtree, beside, ignore_errors=True)
        if (handle := hold(beside)) is not None:
            done.callback(os.close, handle)
        yield beside
        if why := refusal(target):  # it may have been filled meanwhile
            raise DataError(f"{named} {why}")
        _put(beside, target, replaces)


def _put(beside: Path, target: Path, replaces: bool) -> None:
    """Puts a finished folder in its place; an older one that is not empty stays until the new one stands."""
    if replaces and target.exists() and any(target.iterdir()):
        aside = new_folder(target, "old")
        target.rename(aside / target.name)
        try:
            beside.rename(target)
        except OSError:
            (aside / target.name).rename(target)
            aside.rmdir()
            raise
        shutil.rmtree(aside, ignore_errors=True)
    else:
        if target.exists():
            target.rmdir()
        beside.rename(target)
    remove_old(target)
