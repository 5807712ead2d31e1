"""Logs of commanded and actual positions from files: which columns belong together, and how far apart the rows are.

Columns are found by the words of their names: ``X1_CommandPosition`` and ``X1_ActualPosition``, ``x-pos-cmd`` and
``x-pos-fb``, ``command`` and ``feedback``; else by what ``leadscrew log`` takes for command and position, where there
is one of each; with pairs given, those. A velocity belongs to a position of the same name but for the word.
"""

from __future__ import annotations

import glob
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from leadscrew.analysis.following import Log
from leadscrew.analysis.following_odd import Track
from leadscrew.kernel.errors import DataError, NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest
from leadscrew.logs.header import bare
from leadscrew.logs.roles import candidates
from leadscrew.logs.table import Table

NAMES = (
    ("CommandPosition", "ActualPosition", "CommandVelocity", "ActualVelocity"),
    ("command_position", "actual_position", "command_velocity", "actual_velocity"),
    ("pos-cmd", "pos-fb", "vel-cmd", "vel-fb"),
    ("command", "feedback", "command_velocity", "feedback_velocity"),
    ("command", "position", "command_velocity", "velocity"),
    ("command", "actual", "command_velocity", "actual_velocity"),
)
"""Endings of the four columns of an axis, most particular first."""
SUFFIXES = (".csv", ".tsv", ".txt", ".parquet", ".pq", ".mat")


def paths_of(given: Sequence[str | Path]) -> list[Path]:
    """Files; of a folder that is no run all logs in it, of a pattern with ``*`` all that it fits; in order of names.

    Raises:
        DataError: a pattern or a folder without a log, or a file named twice.
    """
    found: list[Path] = []
    for text in given:
        path = Path(text)
        if path.is_dir() and not (path / "manifest.json").exists() and not (path / "signals.parquet").exists():
            inside = sorted(p for p in path.iterdir() if p.suffix.casefold() in SUFFIXES)
        elif not path.exists() and glob.has_magic(str(text)):
            inside = sorted(map(Path, glob.glob(str(text))))  # noqa: PTH207
        else:
            inside = [path]
        if not inside:
            raise DataError(f"{text}: no log there; expected files that end in {', '.join(SUFFIXES)}")
        found += inside
    for path in found:
        if found.count(path) > 1:
            raise DataError(f"{path}: named twice; each log counts once")
    return found


def read_logs(
    paths: Sequence[str | Path],
    *,
    period: float | None = None,
    time: str | None = None,
    by: str | None = None,
    pairs: Mapping[str, tuple[str, str]] | None = None,
    units: Mapping[str, str] | None = None,
    start: float | None = None,
    end: float | None = None,
) -> list[Log]:
    """The logs of some files, folders or patterns (:func:`paths_of`).

    ``period`` in seconds is needed where the files have no column of times; ``by`` names the column of phases;
    ``pairs`` has the columns of commanded and actual position of an axis by its name; ``units`` the unit of ``time``,
    ``position`` (or ``command`` and ``actual``) and ``velocity``, where headers name none or a wrong one;
    ``start`` and ``end`` are times of the log in seconds, from its first row where it has no column of times.

    Raises:
        DataError: a file that cannot be read, lacks an axis, a time or a number, or units that do not go together.
        NameUnknown: no such column.
        ValueRefused: no such unit.
    """
    from leadscrew.analysis.following_units import checked
    from leadscrew.logs import read_table

    found, told = [], checked(units or {})
    for path in paths_of(paths):
        table = _part(read_table(path), period, time, told.get("time"), start, end)
        step = _period(table, period, time, told.get("time"))
        tracks = _tracks(table, pairs or {}, told)
        phase = None if by is None else _phases(table, by)
        found.append(Log(str(path), tracks, step, phase, _numbers(table)))
    return found


def _period(table: Table, period: float | None, time: str | None, unit: str | None) -> float:
    from leadscrew.logs.sampling import clock

    name = _time_of(table, time)
    if period is not None:
        table.evenly(period)
        return period
    if name is None:
        if table.period is None:
            raise DataError(
                f"{table.source}: has no column of times; say how far apart its rows are, as in --period 0.1, or name "
                "the column with --time"
            )
        table.evenly(table.period)
        return table.period
    try:
        seen = clock(table.seconds(name, unit), table.place)
    except DataError as problem:
        raise DataError(f"{table.source}: {problem}") from None
    wrong = [f for f in seen.findings if f.severity == "refused"]
    if wrong or seen.time is None:
        raise DataError(f"{table.source}, {name}: {wrong[0].sentence if wrong else 'times do not rise evenly'}")
    return seen.period


def _time_of(table: Table, time: str | None) -> str | None:
    """The column of times, as named or by its name."""
    names = [time] if time is not None else candidates(list(table.columns), "time")[:1]
    return table.name(names[0]) if names else None


def _part(
    table: Table, period: float | None, time: str | None, unit: str | None, start: float | None, end: float | None
) -> Table:
    """The rows from ``start`` to ``end``, s."""
    if start is None and end is None:
        return table
    name, step = _time_of(table, time), period or table.period
    if name is None and step is None:
        raise DataError(f"{table.source}: has no column of times; say how far apart its rows are, as in --period 0.1")
    at = table.evenly(step) if step and (name is None or period is not None) else table.seconds(name or "", unit)
    low, high = -np.inf if start is None else start, np.inf if end is None else end
    kept = (at >= low - 1e-9) & (at <= high + 1e-9)
    if not kept.any():
        raise DataError(f"{table.source}: has no row from {low:g} to {high:g} s: its rows are of {at.min():g} to "
                        f"{at.max():g} s")  # fmt: skip
    return replace(
        table, columns={n: c[kept] for n, c in table.columns.items()},
        texts={n: [w for w, k in zip(words, kept, strict=True) if k] for n, words in table.texts.items()},
        file_rows=None if table.file_rows is None else table.file_rows[kept],
    )  # fmt: skip


def _column(table: Table, name: str) -> np.ndarray:
    if name not in table.columns:
        raise NameUnknown(f"{table.source}: has no column of numbers {name!r}{nearest(name, list(table.columns))}")
    values = table.columns[name]
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise DataError(f"{table.source}, {table.place(int(bad[0]))}, column {name!r}: no finite number there")
    return values


def _tracks(table: Table, pairs: Mapping[str, tuple[str, str]], units: Mapping[str, str]) -> dict[str, Track]:
    from leadscrew.analysis.following_units import in_one_unit

    columns = _columns(table, pairs)
    found = {}
    for axis, names in columns.items():
        read = {role: _column(table, name) for role, name in names.items()}
        track = Track(axis, read["command"], read["actual"], read.get("command_speed"), read.get("actual_speed"))
        found[axis] = in_one_unit(track, names, table, units)
    return found


def _columns(table: Table, pairs: Mapping[str, tuple[str, str]]) -> dict[str, dict[str, str]]:
    """Column by role (``command``, ``actual``, ``command_speed``, ``actual_speed``) of every axis."""
    roles = ("command", "actual", "command_speed", "actual_speed")
    if pairs:
        return {axis: {r: table.name(n) for r, n in zip(roles, pair, strict=False)} for axis, pair in pairs.items()}
    found: dict[str, dict[str, str]] = {}
    names = {bare(name): name for name in table.columns}
    for endings in NAMES:
        for name in names:
            stem = name.removesuffix(endings[0])
            axis = stem.strip("_-. ") or "axis"
            if not name.endswith(endings[0]) or axis in found or stem + endings[1] not in names:
                continue
            both = zip(roles, endings, strict=True)
            found[axis] = {role: names[stem + end] for role, end in both if stem + end in names}
    if found:
        return found
    only = {role: candidates(list(table.columns), role) for role in ("command", "position")}
    if all(len(fits) == 1 for fits in only.values()):
        return {"axis": {"command": only["command"][0], "actual": only["position"][0]}}
    raise DataError(
        f"{table.source}: no two columns are commanded and actual position of an axis (as X1_CommandPosition and "
        f"X1_ActualPosition); say which, as in --pair X=COMMAND,ACTUAL; columns: {', '.join(table.columns)}"
    )


def _phases(table: Table, by: str) -> list[str]:
    name = table.name(by)
    return list(table.texts[name]) if name in table.texts else [f"{x:g}" for x in _column(table, name)]


def _numbers(table: Table) -> np.ndarray:
    """All columns of numbers but those that count rows."""
    kept = [c for c in table.columns.values() if len(c) < 2 or not np.all(np.diff(c) > 0.0)]
    return np.column_stack(kept) if kept else np.zeros((table.rows, 0))


def pair_of(text: str) -> tuple[str, tuple[str, str]]:
    """``X=COMMAND,ACTUAL`` as an axis and its two columns.

    Raises:
        ValueRefused: something else.
    """
    axis, equals, names = text.partition("=")
    parts = [n.strip() for n in names.split(",")]
    if not equals or not axis.strip() or len(parts) != 2 or not all(parts):
        raise ValueRefused(f"--pair {text!r}: expected AXIS=COMMAND,ACTUAL, an axis and two columns")
    return axis.strip(), (parts[0], parts[1])
