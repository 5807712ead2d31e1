"""Files of others as captures, read in a process of their own whose memory and time are bounded.

What may crash, hang or fill the memory is not in the process that runs a machine. The capture comes back as
:func:`~leadscrew.operate.capture_text.said_of`, a newline, and its rows as float64.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from leadscrew import apart as process
from leadscrew.operate.capture import Capture
from leadscrew.operate.capture_text import heard, said_of

SMALL = 200_000
"""Bytes of a text that is read at once here, within some 50 ms."""


def is_large_text(path: Path) -> bool:
    """Whether reading a file would hold up this process; Parquet and MATLAB files never do."""
    with path.open("rb") as file:
        head = file.read(7)
    text = not head.startswith((b"PAR1", b"MATLAB ")) and path.suffix.casefold() != ".mat"
    return text and path.stat().st_size > SMALL


def read(path: Path) -> Capture:
    """The capture of a file of any kind.

    Raises:
        DataError: it is refused, or its reader crashed, took too long or more memory than it may.
    """
    with tempfile.TemporaryDirectory() as folder:
        sent = Path(folder) / "capture"
        process.run(__name__, path, sent)
        said, _, rows = sent.read_bytes().partition(b"\n")
    told = heard(path, said.decode())
    return Capture(
        told["name"], tuple(told["columns"]), told["units"], told["period_s"], told["first_period"],
        told["trigger_row"], np.frombuffer(rows).reshape(told["rows"], -1).copy(), told["about"],
    )  # fmt: skip


def apart(path: Path, out: Path) -> None:
    """Reads the file and writes it to ``out`` as a capture.

    Raises:
        DataError: it is refused.
    """
    from leadscrew.operate import capture_formats, capture_logs

    capture = capture_formats.read(path) or capture_logs.read(path)
    out.write_bytes(said_of(capture).encode() + b"\n" + np.ascontiguousarray(capture.rows).tobytes())


__all__ = ["SMALL", "apart", "is_large_text", "read"]
