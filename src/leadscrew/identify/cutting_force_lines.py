"""Cells of a table as texts: from CSV with commas, semicolons or tabs, or from Parquet."""

from __future__ import annotations

import csv
from pathlib import Path

from leadscrew import parquet, reading
from leadscrew.identify.log import PARQUET
from leadscrew.kernel.errors import DataError

Lines = list[tuple[int, list[str]]]


def read_cells(path: Path) -> Lines:
    """Row number (as an editor counts; of a Parquet file from 1) and cells of the header and of every row.

    Raises:
        DataError: it cannot be read, is empty, has no rows, or a row has not as many cells as the header.
    """
    return _parquet(path) if path.suffix.casefold() in PARQUET else _text(path)


def _text(path: Path) -> Lines:
    text = reading.text(path, reading.POINTS, "tables of points")
    kept = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not kept:
        raise DataError(f"{path}: is empty; expected a header line with feed, depth, force")
    if len(kept) == 1:
        raise DataError(f"{path}: has a header but no rows of data")
    first = kept[0][1]
    apart = next((sign for sign in ("\t", ";", ",") if sign in first), None)
    if apart is None:
        raise DataError(f"{path}, row {kept[0][0]}: {first!r} is one cell; expected commas, semicolons or tabs between")
    lines = []
    for n, line in kept:
        try:
            cells = next(csv.reader([line], delimiter=apart, strict=True))
        except csv.Error as problem:
            raise DataError(f"{path}, row {n}: {problem}") from None
        lines.append((n, [cell.strip() for cell in cells]))
        if len(cells) != len(lines[0][1]):
            hint = "; decimal commas need semicolons or tabs between the cells" if apart == "," else ""
            raise DataError(f"{path}, row {n}: {len(cells)} cells where the header has {len(lines[0][1])}{hint}")
    return lines


def _parquet(path: Path) -> Lines:
    held = parquet.read(path)
    if not held.rows:
        raise DataError(f"{path}: has columns but no rows of data")
    cells = [held.texts[n] if n in held.texts else [repr(v) for v in held.numbers[n].tolist()] for n in held.names]
    return [(0, held.names), *((n, list(row)) for n, row in enumerate(zip(*cells, strict=True), 1))]
