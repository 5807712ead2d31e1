"""Captures as Parquet, CSV and MAT: what is written, and read back unchanged.

All three hold every column, their units, and one line of JSON with the rest (name, period, trigger, what it was taken
of). They are plain tables besides: other programs, and ``leadscrew log``, read them as such.
"""

from __future__ import annotations

import csv
import io
import re
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from leadscrew import parquet, reading
from leadscrew.escape import one_line
from leadscrew.kernel.errors import DataError
from leadscrew.logs import mat
from leadscrew.operate.capture import MOST_BYTES, Capture
from leadscrew.operate.capture_text import capture_of, heard, said_of

_KEY = "leadscrew_capture"
_FIRST = "# leadscrew capture "
_MATLAB = (
    "break case catch classdef continue else elseif end for function global if otherwise parfor persistent return spmd "
    "switch try while leadscrew_capture"
)
"""Names that no variable of a MATLAB file may have."""

_COMPRESSED = 15
"""Type of a compressed element of a MATLAB file of version 5."""


def parquet_of(capture: Capture) -> bytes:
    """The bytes of a Parquet file: a field for each column with its unit as metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names, columns = _table(capture)
    units = {**capture.units, "time": "s"}
    fields = [pa.field(n, pa.float64(), metadata={"unit": units[n]} if units.get(n) else None) for n in names]
    schema = pa.schema(fields, metadata={_KEY: said_of(capture)})
    out = io.BytesIO()
    pq.write_table(pa.table([pa.array(c) for c in columns], schema=schema), out)
    return out.getvalue()


def csv_of(capture: Capture) -> bytes:
    """The bytes of a CSV file: comments, a header of ``name (unit)``, numbers in the fewest digits that are exact."""
    names, columns = _table(capture)
    units = {**capture.units, "time": "s"}
    out = io.StringIO(newline="")
    about = [
        f"# {key}: {one_line(str(value))}\n"
        for key, value in capture.about.items()
        if isinstance(value, str | float | int)
    ]
    out.write(f"{_FIRST}{one_line(capture.name)}\n# Sampling period is {capture.period_s!r} s\n{''.join(about)}")
    out.write(f"# {_KEY}: {said_of(capture)}\n")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([f"{n} ({one_line(units[n])})" if units.get(n) else n for n in names])
    writer.writerows(zip(*(map(repr, c.tolist()) for c in columns), strict=True))
    return out.getvalue().encode()


def mat_of(capture: Capture) -> bytes:
    """The bytes of a MATLAB file of version 5: a vector for each column, and a structure with their names and units."""
    from scipy.io import savemat

    names, columns = _table(capture)
    legal = _legal(names)
    units = {**capture.units, "time": "s"}
    said = {
        "json": said_of(capture, legal),
        "period_s": capture.period_s,
        "names": dict(zip(legal, names, strict=True)),
        "units": {short: units.get(name, "") for short, name in zip(legal, names, strict=True)},
    }
    out = io.BytesIO()
    held = {short: c.reshape(-1, 1) for short, c in zip(legal, columns, strict=True)}
    savemat(out, {**held, _KEY: said}, long_field_names=True)
    return out.getvalue()


def read(path: Path) -> Capture | None:
    """The capture of a file; None where the file is none of ours.

    Raises:
        DataError: it is one of ours and broken, or would be larger than 50 MB.
    """
    with path.open("rb") as file:
        head = file.read(128)
    kinds = ((b"PAR1", _parquet), (b"MATLAB ", _mat), (_FIRST.encode(), _csv))
    reader = next((r for start, r in kinds if head.startswith(start)), None)
    if reader is None:
        return None
    try:
        return reader(path)
    except DataError:
        raise
    except Exception as problem:  # The libraries raise errors of many kinds for a broken file.
        text = " ".join(str(problem).split())[:200] or type(problem).__name__
        raise DataError(f"{path}: cannot be read ({text})") from None


def _parquet(path: Path) -> Capture | None:
    held = parquet.read(path)
    _check_size(path, held.rows * max(1, len(held.names) - 1) * 8)
    if _KEY not in held.about:
        return None
    said = heard(path, held.about[_KEY])
    if missing := [n for n in said["columns"] if n not in held.numbers]:
        raise DataError(f"{path}: the column {missing[0]!r} that it says it has is missing")
    return capture_of(path, said, [held.numbers[n] for n in said["columns"]])


def _csv(path: Path) -> Capture:
    lines = reading.text(path, MOST_BYTES, "captures").split("\n")
    text = next((line for line in lines if line.startswith(f"# {_KEY}: ")), None)
    if text is None:
        raise DataError(f"{path}: lacks its line '# {_KEY}: ...'; without it and its first line it is read as a log")
    said = heard(path, text.partition(": ")[2])
    body = [(row, line) for row, line in enumerate(lines, start=1) if line.strip() and not line.startswith("#")]
    table = csv.reader((line for _, line in body), strict=True)
    width = len(next(table, []))
    columns = np.empty((width, max(0, len(body) - 1)))
    for at, cells in enumerate(table):
        try:
            columns[:, at] = [float(c) for c in cells]
        except ValueError as problem:
            wrong = f"{len(cells)} cells where the header has {width}" if len(cells) != width else problem
            raise DataError(f"{path}, row {body[at + 1][0]}: {wrong}") from None
    return capture_of(path, said, list(columns[-len(said["columns"]) :]))


def _mat(path: Path) -> Capture | None:
    _check_size(path, _inflated(reading.data(path, MOST_BYTES, "captures")))
    held = mat.loaded(path)
    if f"{_KEY}.json" not in held:
        return None
    said = heard(path, str(held[f"{_KEY}.json"]))
    return capture_of(path, said, [np.atleast_1d(held[n]) for n in said["variables"][-len(said["columns"]) :]])


def _inflated(data: bytes) -> int:
    """Bytes that the compressed elements of a MATLAB file would become, counted up to a little over the bound."""
    order, at, total = ">" if data[126:128] == b"MI" else "<", 128, 0
    while at + 8 <= len(data) and total <= 2 * MOST_BYTES:
        kind, size = struct.unpack_from(f"{order}II", data, at)
        left = data[at + 8 : at + 8 + size] if kind == _COMPRESSED else b""
        inflater = zlib.decompressobj()
        while left and total <= 2 * MOST_BYTES:
            total += len(inflater.decompress(left, 1_000_000))
            left = inflater.unconsumed_tail
        at += 8 + size
    return total


def _check_size(path: Path, size: int) -> None:
    if size > MOST_BYTES * 1.01:
        raise DataError(
            f"{path}: would be {size / 1e6:.0f} MB of values; captures up to {MOST_BYTES / 1e6:.0f} MB are read"
        )


def _table(capture: Capture) -> tuple[list[str], list[np.ndarray]]:
    """All columns, with the times before them where the capture has none."""
    names = list(capture.columns)
    columns = [np.ascontiguousarray(capture.rows[:, k]) for k in range(len(names))]
    if "time" in names:
        return names, columns
    return ["time", *names], [(capture.first_period + np.arange(len(capture.rows))) * capture.period_s, *columns]


def _legal(names: Sequence[str]) -> list[str]:
    """Names that MATLAB takes: letters, digits and underscores, at most 63, each once."""
    found: list[str] = []
    for name in names:
        text = re.sub(r"[^A-Za-z0-9_]", "_", name)
        text = (text if text[0].isalpha() and text not in _MATLAB.split() else f"x_{text}")[:58]
        count, free = 2, text
        while free in found:
            free, count = f"{text}_{count}", count + 1
        found.append(free)
    return found
