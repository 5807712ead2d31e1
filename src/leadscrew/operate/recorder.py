"""Columns kept while a machine runs whose controller, and with it some columns, may change on the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadscrew.kernel.live import MEMORY
from leadscrew.kernel.loop import RECORDED
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused

EVERYTHING = "*"
"""Stands for all columns."""


class Recorder:
    """Keeps the columns that a list of names stands for; ``None`` for the standard ones, ``()`` for none."""

    def __init__(self, record: str | Sequence[str] | None, periods: int) -> None:
        self.wanted = tuple([record] if isinstance(record, str) else RECORDED if record is None else record)
        self.standard = record is None
        self.rows = 0
        self._periods = periods
        self._pieces: list[tuple[list[str], int, np.ndarray]] = []
        self._columns: list[str] | None = None
        self._chosen: list[int] = []

    def feed(self, columns: list[str], rows: np.ndarray) -> None:
        """Keeps what is wanted of some rows.

        Raises:
            NameUnknown: no such column.
            ValueRefused: more than memory allows.
        """
        if not self.wanted:
            return
        if columns is not self._columns:
            self._columns, self._chosen = columns, self._choice(columns)
        self._pieces.append((columns, self.rows, rows[:, self._chosen]))
        self.rows += len(rows)

    def _choice(self, columns: list[str]) -> list[int]:
        chosen = [0]
        for wanted in self.wanted:
            found = [i for i, c in enumerate(columns) if _below(wanted, c)]
            if not found and not self.standard and not self._pieces:
                raise NameUnknown(f"there is no signal {wanted!r}{nearest(wanted, columns)}")
            chosen += [i for i in found if i not in chosen]
        size = self._periods * len(chosen) * 8
        if size > MEMORY:
            raise ValueRefused(
                f"recording {self._periods} rows of {len(chosen)} signals needs {size / 1e9:.0f} GB: record fewer"
            )
        return chosen

    def signals(self) -> dict[str, np.ndarray]:
        """The columns, each as long as the run."""
        kept: dict[str, np.ndarray] = {}
        for columns, first, rows in self._pieces:
            chosen = [columns[i] for i in (self._choice(columns) if columns is not self._columns else self._chosen)]
            for i, name in enumerate(chosen):
                if name not in kept:
                    kept[name] = np.full(self.rows, np.nan)
                kept[name][first : first + len(rows)] = rows[:, i]
        return kept


def _below(wanted: str, column: str) -> bool:
    """Whether a column is meant by a name: itself, a part of it, or the same of the second axis."""
    own = column.removeprefix("y.")
    return wanted == EVERYTHING or any(c == wanted or c.startswith(f"{wanted}.") for c in (own, column))
