"""What POSIX systems tell and Windows does not: owners and modes, processes, locks, resources. Only here.

Where the system does not tell, each function says what it assumes. On Windows a file in the user's own folders counts
as private, as access lists make it by default; every process counts as running, and no file as locked.
"""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
    import resource
    import signal
except ImportError:  # Windows
    POSIX = False
else:
    POSIX = hasattr(os, "geteuid")

OTHERS = stat.S_IWGRP | stat.S_IWOTH


def is_private(found: os.stat_result) -> bool:
    """Whether nobody but this user can write what was found."""
    return is_own(found) and not (POSIX and found.st_mode & OTHERS)


def is_own(found: os.stat_result) -> bool:
    """Whether what was found belongs to this user; True on Windows."""
    return not POSIX or found.st_uid == os.geteuid()


def may_be_replaced(folder: os.stat_result) -> bool:
    """Whether others can put their own files and folders in place of this user's inside a folder."""
    return POSIX and bool(folder.st_mode & OTHERS) and not folder.st_mode & stat.S_ISVTX


def read_private(path: str | os.PathLike[str]) -> bytes | None:
    """What a plain file of this user's alone holds; None for what is not there, no plain file, or open to others."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        handle = os.open(path, flags)
    except OSError:
        return None
    found = os.fstat(handle)
    if not stat.S_ISREG(found.st_mode) or not is_private(found):
        os.close(handle)
        return None
    with os.fdopen(handle, "rb") as file:
        try:
            return file.read()
        except OSError:
            return None


def set_mode(handle: int, mode: int) -> None:
    """Gives an open file the permissions of ``mode``; Windows keeps its own."""
    if POSIX:
        os.fchmod(handle, stat.S_IMODE(mode))


def is_running(process: int) -> bool:
    """Whether this machine has a process of that number; True on Windows, where signal 0 ends one."""
    if not POSIX:
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True


def lock(handle: int) -> None:
    """Locks an open file or folder until it is closed or the process ends; nothing where the disk has no locks."""
    if POSIX:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def is_locked(path: str | os.PathLike[str]) -> bool:
    """Whether a process holds :func:`lock` on a file or folder; False on Windows and on disks without locks."""
    if not POSIX:
        return False
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    finally:
        os.close(handle)
    return False


def end_session(process: subprocess.Popen[bytes]) -> None:
    """Kills a process that was started with ``start_new_session`` and all that it started; on Windows itself alone."""
    with suppress(OSError):
        if POSIX:
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()


def safe_path() -> tuple[str, ...]:
    """Options of a Python that this one starts: modules of the working folder come first only where they do here."""
    return () if sys.path[:1] in ([""], [str(Path.cwd())]) and not sys.flags.safe_path else ("-P",)


def ignore_interrupt() -> None:
    """Ctrl-C in the terminal does not end this process; on Windows it does."""
    if POSIX:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def bound(memory: int, seconds: float) -> None:
    """Gives this process so many bytes, and from now on so many seconds of computing; no bounds on Windows."""
    if POSIX:
        used = resource.getrusage(resource.RUSAGE_SELF)
        most = int(used.ru_utime + used.ru_stime + seconds) + 1
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))


def peak_memory() -> float | None:
    """The most memory that this process held, MiB; None on Windows."""
    if not POSIX:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak / (1024.0 if sys.platform != "darwin" else 1024.0**2), 1)
