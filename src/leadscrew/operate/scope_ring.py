"""The last rows of a machine, in memory that is taken once and does not grow."""

from __future__ import annotations

import numpy as np


class Ring:
    """Keeps the last ``capacity`` rows of ``width`` doubles; every page of it is written at the start."""

    def __init__(self, capacity: int, width: int) -> None:
        self._rows = np.full((capacity, width), np.nan)
        self._end = 0
        self.held = 0

    def clear(self) -> None:
        """Forgets all rows."""
        self.held = 0

    def keep(self, rows: np.ndarray) -> None:
        """Adds rows, shape (n, width); the oldest ones make room."""
        capacity = len(self._rows)
        rows = rows[-capacity:]
        first = min(len(rows), capacity - self._end)
        self._rows[self._end : self._end + first] = rows[:first]
        self._rows[: len(rows) - first] = rows[first:]
        self._end = (self._end + len(rows)) % capacity
        self.held = min(capacity, self.held + len(rows))

    def last(self, n: int, column: int | None = None) -> np.ndarray:
        """A copy of the last ``n`` rows that are held, or of one column of them."""
        start = (self._end - n) % len(self._rows) if n else self._end
        part = self._rows if column is None else self._rows[:, column]
        return np.array(
            part[start : start + n] if start + n <= len(part) else np.concatenate([part[start:], part[: self._end]])
        )
