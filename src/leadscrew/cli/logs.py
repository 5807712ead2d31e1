"""Logs for the commands that look at signals: a file of columns, or the folder of a run, and a part of its time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    import numpy as np


def part_of(
    log: Path, time: str, names: Sequence[str], start: float | None = None, end: float | None = None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times in s and the named columns of a log, or of a folder of ``simulate --out``, from start to end.

    Raises:
        DataError: the file cannot be read, or nothing lies between ``start`` and ``end``.
        ValueRefused: the column of times asked for as a signal, or a unit in its header that is not one of time.
    """
    from leadscrew.logs import read_table

    if time in names:
        raise ValueRefused(f"{time!r} is the column of times: expected another one as a signal")
    table = read_table(log)
    t, read = table.seconds(time), {name: table.numbers(name) for name in names}
    kept = (t >= (t[0] if start is None else start)) & (t <= (t[-1] if end is None else end))
    if not kept.any():
        raise DataError(
            f"{log}: runs from {t[0]:g} to {t[-1]:g} s; nothing of it lies from {t[0] if start is None else start:g} "
            f"to {t[-1] if end is None else end:g} s"
        )
    return t[kept], {name: read[name][kept] for name in names}


def numbers(text: str | None, option: str) -> tuple[float, ...]:
    """Numbers with commas between them.

    Raises:
        ValueRefused: something else.
    """
    if text is None:
        return ()
    try:
        return tuple(float(x) for x in text.split(","))
    except ValueError:
        raise ValueRefused(f"{option} {text!r}: expected numbers with commas between them, for example 3,5,7") from None
