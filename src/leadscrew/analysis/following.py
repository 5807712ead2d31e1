"""Following error of logged axes: how large, how it depends on direction, and how long the axis lags.

    e = command - actual

positive where the axis is behind in a positive motion. By axis and phase of the process: the largest error, its root
mean square, its mean while the command moves forwards and backwards, the lag from the error at speed and from the shift
of the velocities (:mod:`leadscrew.analysis.following_lag`). ``Kv = 1 / lag`` is the velocity gain of the position loop.

An axis moves where its commanded speed is above 1 % of the largest of all logs. Rows that no axis can have run are left
out of the tables and named (:mod:`leadscrew.analysis.following_odd`). Units are those of the log.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.analysis import following_checks
from leadscrew.analysis.following_lag import Told, lag_of_error, shift
from leadscrew.analysis.following_odd import Track, faults, folded, looked_at, stretches
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.kernel.one_thread import one_thread
from leadscrew.kernel.validate import positive
from leadscrew.logs.finding import Finding
from leadscrew.logs.units import length_in

MOVES = 0.01
"""Share of the largest commanded speed above which an axis moves."""
ALL = "all"
GROUP_S = 1.0
"""Errors within a second may be alike: how rows of a log are grouped for intervals."""
ENOUGH_LOGS = 8
"""From so many logs on, those of all together allow all rows of a log to err alike."""


@dataclass(frozen=True)
class Log:
    """Axes that were logged together, n rows each; ``phase`` names the part of the process of each row."""

    source: str
    tracks: dict[str, Track]
    period: float
    phase: Sequence[str] | None = None
    table: np.ndarray | None = None
    """All numbers of the rows, n x m, to find rows that were written twice; None: those of the tracks."""


@dataclass(frozen=True)
class Followed:
    """One axis in one phase of one log, or of all."""

    source: str
    axis: str
    phase: str
    unit: str
    """Of the errors, as the log writes it; empty where it does not."""
    rows: int
    moving: int
    """Rows from which the lag was computed, each by itself."""
    worst: float
    rms: float
    mean_forward: float
    """NaN where the command never moved that way."""
    mean_backward: float
    step: float
    """The largest rounding step of the positions among these rows: errors are known to it only."""
    top_speed: float
    lag: Told
    shift: Told

    @property
    def gain(self) -> Told:
        """``Kv`` in 1/s with its interval, where the lag's interval does not hold 0."""
        if not self.lag.low > 0.0:
            return Told(why=self.lag.why or "the interval of the lag holds 0")
        return Told(1.0 / self.lag.value, 1.0 / self.lag.high, 1.0 / self.lag.low)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        names = {"worst": "max", "step": "rounding_step"}
        plain = {names.get(k, k): v for k, v in vars(self).items() if k not in ("lag", "shift")}
        return {**plain, "lag_s": self.lag._asdict(), "gain_per_s": self.gain._asdict(),
                "shift_s": self.shift._asdict()}  # fmt: skip


@dataclass(frozen=True)
class Following:
    """What all logs tell: rows of each log, rows of all together, and what is odd about each log."""

    each: list[Followed]
    together: list[Followed]
    findings: dict[str, list[Finding]] = field(default_factory=dict)
    period: float = math.nan


@dataclass(frozen=True)
class _Rows:
    """Rows of one axis, of one log or several."""

    error: np.ndarray
    speed: np.ndarray
    step: np.ndarray
    command_speed: np.ndarray
    actual_speed: np.ndarray
    stretch: np.ndarray
    group: np.ndarray
    phase: np.ndarray
    kept: np.ndarray
    unit: str
    single: bool = True
    """Of one log."""


@one_thread()
def following(logs: Sequence[Log]) -> Following:
    """The tables of some logs with the same period.

    Raises:
        ValueRefused: no logs, unequal or impossible periods, or an axis in two units.
        DataError: a log without axes or with fewer than three rows.
    """
    period = _period(logs)
    names = list(dict.fromkeys(name for log in logs for name in log.tracks))
    for name in names:
        _one_unit(logs, name)
    cuts = {log.source: stretches(list(log.tracks.values()), period) for log in logs}
    top = {
        name: max(float(np.abs(log.tracks[name].speeds(period, cuts[log.source])).max())
                  for log in logs if name in log.tracks)
        for name in names
    }  # fmt: skip
    each: list[Followed] = []
    together: list[Followed] = []
    for name in names:
        found = [
            (log.source, _rows(log, log.tracks[name], cuts[log.source], period)) for log in logs if name in log.tracks
        ]
        for source, rows in found:
            each += _by_phase(source, name, rows, MOVES * top[name], period)
        if len(found) > 1:
            joined = _joined([r for _, r in found])
            together += _by_phase(f"{len(found)} logs", name, joined, MOVES * top[name], period)
        else:
            together += [row for row in each if row.axis == name]
    findings = {log.source: _odd(log, cuts[log.source], period) for log in logs}
    return Following(each, together, findings, period)


def _odd(log: Log, stretch: np.ndarray, period: float) -> list[Finding]:
    tracks = list(log.tracks.values())
    found = looked_at(tracks, log.phase, log.table, stretch, period)
    for track in tracks:
        found += following_checks.looked_at(track, stretch, period)
    return found


def _one_unit(logs: Sequence[Log], name: str) -> None:
    """Passes where all logs have an axis in one unit, as far as they say."""
    units = {log.tracks[name].unit: log.source for log in logs if name in log.tracks and log.tracks[name].unit}
    if len({length_in(unit) for unit in units}) > 1:
        said = ", ".join(f"{unit} in {source}" for unit, source in units.items())
        raise ValueRefused(f"{name} is in {said}: compare logs in one unit, one command for each")


def _period(logs: Sequence[Log]) -> float:
    if not logs:
        raise ValueRefused("logs = []: expected one log or more")
    period = positive("period", logs[0].period, "s")
    for log in logs:
        if not log.tracks:
            raise DataError(f"{log.source}: has no axis with a commanded and an actual position")
        if abs(log.period - period) > 1e-3 * period:
            raise ValueRefused(
                f"{log.source}: period {log.period:g} s, but {logs[0].source} has {period:g} s: compare like with like"
            )
        rows = {len(t.command) for t in log.tracks.values()}
        if len(rows) > 1 or min(rows) < 3:
            raise DataError(f"{log.source}: has {min(rows)} rows; a following error needs three or more")
    return period


def _rows(log: Log, track: Track, stretch: np.ndarray, period: float) -> _Rows:
    count = len(track.command)
    labels = np.full(count, ALL) if log.phase is None else np.array([" ".join(p.split()).casefold() for p in log.phase])
    # A group is a second of rows in order; rows of another phase are another group.
    place = np.arange(count) - np.flatnonzero(np.r_[True, np.diff(stretch) != 0])[stretch]
    chunk = np.floor(place * period / GROUP_S + 1e-9).astype(int)
    _, group = np.unique(np.column_stack([stretch, chunk]), axis=0, return_inverse=True)
    command_speed, actual_speed = track.both_speeds(period, stretch)
    return _Rows(folded(track, period), track.speeds(period, stretch), track.steps, command_speed, actual_speed,
                 stretch, group.reshape(-1), labels, ~faults(track, period), track.unit)  # fmt: skip


def _joined(parts: Sequence[_Rows]) -> _Rows:
    stretch, group, shifted = 0, 0, []
    for number, part in enumerate(parts):
        mine = np.full(len(part.group), number) if len(parts) >= ENOUGH_LOGS else part.group + group
        shifted.append((part.stretch + stretch, mine))
        stretch, group = stretch + int(part.stretch.max()) + 1, group + int(part.group.max()) + 1
    stacked = {
        name: np.concatenate([getattr(p, name) for p in parts])
        for name in ("error", "speed", "step", "command_speed", "actual_speed", "phase", "kept")
    }
    return _Rows(
        **stacked, stretch=np.concatenate([s for s, _ in shifted]), group=np.concatenate([g for _, g in shifted]),
        unit=" / ".join(dict.fromkeys(p.unit for p in parts if p.unit)), single=False,
    )  # fmt: skip


def _by_phase(source: str, axis: str, rows: _Rows, slow: float, period: float) -> list[Followed]:
    phases = [p for p in dict.fromkeys(rows.phase.tolist()) if p != ALL]
    return [
        _followed(source, axis, p, rows, rows.kept if p == ALL else rows.kept & (rows.phase == p), slow, period)
        for p in (ALL, *sorted(phases))
        if (rows.kept if p == ALL else rows.kept & (rows.phase == p)).any()
    ]


def _followed(
    source: str, axis: str, phase: str, rows: _Rows, part: np.ndarray, slow: float, period: float
) -> Followed:
    error, speed = rows.error[part], rows.speed[part]
    moving = np.abs(speed) > slow

    def mean(of: np.ndarray) -> float:
        return float(error[of].mean()) if of.any() else math.nan

    whole = rows.stretch[part], rows.group[part]
    # Rows of another phase between two of this one: no longer in order.
    broken = np.cumsum(np.r_[0, np.diff(np.flatnonzero(part)) > 1])
    return Followed(
        source=source, axis=axis, phase=phase, unit=rows.unit, rows=len(error), moving=int(moving.sum()),
        worst=float(np.abs(error).max()), rms=float(np.sqrt(np.mean(error**2))),
        mean_forward=mean(speed > slow), mean_backward=mean(speed < -slow), step=float(rows.step[part].max()),
        top_speed=float(np.abs(speed).max()),
        lag=lag_of_error(error[moving], speed[moving], rows.step[part][moving], whole[1][moving],
                         period if rows.single else None),
        shift=shift(rows.command_speed[part], rows.actual_speed[part], whole[0] + broken, whole[1], period),
    )  # fmt: skip
