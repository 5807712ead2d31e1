"""Whether a file or folder is this user's alone: the only place that asks for owners and modes.

Windows has neither; there a file in the user's own folders counts as private, as access lists make it by default.
"""

from __future__ import annotations

import os
import stat

OTHERS = stat.S_IWGRP | stat.S_IWOTH
POSIX = hasattr(os, "geteuid")


def is_private(found: os.stat_result) -> bool:
    """Whether nobody but this user can write what was found."""
    return not POSIX or (found.st_uid == os.geteuid() and not found.st_mode & OTHERS)


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
