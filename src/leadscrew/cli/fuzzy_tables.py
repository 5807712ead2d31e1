"""Tables of numbers that the commands of ``leadscrew fuzzy`` read and write: CSV, Parquet, ``.fld``."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.newfile import save

if TYPE_CHECKING:
    import numpy as np


def columns_of(path: Path) -> list[str]:
    """The names of the columns of a CSV or Parquet file.

    Raises:
        DataError: it cannot be read.
    """
    if path.suffix.casefold() == ".parquet":
        from leadscrew import parquet

        return parquet.read(path).names
    from leadscrew.fuzzy.formats.place import load

    lines = (line for line in load(path)[0].splitlines() if line.strip() and not line.lstrip().startswith("#"))
    return [cell.strip().strip('"') for cell in next(lines, "").split(",")]


def table_of(path: Path, columns: Sequence[str]) -> dict[str, np.ndarray]:
    """Columns of a CSV or Parquet file as numbers.

    Raises:
        DataError: no such file, a column missing, or a cell that is no finite number: says row and column.
    """
    if path.suffix.casefold() != ".parquet":
        from leadscrew.identify.log import read_log

        return read_log(path, columns)
    import numpy as np

    from leadscrew import parquet
    from leadscrew.kernel.sheet import nearest

    table, found = parquet.read(path), {}
    for name in columns:
        if name in table.texts or name in table.other:
            raise DataError(f"{path}: the column {name!r} holds no numbers")
        if name not in table.numbers:
            raise DataError(f"{path}: the column {name!r} is missing{nearest(name, table.names)}")
        found[name] = table.numbers[name]
        bad = ~np.isfinite(found[name])
        if bad.any():
            at = int(np.argmax(bad))
            raise DataError(f"{path}, row {at + 1}, column {name!r}: {found[name][at]} is not a finite number")
    if not table.rows:
        raise DataError(f"{path}: has no rows of data")
    return found


def save_table(names: Sequence[str], rows: np.ndarray, path: Path) -> None:
    """Writes columns of numbers as CSV, Parquet or ``.fld``, by the suffix.

    Raises:
        ValueRefused: a name that ``.fld`` cannot express.
        DataError: it cannot be written.
    """
    kind = path.suffix.casefold()
    if kind == ".parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        held = io.BytesIO()
        pq.write_table(pa.table([rows[:, i] for i in range(len(names))], names=list(names)), held)
        save(held.getvalue(), path)
        return
    if kind == ".fld" and (spaced := [n for n in names if not n or any(c.isspace() for c in n)]):
        raise ValueRefused(f"a .fld file cannot express the name {spaced[0]!r}: it is empty or holds a space")
    save(text_table(names, rows, " " if kind == ".fld" else ",").encode(), path)


def text_table(names: Sequence[str], rows: np.ndarray, between: str = ",") -> str:
    """Columns of numbers as text, each number in the fewest digits that give it back."""
    import csv

    held = io.StringIO()
    writer = csv.writer(held, delimiter=between, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([repr(x) for x in row] for row in rows.tolist())
    return held.getvalue()
