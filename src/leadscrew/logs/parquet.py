"""Parquet files as tables: units from the fields' metadata or the columns' names."""

from __future__ import annotations

from pathlib import Path

from leadscrew import parquet
from leadscrew.logs.header import split
from leadscrew.logs.table import Table


def read_parquet(path: Path) -> Table:
    """The table of a Parquet file.

    Raises:
        DataError: it cannot be read, or is too large.
    """
    held = parquet.read(path)
    units = {name: unit for name in held.numbers if (unit := held.units.get(name) or split(name)[1])}
    notes = [f"left out, being neither numbers nor words: {', '.join(held.other)}"] if held.other else []
    return Table(held.numbers, units, held.texts, str(path), notes, form="Parquet")
