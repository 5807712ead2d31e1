"""Names of files that pages give, seen without loading what reads the files."""

from __future__ import annotations

import re
from pathlib import Path

SUFFIXES = ("parquet", "csv", "mat", "pq", "txt", "tsv", "log", "dat")
"""As :data:`leadscrew.operate.captures.READ`."""
_CAPTURE = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}\.(?:" + "|".join(SUFFIXES) + r")\Z")


def is_capture_name(name: str) -> bool:
    """Whether a file of captures may be called so."""
    return _CAPTURE.match(name) is not None and ".." not in name


def capture_file(folder: Path, name: str) -> Path | None:
    """The file of that name, no link and nothing outside of the folder; None where there is none."""
    path = folder / name
    return path if is_capture_name(name) and path.is_file() and not path.is_symlink() else None


__all__ = ["SUFFIXES", "capture_file", "is_capture_name"]
