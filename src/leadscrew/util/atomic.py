"""Files that appear whole or not at all: written beside their place and renamed.

Files and folders that are being written, hidden beside the place that they take at the end.

Their names say who writes them: ``.NAME-HOST-PID-RANDOM.tmp`` (a file), ``.partial`` (a folder), ``.old`` (what a new
folder replaces). The process holds a lock on them where the disk has locks. What a killed process left is removed by
the next command that writes to the same folder: files and folders of this user, of such a name, of this host, whose
process has ended and that nobody has locked. What another host left stays until a command of that host writes there.
Names have the permissions that the umask leaves; what replaces a file or folder keeps those it had.
"""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import socket
import stat
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path

from leadscrew.util.errors import DataError
from leadscrew.util.system import is_locked, is_own, is_running, lock, set_mode

_swept: set[Path] = set()
"""Folders that this process has looked through."""


def place(path: str | Path) -> Path:
    """Where a file or folder is written: through a link, what it points to.

    Raises:
        DataError: a link to nothing or to itself.
    """
    named = Path(path)
    try:
        return named.resolve(strict=True) if named.is_symlink() else named
    except FileNotFoundError:
        end = named.readlink()
        raise DataError(f"{named} is a link to {end}, which does not exist; make {end}, or remove the link") from None
    except (OSError, RuntimeError) as error:  # a link that leads back to itself
        raise DataError(f"{named} cannot be written: {getattr(error, 'strerror', '') or error}") from None


def new_file(target: Path) -> tuple[int, Path]:
    """A new file for ``target``, open for writing, with the permissions that ``target`` will have."""
    _sweep(target.parent)
    mode = _mode(target, 0o666)
    beside = _name(target, "tmp")
    handle = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), mode)
    lock(handle)
    if target.exists():
        set_mode(handle, mode)
    return handle, beside


def new_folder(target: Path, suffix: str = "partial") -> Path:
    """A new folder for ``target``, with the permissions that ``target`` will have."""
    _sweep(target.parent)
    beside = _name(target, suffix)
    beside.mkdir()
    if target.exists():
        beside.chmod(_mode(target, 0o777))
    return beside


def hold(folder: Path) -> int | None:
    """Locks a new folder; gives what is to be closed when it is in its place, None where folders cannot be opened."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # Windows
        return None
    lock(handle)
    return handle


def remove_old(target: Path) -> None:
    """Removes what killed processes set aside of ``target``, once a new one stands."""
    _remove(target.parent, re.escape(_short(target)), "old")


def _name(target: Path, suffix: str) -> Path:
    return target.with_name(f".{_short(target)}-{_host()}-{os.getpid()}-{secrets.token_hex(4)}.{suffix}")


def _short(target: Path) -> str:
    """As much of a name as leaves room for the rest: file systems allow 255 bytes."""
    return target.name.encode("utf-8", "ignore")[:120].decode("utf-8", "ignore")


def _host() -> str:
    return re.sub(r"[^\w.]+", "_", socket.gethostname())[:64] or "host"


def _mode(target: Path, new: int) -> int:
    return stat.S_IMODE(target.stat().st_mode) if target.exists() else new


def _sweep(folder: Path) -> None:
    """Removes what killed processes left unfinished in a folder; once a process."""
    folder = folder.absolute()
    if folder not in _swept:
        _swept.add(folder)
        _remove(folder, ".+", "tmp|partial")


def _remove(folder: Path, name: str, suffixes: str) -> None:
    form = re.compile(rf"\.{name}-{re.escape(_host())}-(\d{{1,10}})-[0-9a-f]{{8}}\.({suffixes})", re.DOTALL)
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            found = form.fullmatch(entry.name)
            if found is None or is_running(int(found[1])):
                continue
            with suppress(OSError):
                is_folder = entry.is_dir(follow_symlinks=False)
                kind_fits = is_folder if found[2] != "tmp" else entry.is_file(follow_symlinks=False)
                if not kind_fits or not is_own(entry.stat(follow_symlinks=False)) or is_locked(entry.path):
                    continue
                if is_folder:
                    shutil.rmtree(entry.path, ignore_errors=True)
                else:
                    Path(entry.path).unlink()


def atomic_write(data: str | bytes, path: str | Path, durable: bool = True) -> None:
    """Writes a file beside its place and renames it, so that it is never there in part; text as UTF-8, lines as given.

    A link stays, and the file that it points to is replaced. A device or pipe is written to. The file has the
    permissions that the umask leaves, or those of the file that it replaces.

    ``durable``: it is on the disk before it has its name, and so after a power cut is whole or not there. Without, a
    power cut may leave it empty or torn; the end of the process alone never does.

    Raises:
        DataError: it cannot be written.
    """
    named, beside = Path(path), None
    try:
        content = data.encode() if isinstance(data, str) else data
        if named.exists() and not named.is_file() and not named.is_dir():
            named.write_bytes(content)
            return
        target = place(named)
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, beside = new_file(target)
        with os.fdopen(handle, "wb") as out:
            out.write(content)
            if durable:
                out.flush()
                os.fsync(out.fileno())
        beside.replace(target)
    except UnicodeEncodeError:
        raise DataError(f"{named} cannot be written: a name or note in it is no Unicode text") from None
    except OSError as error:
        raise DataError(f"{named} cannot be written: {error.strerror or error}") from None
    finally:
        if beside is not None:
            beside.unlink(missing_ok=True)
    if durable:
        _sync_folder(target.parent)


def _sync_folder(folder: Path) -> None:
    """The new name is on the disk too, where the system can say so of a folder."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def atomic_folder(folder: str | Path) -> AbstractContextManager[Path]:
    """A place to write to, which becomes ``folder`` at the end; what fails on the way leaves nothing behind.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    return _written(Path(folder), _is_taken, replaces=False)


def replace_folder(folder: str | Path, is_ours: Callable[[Path], bool], what: str) -> AbstractContextManager[Path]:
    """As :func:`atomic_folder`; an older folder of the same kind stays until the new one stands, and is then removed.

    Raises:
        DataError: see :func:`replaceable_folder`; or the disk refuses.
    """
    return _written(Path(folder), _holds_else(is_ours, what), replaces=True)


def replaceable_folder(folder: str | Path, is_ours: Callable[[Path], bool], what: str) -> Path:
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
