"""Lines and numbers of a CSV file, each wrong one said with the file and the row as an editor counts them."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from leadscrew.kernel.errors import DataError


def text_of(path: Path) -> str:
    """The text of a file, without a byte order mark.

    Raises:
        DataError: no such file, or not UTF-8.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as problem:
        raise DataError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    except UnicodeDecodeError as problem:
        raise DataError(f"{path}: is not UTF-8 text (byte {problem.start})") from None


def read_lines(path: Path, expected: str) -> list[tuple[int, list[str]]]:
    """Row number and stripped cells of the header and of every row; empty lines and comments (#) are left out.

    ``expected`` says what the header line should hold, for the message about an empty file.

    Raises:
        DataError: no such file, not UTF-8, not CSV, empty, or nothing below its header.
    """
    text = text_of(path)
    reader = csv.reader(text.splitlines(), strict=True)
    try:
        lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as problem:
        raise DataError(f"{path}, row {reader.line_num}: {problem}") from None
    lines = [(n, row) for n, row in lines if any(row) and not row[0].startswith("#")]
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
