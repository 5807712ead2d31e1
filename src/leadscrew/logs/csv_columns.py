"""Named columns of a CSV file of numbers, checked before anything computes; errors name file, row and column."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.util.csv_lines import number, read_lines
from leadscrew.util.errors import DataError


def read_log(
    path: str | Path,
    columns: Sequence[str],
    increasing: str | None = None,
    within: str | None = None,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> dict[str, np.ndarray]:
    """The named columns of a CSV file as arrays; other columns are ignored, lines that start with ``#`` skipped.

    ``increasing`` names a column that must rise from row to row; with ``within``, it must rise among neighbouring
    rows of equal value in that column, for files that hold several records below one another. ``limits`` gives the
    range that a column's values must keep.

    Raises:
        DataError: no such file, no rows, a column missing or named twice, a row too short or too long, a cell that is
            no finite number or out of its range, or a column that does not rise.
    """
    path = Path(path)
    lines = read_lines(path, ", ".join(columns))
    header_row, header = lines[0]
    places = {name: _place(path, header_row, header, name) for name in columns}
    values = {name: np.empty(len(lines) - 1) for name in columns}
    for at, (row_number, row) in enumerate(lines[1:]):
        if len(row) != len(header):
            raise DataError(f"{path}, row {row_number}: {len(row)} cells where the header has {len(header)}")
        for name, place in places.items():
            values[name][at] = _number(path, row_number, name, row[place], (limits or {}).get(name))
    if increasing is not None:
        _check_rising(path, [n for n, _ in lines[1:]], values, increasing, within)
    return values


def _place(path: Path, row: int, header: list[str], name: str) -> int:
    if name not in header:
        raise DataError(f"{path}, row {row}: the column {name!r} is missing{nearest(name, header)}")
    if header.count(name) > 1:
        raise DataError(f"{path}, row {row}: the column {name!r} appears {header.count(name)} times")
    return header.index(name)


def _number(path: Path, row: int, column: str, cell: str, limits: tuple[float, float] | None) -> float:
    value = number(path, row, column, cell)
    if limits is not None and not limits[0] <= value <= limits[1]:
        raise DataError(f"{path}, row {row}, column {column!r}: {value:g} is outside [{limits[0]:g}, {limits[1]:g}]")
    return value


def _check_rising(
    path: Path, numbers: list[int], values: dict[str, np.ndarray], column: str, within: str | None
) -> None:
    for at in range(1, len(numbers)):
        before, now = values[column][at - 1], values[column][at]
        same_record = within is None or values[within][at] == values[within][at - 1]
        if same_record and not now > before:
            raise DataError(
                f"{path}, row {numbers[at]}, column {column!r}: {now:g} does not rise above {before:g} before it"
            )
