"""What a log file holds, as it is: columns of numbers, columns of text, constants, and the units that it names."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

SMALLEST, LARGEST = 1e-100, 1e100
"""Of the largest value of a column: beyond, squares and quotients leave the numbers of a computer."""


@dataclass(frozen=True)
class Table:
    """Columns of equal length, by the name that stands in the file."""

    columns: dict[str, np.ndarray]
    """Numbers; an empty cell is NaN."""
    units: dict[str, str]
    """Of columns and constants that name one, as the file writes it."""
    texts: dict[str, list[str]]
    """Columns of words, such as the phase of a cut."""
    source: str
    notes: list[str] = field(default_factory=list)
    """How the file was read, and what was left out, in sentences."""
    constants: dict[str, float] = field(default_factory=dict)
    """Single numbers beside the columns."""
    period: float | None = None
    """Seconds from row to row, where the file says so."""
    form: str = "text"
    """What kind of file it is, in words."""
    file_rows: np.ndarray | None = None
    """Row of the file, as an editor counts, of every row of the table; None where the file has no lines."""
    lost: tuple[int, ...] = ()
    """Rows of the table before which the recorder lost samples, by its own word."""
    blank: tuple[int, ...] = ()
    """Rows of the table before which the file has empty lines."""
    guess: dict[str, str] = field(default_factory=dict)
    """Column by role (time, drive, ...), where the form of the file settles it."""

    @property
    def rows(self) -> int:
        """How many."""
        lengths = [*map(len, self.columns.values()), *map(len, self.texts.values())]
        return lengths[0] if lengths else 0

    def place(self, row: int) -> str:
        """``row 17`` as an editor counts, or as a count of samples from 1."""
        return f"sample {row + 1}" if self.file_rows is None else f"row {self.file_rows[row]}"

    def name(self, wanted: str) -> str:
        """The full name of a column: itself, or the only one of that name without its unit.

        Raises:
            NameUnknown: there is none, or there are several.
        """
        from leadscrew.logs.header import bare

        known = [*self.columns, *self.texts]
        if wanted in known:
            return wanted
        fits = [name for name in known if bare(name) == wanted] or [
            name for name in known if bare(name).casefold() == wanted.casefold()
        ]
        if len(fits) > 1:
            raise NameUnknown(f"{self.source}: {wanted!r} fits {', '.join(fits)}; name one of them in full")
        if not fits:
            raise NameUnknown(f"{self.source}: has no column {wanted!r}{nearest(wanted, known)}")
        return fits[0]

    def numbers(self, wanted: str, kept: np.ndarray | None = None) -> np.ndarray:
        """A column of numbers, each finite; with ``kept`` only in the rows where that is true.

        Raises:
            NameUnknown: there is no such column, or there are several.
            DataError: it holds words, or something that is no finite number: file, row and column.
        """
        name = self.name(wanted)
        if name not in self.columns:
            raise DataError(f"{self.source}, column {name!r}: holds words, not numbers")
        values = np.asarray(self.columns[name], dtype=float)
        bad = np.flatnonzero(~np.isfinite(values) if kept is None else kept & ~np.isfinite(values))
        if len(bad):
            raise DataError(f"{self.source}, {self.place(int(bad[0]))}, column {name!r}: holds no finite number")
        largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        if not (largest == 0.0 or SMALLEST <= largest <= LARGEST):
            raise DataError(
                f"{self.source}, column {name!r}: its largest value is {largest:g}: is it the right column?"
            )
        return values

    def unit_of(self, column: str, role: str) -> str:
        """The unit that the file names for a column with a role; empty for none."""
        from leadscrew.logs.header import named_unit

        return named_unit(self.units.get(column, ""), column, role)

    def evenly(self, period: float) -> np.ndarray:
        """Times in s of rows that are ``period`` seconds apart.

        Raises:
            DataError: an empty line between two rows: a missing sample would shift all later times.
        """
        if self.blank:
            raise DataError(
                f"{self.source}: the line above {self.place(self.blank[0])} is empty, and times are counted by rows: "
                "delete the line if no sample is missing there, or take the times from a column"
            )
        return period * np.arange(self.rows)

    def seconds(self, wanted: str, unit: str | None = None, kept: np.ndarray | None = None) -> np.ndarray:
        """A column of times in seconds: its header's unit counts, ``unit`` replaces it, without one it is in seconds.

        Raises:
            NameUnknown: there is no such column, or there are several.
            ValueRefused: the unit is not one of time.
            DataError: as :meth:`numbers`.
        """
        from leadscrew.logs.units import time_in

        name = self.name(wanted)
        try:
            size = time_in(unit or self.unit_of(name, "time") or "s")
        except ValueRefused as error:
            raise ValueRefused(f"{self.source}, column {name!r}: {error}") from None
        return size * self.numbers(name, kept)
