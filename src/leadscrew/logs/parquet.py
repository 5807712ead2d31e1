"""Parquet files: columns of numbers, of words, of truth values and of times; units from the fields' metadata."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.kernel.errors import DataError
from leadscrew.logs.header import split
from leadscrew.logs.table import Table, check_cells, check_size


def read_parquet(path: Path) -> Table:
    """The table of a Parquet file.

    Raises:
        DataError: it cannot be read, or is too large.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    check_size(path)
    try:
        shape = pq.read_metadata(path)
        check_cells(str(path), shape.num_rows, shape.num_columns)
        held = pq.read_table(path)
        names = Counter(held.column_names)
    except (OSError, UnicodeDecodeError, pa.ArrowException) as problem:
        raise DataError(f"{path}: cannot be read ({(str(problem).splitlines() or [''])[0][:200]})") from None
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    texts: dict[str, list[str]] = {}
    other = []
    for field in held.schema:
        if names[field.name] > 1:
            raise DataError(f"{path}: the column {field.name!r} appears {names[field.name]} times")
        values, unit = _numbers(held.column(field.name), pa)
        unit = unit or (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace") or split(field.name)[1]
        if values is not None:
            columns[field.name] = values
            units.update({field.name: unit} if unit else {})
        elif pa.types.is_string(field.type) or pa.types.is_large_string(field.type):
            texts[field.name] = [x or "" for x in held.column(field.name).to_pylist()]
        else:
            other.append(field.name)
    notes = [f"left out, being neither numbers nor words: {', '.join(other)}"] if other else []
    return Table(columns, units, texts, str(path), notes, form="Parquet")


def _numbers(column: Any, pa: Any) -> tuple[np.ndarray | None, str]:
    """A column as numbers, and the unit where its type settles it; None where it is none."""
    kind, unit = column.type, ""
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        # Counted from the first, so that a double holds a nanosecond of a log of weeks.
        counts = column.cast(pa.int64()).to_numpy(zero_copy_only=False).astype(float, copy=True)
        whole = column.cast(pa.int64()).drop_null()
        first = whole[0].as_py() if len(whole) else 0
        if not column.null_count:
            counts = (column.cast(pa.int64()).to_numpy() - first).astype(float)
        return counts * {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[kind.unit], "s"
    if pa.types.is_boolean(kind):
        column = column.cast(pa.int8())
    elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        return None, unit
    return np.array(column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=float), unit
