"""A capture: rows of a machine around a trigger, with the names and units of their columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused

MOST_BYTES = 50_000_000
"""Size of the largest capture: of its values, and of its file."""


@dataclass(frozen=True)
class Capture:
    """Rows that a scope took, or that a file holds.

    ``rows``: float64, shape (rows, columns); ``first_period``: number of the period of the first row; ``trigger_row``:
    the row at which it was triggered, 0 where it was not; ``about``: what it was taken of, as JSON can hold it.
    """

    name: str
    columns: tuple[str, ...]
    units: Mapping[str, str]
    period_s: float
    first_period: int
    trigger_row: int
    rows: np.ndarray
    about: Mapping[str, Any] = field(default_factory=dict)

    def signal(self, name: str) -> np.ndarray:
        """The values of one column.

        Raises:
            NameUnknown: no such column.
        """
        if name not in self.columns:
            raise NameUnknown(f"{self.name}: has no column {name!r}{nearest(name, list(self.columns))}")
        return self.rows[:, self.columns.index(name)]

    def time(self) -> np.ndarray:
        """Seconds after the trigger, of every row; s."""
        return (np.arange(len(self.rows)) - self.trigger_row) * self.period_s


def check(capture: Capture) -> None:
    """Passes where a capture can be saved.

    Raises:
        ValueRefused: rows that are not (n, columns) of float64, names that are no names, or more than 50 MB.
    """
    rows, columns = capture.rows, capture.columns
    if not isinstance(rows, np.ndarray) or rows.dtype != np.float64 or rows.shape[1:] != (len(columns),):
        raise ValueRefused(f"a capture of {len(columns)} columns needs rows of float64 of shape (n, {len(columns)})")
    if not len(rows) or not columns or len(set(columns)) < len(columns):
        raise ValueRefused("a capture needs at least one row, and one column or more, each of its own name")
    wrong = [c for c in columns if not c or " ".join(c.split()) != c or not c.isprintable() or c.startswith("#")]
    if wrong:
        raise ValueRefused(f"column {wrong[0]!r}: names of columns are printable, single-spaced, and start with no #")
    if rows.nbytes > MOST_BYTES:
        raise ValueRefused(
            f"a capture of {rows.nbytes / 1e6:.0f} MB; up to {MOST_BYTES / 1e6:.0f} MB are saved: take a shorter one"
        )
