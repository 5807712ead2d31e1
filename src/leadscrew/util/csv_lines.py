"""Lines and numbers of a CSV file, each wrong one said with the file and the row as an editor counts them."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from leadscrew.util import reading
from leadscrew.util.errors import DataError


def read_lines(path: Path, expected: str) -> list[tuple[int, list[str]]]:
    """Row number and stripped cells of the header and of every row; empty lines and comments (#) are left out.

    ``expected`` says what the header line should hold, for the message about an empty file.

    Raises:
        DataError: no such file, too large, not UTF-8, not CSV, empty, or nothing below its header.
    """
    reader = csv.reader(reading.text(path, reading.POINTS, "tables of points").splitlines(), strict=True)
    lines: list[tuple[int, list[str]]] = []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells) and not cells[0].startswith("#"):
                lines.append((reader.line_num, cells))
    except csv.Error as problem:
        raise DataError(f"{path}, row {reader.line_num}: {problem}") from None
    if not lines:
        raise DataError(f"{path}: is empty; expected a header line with {expected}")
    if len(lines) == 1:
        raise DataError(f"{path}: has a header but no rows of data")
    return lines


def number(path: Path, row: int, column: str, cell: str) -> float:
    """The finite number of a cell.

    Raises:
        DataError: it is none.
    """
    try:
        value = float(cell)
    except ValueError:
        raise DataError(f"{path}, row {row}, column {column!r}: {cell!r} is not a number") from None
    if not math.isfinite(value):
        raise DataError(f"{path}, row {row}, column {column!r}: {cell!r} is not a finite number")
    return value
