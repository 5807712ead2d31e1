"""Files and folders that are being written, hidden beside the place that they take at the end.

Their names say who writes them: ``.NAME-HOST-PID-RANDOM.tmp`` (a file), ``.partial`` (a folder), ``.old`` (what a new
folder replaces). The process holds a lock on them where the disk has locks. What a killed process left is removed by
the next command that writes to the same folder: files and folders of this user, of such a name, of this host, whose
process has ended and that nobody has locked. What another host left stays until a command of that host writes there.
Names have the permissions that the umask leaves; what replaces a file or folder keeps those it had.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import socket
import stat
from contextlib import suppress
from pathlib import Path

from leadscrew.kernel.errors import DataError
from leadscrew.kernel.system import is_locked, is_own, is_running, lock, set_mode

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
