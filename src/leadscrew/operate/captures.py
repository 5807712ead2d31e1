"""Captures of the scope: kept in a folder as Parquet, CSV or MAT files, and read back with the same bits.

A capture goes out and comes back unchanged in all three formats: names, units, period, trigger, what was set, and every
double (of a NaN in CSV only that it is one). What other programs recorded is read by ``leadscrew.logs.read_table``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from leadscrew.kernel import validate
from leadscrew.kernel.parameters import nearest
from leadscrew.operate.capture import MOST_BYTES, Capture, check
from leadscrew.util import atomic
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

FORMATS = ("parquet", "csv", "mat")
"""What a capture is saved as; also the suffix of its file."""

READ = (*FORMATS, "pq", "txt", "tsv", "log", "dat")
"""Suffixes of files that a folder of captures may hold."""

MOST_FILES = 500
"""Captures that a folder holds."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}")
_SUFFIX = re.compile(r"\.(" + "|".join(READ) + r")\Z")


@dataclass(frozen=True)
class Listed:
    """A capture in a folder: file name, size in bytes, and when it was written (UTC, ISO 8601)."""

    name: str
    bytes: int
    when: str


def checked_name(name: object) -> str:
    """A name that is safe as a file name: a letter or digit, then up to 63 letters, digits, blanks and ``_ . -``.

    Raises:
        ValueRefused: any other, such as one with a slash, a leading dot or ``..``.
    """
    if not isinstance(name, str) or not _allowed(name):
        shown = repr(name if not isinstance(name, str) or len(name) <= 80 else name[:77] + "...")
        raise ValueRefused(
            f"name = {shown}: allowed are 1 to 64 letters, digits, blanks and _ . - with a letter or digit first, "
            "no point or blank last, and no two points in a row"
        )
    return name


def save(capture: Capture, folder: str | Path, name: str, format: str = "parquet", replace: bool = False) -> Path:
    """Writes a capture beside its place in the folder and renames it; gives its path.

    Raises:
        ValueRefused: a name that is not allowed, a format that there is not, rows that are not (n, columns) of float64,
            or a capture of more than 50 MB.
        DataError: there is one of that name and ``replace`` is not set, the folder is full, or it cannot be written.
    """
    from leadscrew.operate import capture_files

    name = checked_name(name)
    validate.one_of("format", format, list(FORMATS))
    check(capture)
    path = _place(folder, f"{name}.{format}", replace)
    data = getattr(capture_files, f"{format}_of")(capture)
    if len(data) > MOST_BYTES:
        raise ValueRefused(
            f"{name}.{format} would have {len(data) / 1e6:.0f} MB; up to {MOST_BYTES / 1e6:.0f} MB are saved: take a "
            f"shorter capture{', or save it as parquet' if format == 'csv' else ''}"
        )
    atomic.atomic_write(data, path)
    return path


def load(path: str | Path, apart: bool = False) -> Capture:
    """The capture of a file that :func:`save` wrote, or any log or run folder that ``leadscrew.logs`` reads.

    Args:
        path: the file or folder.
        apart: a file is read in a process of its own, whose memory and time are bounded. Large texts always are.

    Raises:
        DataError: there is none, it is broken, is larger than 50 MB, or holds no rows or no sampling period.
    """
    from leadscrew.operate import capture_files

    where = Path(path)
    try:
        size = where.stat().st_size if where.is_file() else 0
    except (OSError, ValueError) as problem:
        raise DataError(f"{str(path)!r}: cannot be read ({problem})") from None
    if size > MOST_BYTES:
        raise DataError(
            f"{where}: {size / 1e6:.0f} MB; captures up to {MOST_BYTES / 1e6:.0f} MB are read: cut it into parts"
        )
    if size and (apart or capture_files.is_large_text(where)):
        return capture_files.read_apart(where)
    return (capture_files.read_own(where) if size else None) or capture_files.read_log(where)


def names(folder: str | Path) -> list[Listed]:
    """The captures in a folder, the newest first; links and files of other kinds are not among them."""
    found = []
    where = Path(folder)
    for path in where.iterdir() if where.is_dir() else ():
        if _is_name(path.name) and not path.is_symlink() and path.is_file():
            seen = path.stat()
            found.append((seen.st_mtime, Listed(path.name, seen.st_size, _iso(seen.st_mtime))))
    return [listed for _, listed in sorted(found, key=lambda x: (-x[0], x[1].name))]


def find(folder: str | Path, name: object) -> Path:
    """The file of a capture in a folder by its name, with its suffix or, where only one fits, without.

    Raises:
        ValueRefused: a name that is not allowed.
        NameUnknown: there is none, or there are several; links are not followed.
    """
    wanted = checked_stem(name)
    known = [listed.name for listed in names(folder)]
    fits = [n for n in known if n == wanted] or [n for n in known if _SUFFIX.sub("", n) == wanted]
    if len(fits) > 1:
        raise NameUnknown(f"{wanted!r} fits {', '.join(sorted(fits))}; name one of them in full")
    if not fits:
        raise NameUnknown(f"there is no capture {wanted!r}{nearest(wanted, known)}")
    return Path(folder) / fits[0]


def received(folder: str | Path, name: object, data: bytes, replace: bool = False, apart: bool = False) -> Capture:
    """Keeps a file that was sent, under its name with a suffix, if it can be read as a capture; gives the capture.

    ``apart``: as :func:`load`.

    Raises:
        ValueRefused: a name that is not allowed, or of another suffix; more than 50 MB.
        DataError: as :func:`save`, or it cannot be read: then nothing is kept.
    """
    import tempfile

    known = checked_stem(name)
    if not _is_name(known):
        raise ValueRefused(f"name = {known!r}: allowed are files that end in {', '.join('.' + s for s in READ)}")
    if len(data) > MOST_BYTES:
        raise ValueRefused(f"{known}: {len(data) / 1e6:.0f} MB; up to {MOST_BYTES / 1e6:.0f} MB are taken")
    path = _place(folder, known, replace)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".upload-", dir=path.parent) as beside:
        tried = Path(beside) / known
        atomic.atomic_write(data, tried, durable=False)
        try:
            capture = load(tried, apart)
        except DataError as problem:
            raise DataError(str(problem).replace(str(tried), known)) from None
    atomic.atomic_write(data, path)
    return capture


def checked_stem(name: object) -> str:
    """A name as :func:`checked_name`, with or without the suffix of a file.

    Raises:
        ValueRefused: as there.
    """
    checked_name(_SUFFIX.sub("", name) if isinstance(name, str) else name)
    return str(name)


def _is_name(file: str) -> bool:
    """Whether a file is called as captures are."""
    stem = _SUFFIX.sub("", file)
    return stem != file and _allowed(stem)


def _allowed(name: str) -> bool:
    return bool(_NAME.fullmatch(name)) and ".." not in name and name[-1] not in ". "


def _place(folder: str | Path, file: str, replace: bool) -> Path:
    """Where a file goes; its folder has room for it."""
    path = Path(folder) / file
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise DataError(f"{file} is no file but a link or a folder; choose another name")
    if path.exists():
        if not replace:
            raise DataError(f"{file} exists already; choose another name, or say that it is to be replaced")
    elif len(names(folder)) >= MOST_FILES:
        raise DataError(f"the folder holds {MOST_FILES} captures, the most that it may; remove some of them first")
    return path


def _iso(stamp: float) -> str:
    return datetime.fromtimestamp(stamp, UTC).isoformat(timespec="seconds")


__all__ = [
    "FORMATS",
    "MOST_BYTES",
    "MOST_FILES",
    "Capture",
    "checked_name",
    "find",
    "load",
    "names",
    "received",
    "save",
]
