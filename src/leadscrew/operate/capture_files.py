"""Captures as files: Parquet, CSV and MAT, written and read back unchanged, and logs of other programs.

The three formats hold every column, their units, and one line of JSON with the rest (name, period, trigger, what it was
taken of). They are plain tables besides: other programs, and ``leadscrew log``, read them as such. Logs of other
programs, and runs of ours, become captures to lay over others, by the names of their columns.

Files of others are read in a process of their own whose memory and time are bounded: what may crash, hang or fill the
memory is not in the process that runs a machine. The capture comes back as the line of JSON, a newline, and its rows as
float64.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
import struct
import tempfile
import zlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.logs import mat
from leadscrew.logs.header import bare, by_its_tail
from leadscrew.logs.read import read_table
from leadscrew.logs.table import Table
from leadscrew.operate.capture import MOST_BYTES, Capture, check
from leadscrew.util import parquet, reading
from leadscrew.util import separate_process as process
from leadscrew.util.errors import DataError, LeadscrewError, ValueRefused
from leadscrew.util.escape import one_line

MOST_TEXT = 4_000_000
"""Characters of what a capture says of itself."""


def said_of(capture: Capture, variables: Sequence[str] | None = None) -> str:
    """All but the rows, as a line of ASCII."""
    held = {
        "schema_version": 1, "name": capture.name, "columns": list(capture.columns), "units": dict(capture.units),
        "period_s": capture.period_s, "first_period": capture.first_period, "trigger_row": capture.trigger_row,
        "rows": len(capture.rows), "about": capture.about, **({"variables": list(variables)} if variables else {}),
    }  # fmt: skip
    return json.dumps(_plain(held), allow_nan=False)


def _plain(value: Any) -> Any:
    """A value that JSON can hold: arrays as lists, numbers that are not finite by name, others as their text."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(float(value))
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def heard(path: Path, text: str) -> dict[str, Any]:
    """What the line of JSON says, each part of it of its type."""
    if len(text) > MOST_TEXT:
        raise DataError(f"{path}: says {len(text) / 1e6:.0f} MB of itself besides its rows; up to 4 MB are read")
    said = reading.json_of(text, f"{path}: what is said of the capture")
    kinds = {
        "name": str, "columns": list, "units": dict, "period_s": float | int, "first_period": int, "trigger_row": int,
        "rows": int, "about": dict,
    }  # fmt: skip
    wrong = [k for k, kind in kinds.items() if not isinstance(said, dict) or not isinstance(said.get(k), kind)]
    if not wrong and (said.get("schema_version") != 1 or not all(isinstance(c, str) for c in said["columns"])):
        wrong = ["schema_version" if said.get("schema_version") != 1 else "columns"]
    if wrong:
        raise DataError(f"{path}: what is said of the capture has no sound {wrong[0]}; this version reads version 1")
    return said


def capture_of(path: Path, said: dict[str, Any], columns: Sequence[np.ndarray]) -> Capture:
    n, period = said["rows"], said["period_s"]
    if any(c.shape != (n,) or c.dtype != np.float64 for c in columns) or len(columns) != len(said["columns"]):
        raise DataError(f"{path}: its columns are not those that it says: {len(said['columns'])} of {n} numbers")
    if not 0.0 < period < math.inf or not 0 <= said["trigger_row"] < n:
        raise DataError(
            f"{path}: a period of {period!r} s and row {said['trigger_row']} of {n} as trigger fit no capture"
        )
    units = {str(k): str(v) for k, v in said["units"].items()}
    capture = Capture(
        said["name"], tuple(said["columns"]), units, float(period), said["first_period"], said["trigger_row"],
        np.column_stack(columns), said["about"],
    )  # fmt: skip
    try:
        check(capture)
    except ValueRefused as problem:
        raise DataError(f"{path}: {problem}") from None
    return capture


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

    names, columns = _timed(capture)
    units = {**capture.units, "time": "s"}
    fields = [pa.field(n, pa.float64(), metadata={"unit": units[n]} if units.get(n) else None) for n in names]
    schema = pa.schema(fields, metadata={_KEY: said_of(capture)})
    out = io.BytesIO()
    pq.write_table(pa.table([pa.array(c) for c in columns], schema=schema), out)
    return out.getvalue()


def csv_of(capture: Capture) -> bytes:
    """The bytes of a CSV file: comments, a header of ``name (unit)``, numbers in the fewest digits that are exact."""
    names, columns = _timed(capture)
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

    names, columns = _timed(capture)
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


def read_own(path: Path) -> Capture | None:
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


def _timed(capture: Capture) -> tuple[list[str], list[np.ndarray]]:
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


MOST_COLUMNS = 1000
_OPTIONS = re.compile(r"--start (\S+) --end (\S+)")
"""How the command line would cut a log; there is none here."""


def read_log(path: Path) -> Capture:
    """The columns of numbers of a log, with ``time`` in s first; its trigger is its first row.

    A column is called as in the file without a unit in brackets; times that scatter are kept, and ``about["notes"]``
    says so.

    Raises:
        DataError: as ``read_table``; more than 50 MB; neither times nor a sampling period, or times with gaps.
    """
    signals = path / "signals.parquet"
    if path.is_dir() and signals.is_file() and signals.stat().st_size > MOST_BYTES:
        raise DataError(f"{path}: has {signals.stat().st_size / 1e6:.0f} MB of signals; up to 50 MB are read")
    table = _log_table(path)
    if table.rows * len(table.columns) * 8 > MOST_BYTES:
        raise DataError(
            f"{path}: {table.rows} rows of {len(table.columns)} columns are more than {MOST_BYTES / 1e6:.0f} MB of "
            "values: cut it into parts, or keep fewer columns"
        )
    if len(table.columns) > MOST_COLUMNS:
        raise DataError(f"{path}: has {len(table.columns)} columns; captures up to {MOST_COLUMNS} columns are read")
    notes = list(table.notes)
    stamps = _time_column(table)
    time, period = _clock(table, stamps, notes)
    columns = {name: values for name, values in table.columns.items() if name != stamps}
    called = _called(list(columns))
    units = {called[n]: table.units[n] for n in columns if n in table.units}
    if table.texts:
        notes.append(f"left out, being words: {', '.join(table.texts)}")
    about = {"source": path.name, "form": table.form, "notes": notes, "values": dict(table.constants)}
    return Capture(
        path.stem, ("time", *called.values()), {"time": "s", **units}, period, round(time[0] / period), 0,
        np.column_stack([time, *columns.values()]), about,
    )  # fmt: skip


def _log_table(path: Path) -> Table:
    try:
        return read_table(path)
    except LeadscrewError:
        raise
    except Exception as problem:  # pyarrow raises errors of other kinds where the names in a broken file are no text.
        raise DataError(f"{path}: cannot be read ({' '.join(str(problem).split())[:200]})") from None


def _called(names: list[str]) -> dict[str, str]:
    """Names without the units in brackets behind them, where each stays one of its own."""
    short = {n: n if by_its_tail(n) else bare(n) for n in names}
    taken = Counter(["time", *short.values()])
    return {n: s if taken[s] == 1 else n if n != "time" else "time (2)" for n, s in short.items()}


def _time_column(table: Table) -> str | None:
    from leadscrew.logs.roles import candidates

    if settled := table.guess.get("time"):
        return settled
    fits = candidates(list(table.columns), "time")
    exact = [n for n in fits if bare(n).casefold() in ("time", "t")]
    return next(iter(exact or fits), None)


def _clock(table: Table, stamps: str | None, notes: list[str]) -> tuple[np.ndarray, float]:
    """Times in s and the period between them."""
    if stamps is None:
        if table.period is None:
            raise DataError(
                f"{table.source}: has neither a column of times nor a sampling period; add a column 'time (s)', or a "
                "comment such as '# Sampling period is 0.001 s'"
            )
        return table.evenly(table.period), table.period
    return _stamped(table, stamps, notes)


def _stamped(table: Table, stamps: str, notes: list[str]) -> tuple[np.ndarray, float]:
    from leadscrew.logs.sampling import clock
    from leadscrew.logs.units import time_in

    unit = table.units.get(stamps, "")
    try:
        time = table.columns[stamps] * (time_in(unit) if unit else 1.0)
    except LeadscrewError as problem:
        raise DataError(f"{table.source}, column {stamps!r}: {problem}") from None
    if not unit:
        notes.append(f"{stamps!r} names no unit: taken as seconds")
    if not np.isfinite(time).all():
        row = int(np.argmin(np.isfinite(time)))
        raise DataError(f"{table.source}, {table.place(row)}, column {stamps!r}: is no time")
    if len(time) < 3:
        raise DataError(f"{table.source}: has {len(time)} rows; expected three or more to tell its period")
    found = clock(time, table.place, table.lost)
    notes += [f.sentence for f in found.findings]
    if found.time is None:
        refused = next((f.sentence for f in found.findings if f.severity == "refused"), "its times are not even")
        refused = _OPTIONS.sub(r"from \1 s to \2 s", refused)
        raise DataError(f"{table.source}: {refused}")
    return time, float(found.period)


SMALL = 200_000
"""Bytes of a text that is read at once here, within some 50 ms."""


def is_large_text(path: Path) -> bool:
    """Whether reading a file would hold up this process; Parquet and MATLAB files never do."""
    with path.open("rb") as file:
        head = file.read(7)
    text = not head.startswith((b"PAR1", b"MATLAB ")) and path.suffix.casefold() != ".mat"
    return text and path.stat().st_size > SMALL


def read_apart(path: Path) -> Capture:
    """The capture of a file of any kind.

    Raises:
        DataError: it is refused, or its reader crashed, took too long or more memory than it may.
    """
    with tempfile.TemporaryDirectory() as folder:
        sent = Path(folder) / "capture"
        process.run(__name__, path, sent)
        said, _, rows = sent.read_bytes().partition(b"\n")
    told = heard(path, said.decode())
    return Capture(
        told["name"], tuple(told["columns"]), told["units"], told["period_s"], told["first_period"],
        told["trigger_row"], np.frombuffer(rows).reshape(told["rows"], -1).copy(), told["about"],
    )  # fmt: skip


def apart(path: Path, out: Path) -> None:
    """Reads the file and writes it to ``out`` as a capture.

    Raises:
        DataError: it is refused.
    """
    capture = read_own(path) or read_log(path)
    out.write_bytes(said_of(capture).encode() + b"\n" + np.ascontiguousarray(capture.rows).tobytes())
