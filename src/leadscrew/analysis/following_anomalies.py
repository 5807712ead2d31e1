"""What is odd about a log of commanded and actual positions: order of rows, counters that wrap, torn and frozen rows.

Nothing is repaired. Rows in which no axis can have been are left out of the tables and named; rows out of order break
the log into stretches, within which alone anything that needs time is computed.

How coarsely a column of a log was written: fixed decimals, significant digits, or both.

A position that was written with three digits has a step of 1 mm at 141 mm and of 0.1 mm at 72.4 mm. An error between
two such columns is known to that step only, whatever the encoder resolves.

Units of the columns of a following error: everything of an axis in the unit of its command.

A header that names a unit (``X [mm]``) is taken at its word; what the caller tells comes first. Where a column names
none it is taken to be in the unit of the others, as logs of one control are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from leadscrew.logs.finding import Finding
from leadscrew.logs.signals import excess, jumps
from leadscrew.logs.table import Table
from leadscrew.logs.units import length_in, speed_in, time_in
from leadscrew.util.errors import DataError, ValueRefused

MOST_DIGITS = 7
MOST_DECIMALS = 9


def digits(values: np.ndarray) -> int | None:
    """The least number of significant digits, up to 7, that all values are written with; None where more are used."""
    return next((d for d in range(1, MOST_DIGITS + 1) if _same(values, _to_digits(values, d))), None)


def decimals(values: np.ndarray) -> int | None:
    """The least number of decimals, up to 9, that all values are written with; None where more are used."""
    return next((d for d in range(MOST_DECIMALS + 1) if _same(values, np.round(values, d))), None)


def steps(values: np.ndarray) -> np.ndarray:
    """The step of each value: the coarser of its last significant digit and the column's last decimal; 0: unknown.

    Each is a grid that all values lie on, so the coarser one holds.
    """
    held = np.abs(np.asarray(values, float))
    found = np.zeros(held.shape)
    count, places = digits(held), decimals(held)
    if count is not None:
        found = np.where(held > 0.0, 10.0 ** (_decade(held) - count + 1), 0.0)
    return found if places is None else np.maximum(found, 10.0**-places)


def _decade(held: np.ndarray) -> np.ndarray:
    return np.floor(np.log10(np.where(held > 0.0, held, 1.0)) + 1e-12)


def _to_digits(values: np.ndarray, count: int) -> np.ndarray:
    step = 10.0 ** (_decade(np.abs(values)) - count + 1)
    return np.round(values / step) * step


def _same(values: np.ndarray, rounded: np.ndarray) -> bool:
    return bool(np.all(np.abs(values - rounded) <= 1e-9 * np.maximum(np.abs(values), 1e-30)))


TORN = 1.5
"""An error larger than what the axis travels in so many periods and in twice its usual lag, and than two steps, is no
following error."""
WRAP = 0.95
"""A jump against the motion by this share of all that a counter showed is a wrap."""
FEW = 20
"""Rows below which a phase says little."""


@dataclass(frozen=True)
class Track:
    """Commanded and actual position of an axis, n rows, and its velocities where the log has them."""

    name: str
    command: np.ndarray
    actual: np.ndarray
    command_speed: np.ndarray | None = None
    actual_speed: np.ndarray | None = None
    unit: str = ""
    """Of the positions, as the log writes it; empty where it does not."""

    @cached_property
    def steps(self) -> np.ndarray:
        """The coarser rounding step of the two positions, by row."""
        return np.maximum(steps(self.command), steps(self.actual))

    def speeds(self, period: float, stretch: np.ndarray) -> np.ndarray:
        """The commanded velocity: the log's, or differences of the position within stretches."""
        return self.both_speeds(period, stretch)[0]

    def both_speeds(self, period: float, stretch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Commanded and actual velocity from the same kind of source: logged both, or differences both."""
        if self.command_speed is not None and self.actual_speed is not None:
            return self.command_speed, self.actual_speed
        differences = tuple(_differences(p, period, stretch) for p in (self.command, self.actual))
        return (differences[0] if self.command_speed is None else self.command_speed), differences[1]


def _differences(position: np.ndarray, period: float, stretch: np.ndarray) -> np.ndarray:
    """Central differences within stretches, one-sided at their ends, 0 in a stretch of one row."""
    row = np.arange(len(position))
    before, after = np.maximum(row - 1, 0), np.minimum(row + 1, len(row) - 1)
    before = np.where(stretch[before] == stretch, before, row)
    after = np.where(stretch[after] == stretch, after, row)
    return (position[after] - position[before]) / (period * np.maximum(after - before, 1))


def _reach(track: Track) -> float:
    """The largest speed that the log has, 0 where it has none."""
    both = [np.abs(s).max() for s in (track.command_speed, track.actual_speed) if s is not None]
    return float(max(both, default=0.0))


def wrap_of(track: Track, period: float) -> float:
    """How far a counter runs before it starts again, from the largest jump; 0 where it does not."""
    if track.command_speed is None:
        return 0.0
    jumps, v = np.diff(track.command), track.command_speed
    shown, reach = float(np.ptp(track.command)), _reach(track)
    fast = np.minimum(v[1:] * np.sign(v[:-1]), np.abs(v[:-1])) > 0.5 * reach
    back = (np.abs(jumps) > WRAP * shown) & (jumps * v[:-1] < 0.0)
    return shown if shown > 20.0 * reach * period > 0.0 and bool(np.any(fast & back)) else 0.0


def folded(track: Track, period: float) -> np.ndarray:
    """``command - actual``, without the range of a counter of which one wrapped before the other."""
    error = track.command - track.actual
    whole = wrap_of(track, period)
    return error - whole * np.round(error / whole) if whole else error


def faults(track: Track, period: float) -> np.ndarray:
    """Rows in which command and actual are further apart than the axis moves in 1.5 periods and twice its usual lag."""
    reach, error = _reach(track), folded(track, period)
    if not reach:
        return np.zeros(len(track.command), dtype=bool)
    return np.abs(error) > reach * (TORN * period + 2.0 * _usual_lag(track, error, reach)) + 2.0 * track.steps


def _usual_lag(track: Track, error: np.ndarray, reach: float) -> float:
    """Median of error over commanded velocity where that is fast, s: a few torn rows do not move it."""
    v = track.command_speed
    fast = np.zeros(len(error), dtype=bool) if v is None else np.abs(v) > 0.3 * reach
    if v is None or fast.sum() < FEW:
        return 0.0
    return abs(float(np.median(error[fast] / v[fast])))


def breaks(track: Track, period: float) -> np.ndarray:
    """Whether the command cannot have gone from the row before to this one in a period; n flags, the first False.

    It may differ from the mean of the two velocities by half of their difference and half of the largest velocity.
    Without a commanded velocity it is where command and actual position jump together.
    """
    if track.command_speed is None:
        return _together(track, period)
    v, step = track.command_speed, track.steps
    away = np.abs(np.diff(track.command) - 0.5 * period * (v[1:] + v[:-1]))
    whole = wrap_of(track, period)
    slack = period * 0.5 * (np.abs(np.diff(v)) + _reach(track)) + np.maximum(step[1:], step[:-1])
    if whole:
        away = np.minimum(away, np.abs(away - whole))
    return np.r_[False, away > slack]


def _together(track: Track, period: float) -> np.ndarray:
    """Rows to which both positions jump, as no axis does: rows are missing before them or not in order."""
    found, sizes = jumps(track.command, period, float(np.max(track.steps)), 0.0)
    along = np.abs(excess(track.actual)[found - 1]) > 0.5 * np.abs(sizes)
    flags = np.zeros(len(track.command), dtype=bool)
    flags[found[along]] = True
    return flags


def stretches(tracks: Sequence[Track], period: float) -> np.ndarray:
    """The number of the stretch that each row belongs to: rows in which every axis could follow the row before."""
    return np.cumsum(np.any([breaks(t, period) for t in tracks], axis=0))


def looked_at(
    tracks: Sequence[Track], phase: Sequence[str] | None, table: np.ndarray | None, stretch: np.ndarray, period: float
) -> list[Finding]:
    """All that is odd about a log, a sentence each."""
    found = [*_order(stretch, tracks), *_clock(tracks, stretch, period)]
    for track in tracks:
        found += _of_track(track, period)
    found += _rounding(tracks)
    found += _twice(np.column_stack([c for t in tracks for c in (t.command, t.actual)]) if table is None else table)
    return found + ([] if phase is None else _labels(phase))


def _order(stretch: np.ndarray, tracks: Sequence[Track]) -> list[Finding]:
    count = int(stretch[-1])
    if not count and not any(t.command_speed is not None for t in tracks):
        return [
            Finding("order", "note", "no column of commanded velocity: whether rows are in order cannot be checked")
        ]
    if not count:
        return []
    first = int(np.flatnonzero(np.diff(stretch))[0])
    typical, often = int(np.median(np.bincount(stretch))), f"{count} time{'s' * (count > 1)}"
    return [Finding("order", "warning",
                    f"the position jumps {often} by more than an axis can move in a period, first between "
                    f"data rows {first + 1} and {first + 2}: rows are missing or not in order of time; the "
                    f"{count + 1} stretches (half of them up to {typical} rows) are evaluated one by one")]  # fmt: skip


def period_of(tracks: Sequence[Track], stretch: np.ndarray) -> float | None:
    """The period that positions and velocities agree on, s: the median of ``dx / v`` where a row moves far."""
    seen = []
    for track in tracks:
        if track.command_speed is None:
            continue
        v = 0.5 * (track.command_speed[1:] + track.command_speed[:-1])
        moved, step = np.diff(track.command), np.maximum(track.steps[1:], track.steps[:-1])
        even = np.abs(np.diff(track.command_speed)) <= 0.02 * np.abs(v)
        far = even & (np.abs(moved) >= 4.0 * step) & (v != 0.0) & (moved * v > 0.0)
        seen.append(moved[far] / v[far])
    ratios = np.concatenate(seen) if seen else np.empty(0)
    return float(np.median(ratios)) if len(ratios) >= FEW else None


def _clock(tracks: Sequence[Track], stretch: np.ndarray, period: float) -> list[Finding]:
    found = period_of(tracks, stretch)
    if found is None or abs(found / period - 1.0) <= 0.15:
        return []
    return [Finding("period", "warning",
                    f"positions move by velocity times {found:.3g} s from row to row, not by the period of "
                    f"{period:g} s: check --period and the units of the velocities")]  # fmt: skip


def _of_track(track: Track, period: float) -> list[Finding]:
    found = []
    bad = np.flatnonzero(faults(track, period))
    if len(bad):
        k = int(bad[0])
        found.append(Finding("torn", "warning",
                             f"{track.name}: {len(bad)} row{'s' * (len(bad) > 1)} left out, data row {k + 1}, "
                             f"command {track.command[k]:g}, actual {track.actual[k]:g}, further apart than it moves "
                             f"in {TORN:g} periods and twice its lag; command and actual are not of one time",
                             ))  # fmt: skip
    if wrap_of(track, period):
        found.append(Finding("wrap", "note",
                             f"{track.name}: the counter starts again ({track.command.min():g} to "
                             f"{track.command.max():g}); errors are taken across it"))  # fmt: skip
    if not np.ptp(track.command):
        found.append(Finding("standstill", "note", f"{track.name}: the command never moves"))
    return found


def _rounding(tracks: Sequence[Track]) -> list[Finding]:
    said = []
    for track in tracks:
        fine, coarse = float(track.steps.min()), float(track.steps.max())
        if coarse > 1e-3 * float(np.ptp(track.command)) > 0.0:
            said.append(f"{track.name} to {coarse:g}" + (f" (near 0 finer, {fine:g})" if fine < coarse else ""))
    if not said:
        return []
    return [Finding("rounding", "note",
                    f"positions are rounded: {', '.join(said)}; a single error is known to that only, means and lags "
                    "better")]  # fmt: skip


def _twice(table: np.ndarray) -> list[Finding]:
    found = []
    same = np.flatnonzero((np.diff(table, axis=0) == 0.0).all(axis=1))
    if len(same):
        found.append(Finding("frozen", "warning",
                             f"{len(same)} row{'s' * (len(same) > 1)} equal the row before in every number, first data "
                             f"row {int(same[0]) + 2}: the log stood still"))  # fmt: skip
    else:
        same = np.empty(0, dtype=int)
    again = len(table) - len(np.unique(table, axis=0)) - len(same)
    if again > 0:
        found.append(
            Finding(
                "duplicate",
                "warning",
                f"{again} row{'s' * (again > 1)} stand{'s' * (again == 1)} in the log a second time elsewhere",
            )
        )
    return found


def _labels(phase: Sequence[str]) -> list[Finding]:
    found = []
    spelled: dict[str, set[str]] = {}
    for label in phase:
        spelled.setdefault(" ".join(label.split()).casefold(), set()).add(label)
    for name, ways in spelled.items():
        if len(ways) > 1:
            found.append(
                Finding("label", "note", f"the phase {name!r} is spelled {', '.join(sorted(map(repr, ways)))}")
            )
    counted = Counter(" ".join(p.split()).casefold() for p in phase)
    few = [f"{name!r} ({n})" for name, n in sorted(counted.items()) if n < FEW]
    if few:
        found.append(Finding("few", "note", f"phases of fewer than {FEW} rows: {', '.join(few)}"))
    name, most = counted.most_common(1)[0]
    if name in ("end", "idle", "stop") and most > 0.5 * len(phase):
        found.append(
            Finding("phase", "warning", f"{100.0 * most / len(phase):.0f} % of the rows are of phase {name!r}")
        )
    return found


ROLES = ("time", "position", "command", "actual", "velocity")
"""What a unit is told of; ``position`` is command and actual."""


def checked(told: Mapping[str, str]) -> dict[str, str]:
    """The units by role, each one that is known.

    Raises:
        ValueRefused: no such role or unit.
    """
    for role, unit in told.items():
        if role not in ROLES:
            raise ValueRefused(f"--unit {role}={unit}: allowed are {', '.join(ROLES)}")
        {"time": time_in, "velocity": speed_in}.get(role, length_in)(unit)
    return dict(told)


def in_one_unit(track: Track, names: Mapping[str, str], table: Table, told: Mapping[str, str]) -> Track:
    """The track with actual position and velocities in the unit of the command; ``names``: column by role.

    Raises:
        DataError: units that do not go together.
    """
    units = {role: _unit(table, name, role, told) for role, name in names.items()}
    own = units["command"] or units["actual"]
    if not own:
        return track
    kind, size = length_in(own)
    changed: dict[str, object] = {"unit": own}
    if units["actual"] and length_in(units["actual"])[0] != kind:
        raise DataError(
            f"{table.source}: {names['command']!r} is in {own}, {names['actual']!r} in {units['actual']}; expected "
            "both along or both around: name other columns with --pair, or say --unit position=UNIT"
        )
    scale = length_in(units["actual"])[1] / size if units["actual"] else 1.0
    if scale != 1.0:
        changed["actual"] = scale * track.actual
    for role in ("command_speed", "actual_speed"):
        speed = getattr(track, role)
        if speed is not None and units.get(role):
            way, rate = speed_in(units[role])
            if way == kind and rate != size:
                changed[role] = rate / size * speed
    return replace(track, **changed)  # type: ignore[arg-type]


def _unit(table: Table, name: str, role: str, told: Mapping[str, str]) -> str:
    """As told, or as the header says, where that is a unit of such a column; else nothing."""
    if role.endswith("_speed"):
        return _fits(told.get("velocity") or table.units.get(name, ""), True)
    return told.get(role) or told.get("position") or _fits(table.units.get(name, ""), False)


def _fits(unit: str, speed: bool) -> str:
    try:
        (speed_in if speed else length_in)(unit)
    except ValueRefused:
        return ""
    return unit
