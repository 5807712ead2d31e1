"""Logs of other programs, and runs of ours, as captures to lay over others, by the names of their columns."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from leadscrew.kernel.errors import DataError, LeadscrewError
from leadscrew.logs.header import bare, by_its_tail
from leadscrew.logs.read import read_table
from leadscrew.logs.table import Table
from leadscrew.operate.capture import MOST_BYTES, Capture

MOST_COLUMNS = 1000
_OPTIONS = re.compile(r"--start (\S+) --end (\S+)")
"""How the command line would cut a log; there is none here."""


def read(path: Path) -> Capture:
    """The columns of numbers of a log, with ``time`` in s first; its trigger is its first row.

    A column is called as in the file without a unit in brackets; times that scatter are kept, and ``about["notes"]``
    says so.

    Raises:
        DataError: as ``read_table``; more than 50 MB; neither times nor a sampling period, or times with gaps.
    """
    signals = path / "signals.parquet"
    if path.is_dir() and signals.is_file() and signals.stat().st_size > MOST_BYTES:
        raise DataError(f"{path}: has {signals.stat().st_size / 1e6:.0f} MB of signals; up to 50 MB are read")
    table = _table(path)
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


def _table(path: Path) -> Table:
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


__all__ = ["read"]
