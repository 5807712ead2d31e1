"""What a check of an export found, and the golden vectors that it is checked by."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadscrew.export.core import Core, Record
from leadscrew.util.errors import DataError

IDENTICAL, DIFFERENT, NOT_RUN, FAILED = "identical", "different", "not run", "failed"
GOLDEN = "golden.csv"


@dataclass(frozen=True)
class Verdict:
    """One row of the table that ``leadscrew verify-export`` prints."""

    target: str
    """What ran: ``c99 gcc -O2``, ``hal halrun``, ``fmu2 FMPy``."""
    verdict: str
    """``identical``, ``different``, ``not run`` (something is missing here) or ``failed`` (it should have run)."""
    cycles: int = 0
    worst: float | None = None
    """Largest difference of an output, in its unit; ``None`` where nothing was compared."""
    note: str = ""
    """Version of the tool that judged, or why it did not."""


def golden_text(core: Core, record: Record) -> str:
    """The golden vectors as CSV, every number exactly (the shortest decimal that reads back as the same bits)."""
    names = [*(p.name for p in core.inputs), *(p.name for p in core.outputs)]
    rows = np.column_stack([record.inputs, record.outputs])
    return "\n".join([",".join(names), *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n"


def read_golden(file: Path) -> tuple[list[str], np.ndarray]:
    """Column names and rows of golden vectors.

    Raises:
        DataError: no such file, or not a table of numbers.
    """
    try:
        with file.open(encoding="utf-8", newline="") as lines:
            names, *rows = list(csv.reader(lines))
        return names, np.array([[float(x) for x in row] for row in rows]).reshape(len(rows), len(names))
    except OSError as error:
        raise DataError(f"{file}: {error.strerror or error}") from None
    except ValueError as error:
        raise DataError(f"{file}: not a table of golden vectors: {error}") from None


def compared(target: str, expected: np.ndarray, got: np.ndarray, note: str = "") -> Verdict:
    """The verdict on two tables of outputs: equal in every bit (any NaN equals any NaN), or by how much not."""
    if expected.shape != got.shape:
        return Verdict(target, FAILED, len(got), None, f"{len(got)} rows came back, {len(expected)} were expected")
    same = (expected.view(np.int64) == got.view(np.int64)) | (np.isnan(expected) & np.isnan(got))
    worst = float(np.max(np.abs(np.where(same, 0.0, expected - got)), initial=0.0))
    return Verdict(target, IDENTICAL if bool(same.all()) else DIFFERENT, len(expected), worst, note)
