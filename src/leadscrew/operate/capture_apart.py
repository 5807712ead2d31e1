"""Large texts as captures, read in a process of their own, so that a machine that runs in this one runs on undisturbed.

The process sends the capture back as a Parquet file. Its memory and time are bounded.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from leadscrew import apart as process
from leadscrew.kernel.errors import DataError
from leadscrew.operate.capture import Capture

SMALL = 200_000
"""Bytes of a text that is read at once here, within some 50 ms."""


def is_large_text(path: Path) -> bool:
    """Whether reading the file would hold up this process; Parquet and MATLAB files never do."""
    with path.open("rb") as file:
        head = file.read(7)
    text = not head.startswith((b"PAR1", b"MATLAB ")) and path.suffix.casefold() != ".mat"
    return text and path.stat().st_size > SMALL


def read(path: Path) -> Capture:
    """The capture of a file.

    Raises:
        DataError: it is refused, or its reader crashed, took too long or more memory than it may.
    """
    from leadscrew.operate import capture_formats

    with tempfile.TemporaryDirectory() as folder:
        sent = Path(folder) / "capture.parquet"
        process.run(__name__, path, sent)
        own = capture_formats.read(sent)
    if own is None:
        raise DataError(f"{path}: is broken so that its reader crashes; save it again, or as Parquet")
    return own


def apart(path: Path, out: Path) -> None:
    """Reads the file and writes it to ``out`` as a capture.

    Raises:
        DataError: it is refused.
    """
    from leadscrew import newfile
    from leadscrew.operate import capture_formats, capture_logs

    capture = capture_formats.read(path) or capture_logs.read(path)
    newfile.save(capture_formats.parquet_of(capture), out, durable=False)


__all__ = ["SMALL", "apart", "is_large_text", "read"]
