"""Parquet files: columns of numbers, words, truth values and times, read by :mod:`leadscrew.util.separate_process`.

A small file can stand for a large table, a broken one can crash its reader: nested columns are not read, the size of
the table is checked before, the rest is bounded by the process.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.util import reading
from leadscrew.util import separate_process as process
from leadscrew.util.errors import DataError

MOST_WORDS = 100_000_000
"""Characters of all columns of words, and eight for each of their cells."""


@dataclass(frozen=True)
class Columns:
    """What a file holds."""

    names: list[str]
    """Of all columns that are read, in the order of the file."""
    numbers: dict[str, np.ndarray]
    """Columns of float64; an empty cell is NaN, a truth value 0 or 1, a time counted in s from the first."""
    texts: dict[str, list[str]]
    """Columns of words; an empty cell is an empty word."""
    units: dict[str, str]
    """``s`` of a time, or the ``unit`` of the column's metadata."""
    other: list[str]
    """Columns that are neither."""
    about: dict[str, str]
    """Metadata of the file."""

    @property
    def rows(self) -> int:
        """How many."""
        return max((*map(len, self.numbers.values()), *map(len, self.texts.values())), default=0)


def read(path: Path) -> Columns:
    """The columns of a Parquet file.

    Raises:
        DataError: it cannot be read, is too large, or has two columns of a name.
    """
    reading.check_log(path)
    with tempfile.TemporaryDirectory() as folder:
        sent = Path(folder) / "columns.npz"
        process.run(__name__, path, sent)
        with np.load(sent, allow_pickle=False) as held:
            said = json.loads(held["said"].tobytes())
            numbers = {name: held[f"a{k}"] for k, name in enumerate(said.pop("numbers"))}
    return Columns(numbers=numbers, **said)


def apart(path: Path, out: Path) -> None:
    """Reads the file and writes what it holds to ``out``.

    Raises:
        DataError: as :func:`read`.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        said, numbers = _held(path, pa, pq)
    except (OSError, UnicodeDecodeError, pa.ArrowException) as problem:
        if isinstance(problem, MemoryError):
            raise
        first = (str(problem).splitlines() or [""])[0][:200]
        raise DataError(f"{path}: cannot be read ({getattr(problem, 'strerror', None) or first})") from None
    arrays = {f"a{k}": column for k, column in enumerate(numbers)}
    np.savez(out, allow_pickle=False, said=np.frombuffer(json.dumps(said).encode(), np.uint8), **arrays)


def _held(path: Path, pa: Any, pq: Any) -> tuple[dict[str, Any], list[np.ndarray]]:
    file = pq.ParquetFile(path)
    schema, shape = file.schema_arrow, file.metadata
    about = {
        k.decode("utf-8", "replace"): v.decode("utf-8", "replace")
        for k, v in (schema.metadata or {}).items() if k != b"ARROW:schema"
    }  # fmt: skip
    for name, count in Counter(schema.names).items():
        if count > 1:
            raise DataError(f"{path}: the column {name!r} appears {count} times")
    words = [f.name for f in schema if _is_text(f.type, pa)]
    flat = [f.name for f in schema if f.name in set(words) or _is_number(f.type, pa)]
    reading.check_columns(str(path), len(schema.names))
    reading.check_cells(str(path), shape.num_rows, len(flat))
    if words:
        file = pq.ParquetFile(path, read_dictionary=words)
    held: Any = file.read(columns=flat)
    numbers: dict[str, np.ndarray] = {}
    texts: dict[str, list[str]] = {}
    units: dict[str, str] = {}
    room = MOST_WORDS * reading.factor()
    for field in schema:
        if field.name in words:
            column = held.column(field.name)
            room -= sum(_characters(part, pa) for part in column.chunks)
            if room < 0.0:
                raise DataError(
                    f"{path}: its columns of words hold more than {MOST_WORDS / 1e6:.0f} million characters"
                )
            texts[field.name] = [x or "" for x in column.to_pylist()]
        elif field.name in flat:
            numbers[field.name] = _numbers(held.column(field.name), pa)
        unit = "s" if _is_time(field.type, pa) else (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace")
        units |= {field.name: unit} if unit else {}
    other = [name for name in schema.names if name not in flat]
    said = {"names": flat, "numbers": list(numbers), "texts": texts, "units": units, "other": other, "about": about}
    return said, list(numbers.values())


def _is_text(kind: Any, pa: Any) -> bool:
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind)) or (
        pa.types.is_dictionary(kind) and _is_text(kind.value_type, pa)
    )


def _is_time(kind: Any, pa: Any) -> bool:
    return bool(pa.types.is_timestamp(kind) or pa.types.is_duration(kind))


def _is_number(kind: Any, pa: Any) -> bool:
    return bool(
        _is_time(kind, pa) or pa.types.is_boolean(kind) or pa.types.is_integer(kind) or pa.types.is_floating(kind)
    )


def _characters(part: Any, pa: Any) -> int:
    """Bytes of the cells of a column of words, and eight for each."""
    import pyarrow.compute as pc

    if not pa.types.is_dictionary(part.type):
        return int(pc.sum(pc.binary_length(part)).as_py() or 0) + 8 * len(part)
    lengths = np.array(pc.binary_length(part.dictionary).fill_null(0), dtype=np.int64)
    at = np.array(part.indices.drop_null(), dtype=np.int64)
    return int(lengths[at].sum()) + 8 * len(part)


def _numbers(column: Any, pa: Any) -> np.ndarray:
    kind = column.type
    if _is_time(kind, pa):
        # Counted from the first, so that a double holds a nanosecond of a log of weeks.
        counts = column.cast(pa.int64()).to_numpy(zero_copy_only=False).astype(float, copy=True)
        if not column.null_count and len(column):
            whole = column.cast(pa.int64()).to_numpy()
            counts = (whole - whole[0]).astype(float)
        return np.asarray(counts * {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[kind.unit])
    if pa.types.is_boolean(kind):
        column = column.cast(pa.int8())
    return np.array(column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=float)


__all__ = ["Columns", "apart", "read"]
