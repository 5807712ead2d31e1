"""Following error of logged axes: how large, how it depends on direction, and how long the axis lags.

    e = command - actual

positive where the axis is behind in a positive motion. By axis and phase of the process: the largest error, its root
mean square, its mean while the command moves forwards and backwards, the lag from the error at speed and from the shift
of the velocities (:func:`shift`). ``Kv = 1 / lag`` is the velocity gain of the position loop.

An axis moves where its commanded speed is above 1 % of the largest of all logs. Rows that no axis can have run are left
out of the tables and named (:mod:`leadscrew.analysis.following_anomalies`). Units are those of the log.

How long an axis lags behind its command, twice: from the error at speed, and from the shift between two signals.

1. *Error at speed*. A servo with velocity gain ``Kv`` lags by ``e = v / Kv`` at constant speed, so the slope of
   ``e = lag v + offset`` is the lag and its inverse ``Kv`` (Y. Altintas, *Manufacturing Automation*, 2nd edition,
   section 5.3). It asks nothing of the order of the rows and little of their rate.
2. *Shift*. The lag at which the cross-correlation of actual and commanded velocity is largest, to a fraction of a
   period: between samples the command is the polynomial through five of them, so the correlation is one too.

   Rows around which the command bends too sharply for its rate are left out: where an axis speeds up within a period,
   the log does not say when.

Intervals are of 95 % and robust against errors that are alike within a second (rounding of a slow axis): the sandwich
covariance over groups of rows (J. M. Wooldridge, *Econometric Analysis*, 2nd edition, section 20.3) with Student's t,
whose degrees of freedom count groups by their weight: a few that decide all count as few.

Logs of commanded and actual positions from files: which columns belong together, and how far apart the rows are.

Columns are found by the words of their names: ``X1_CommandPosition`` and ``X1_ActualPosition``, ``x-pos-cmd`` and
``x-pos-fb``, ``command`` and ``feedback``; else by what ``leadscrew log`` takes for command and position, where there
is one of each; with pairs given, those. A velocity belongs to a position of the same name but for the word.
"""

from __future__ import annotations

import glob
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.following_anomalies import Track, faults, folded, stretches
from leadscrew.analysis.following_anomalies import looked_at as oddities
from leadscrew.kernel.one_thread import one_thread
from leadscrew.kernel.parameters import nearest
from leadscrew.kernel.validate import positive
from leadscrew.logs.finding import Finding
from leadscrew.logs.header import bare
from leadscrew.logs.measure import Motion, encoder_step, noise
from leadscrew.logs.plausible import check_units
from leadscrew.logs.roles import candidates
from leadscrew.logs.signals import jumps
from leadscrew.logs.table import Table
from leadscrew.logs.units import length_in
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

LEVEL = 0.975
"""Quantile of a two-sided interval of 95 %."""
ONE_WAY = "one way: an offset would count as lag"
STEADY = "no change of speed slow enough for the rate"
FEWEST_ROWS = 10
FEWEST_GROUPS = 4
BEND = 0.25
"""How much the change of the command from sample to sample may change, as a share of that change."""
POINTS = np.arange(-2, 3)
"""Samples around the one looked at, through which the command is a polynomial."""


class Told(NamedTuple):
    """A number with its 95 % interval; NaN where the rows do not tell it."""

    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    why: str = ""
    """Why there is none, or what it includes."""
    rows: int = 0
    """From how many rows it was computed."""

    @property
    def half(self) -> float:
        """Half of the interval."""
        return 0.5 * (self.high - self.low)


def lag_of_error(
    error: np.ndarray, speed: np.ndarray, step: np.ndarray, group: np.ndarray, period: float | None = None
) -> Told:
    """Lag in seconds from error against commanded speed, over rows that move; ``step`` is the rounding of each row.

    With ``period``, rows of one log: where one speed decides and the axis moves by ``n / m`` steps a period (``m`` up
    to 20), the same places between two steps come again and again, and rounding need not average out. The interval is
    then wider by ``step / (2 m v)`` to both sides.

    Rows weigh by one over the square of their step, 100 times as much at most. With motion one way only, the offset
    cannot be told from the lag and is taken to be 0.
    """
    if len(error) < FEWEST_ROWS or len(np.unique(group)) < FEWEST_GROUPS:
        return Told(why="too few rows in motion")
    both = bool(speed.min() < 0.0 < speed.max())
    weight = 1.0 / np.maximum(step, 0.1 * float(np.max(step)) or 1.0)
    columns = np.column_stack([speed, np.ones(len(speed))] if both else [speed]) * weight[:, None]
    value, spread, groups = _robust(columns, error * weight, group, 0)
    found = _told(float(value[0]), spread, groups, "" if both else ONE_WAY)
    wider = 0.0 if period is None else _locked(speed, step, (speed * weight) ** 2, period)
    return found._replace(low=found.low - wider, high=found.high + wider, rows=len(error))


def _locked(speed: np.ndarray, step: np.ndarray, weight: np.ndarray, period: float) -> float:
    """How far rounding may shift the lag where an axis meets the same places between two steps in every period, s."""
    main = abs(float(speed[int(np.argmax(weight))]))
    at = np.abs(np.abs(speed) - main) <= 0.01 * main
    if weight[at].sum() < 0.8 * weight.sum():
        return 0.0
    bounds = np.zeros(len(step))
    for size in np.unique(step[at & (step > 0.0)]):
        turns = main * period / float(size)
        cycle = next((m for m in range(1, 21) if abs(m * turns - round(m * turns)) <= 0.02), 0)
        bounds[step == size] = float(size) / (2.0 * cycle * main) if cycle else 0.0
    return float(np.average(bounds[at], weights=weight[at]))


def shift(command: np.ndarray, actual: np.ndarray, stretch: np.ndarray, group: np.ndarray, period: float) -> Told:
    """Lag in seconds at which two signals of equal rate correlate best, within stretches of rows in order.

    Whole periods are looked through up to a quarter of a second, at least one; then the fraction.
    """
    most = max(1, round(0.25 / period))
    smooth = _smooth(command, stretch)
    whole = _whole(command, actual, stretch, smooth, most)
    around, seen, kept = _windows(command, actual, stretch, whole)
    around, seen, kept = around[smooth[kept - whole]], seen[smooth[kept - whole]], kept[smooth[kept - whole]]
    if len(seen) < FEWEST_ROWS or len(np.unique(group[kept])) < FEWEST_GROUPS:
        return Told(why="too few rows in a row")
    held, own = around.T @ around, around.T @ seen
    fractions = np.linspace(-1.0, 1.0, 2001)
    weights = _lagrange(-fractions)
    norm = np.einsum("fj,jk,fk->f", weights, held, weights)
    at = int(np.argmax((weights @ own) / np.sqrt(np.where(norm > 0.0, norm, np.inf))))
    if norm[at] <= 0.0 or at in (0, len(fractions) - 1):
        return Told(why=STEADY)
    best, slope = weights[at], (_lagrange(-fractions[at] + 1e-4) - _lagrange(-fractions[at] - 1e-4))[0] / 2e-4
    gain = float(best @ own) / float(norm[at])
    columns = np.column_stack([around @ best, -gain * (around @ slope)])
    sizes = np.linalg.norm(columns, axis=0)
    if sizes[1] <= 1e-6 * sizes[0] or np.linalg.cond(columns / sizes) > 1e6:
        return Told(why=STEADY)
    last, spread, groups = _robust(columns, seen - gain * (around @ best), group[kept], 1)
    lag = period * (whole + float(fractions[at]) + float(last[1]))
    return _told(lag, period * spread, groups, "")._replace(rows=len(seen))


def _told(value: float, spread: float, groups: float, why: str) -> Told:
    from scipy.special import stdtrit

    if groups < FEWEST_GROUPS - 1.0:
        return Told(why="a few rows decide it")
    half = float(stdtrit(groups - 1.0, LEVEL)) * spread
    return Told(value, value - half, value + half, why)


def _robust(columns: np.ndarray, seen: np.ndarray, group: np.ndarray, of: int) -> tuple[np.ndarray, float, float]:
    """Least squares; the standard error of one coefficient that allows rows of a group to err alike; how many groups.

    Groups count by what they weigh in that coefficient: ``(sum w)^2 / sum w^2``.
    """
    value, *_ = np.linalg.lstsq(columns, seen, rcond=None)
    left = (seen - columns @ value)[:, None] * columns
    _, at = np.unique(group, return_inverse=True)
    scores = np.zeros((at.max() + 1, columns.shape[1]))
    np.add.at(scores, at, left)
    bread = np.linalg.pinv(columns.T @ columns)
    count, rows, wide = len(scores), *columns.shape
    fair = count / (count - 1) * (rows - 1) / max(rows - wide, 1)
    error = float(np.sqrt(max(float((bread @ (scores.T @ scores) @ bread)[of, of]) * fair, 0.0)))
    weight = np.bincount(at, (columns @ bread[:, of]) ** 2)
    total = float(weight.sum())
    return value, error, total * total / float(weight @ weight) if total else 0.0


def _smooth(command: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """Whether the command around each sample is what a log of this rate can show."""
    around, _, row = _windows(command, command, stretch, 0)
    bend = np.abs(np.diff(around, n=2)).max(axis=1, initial=0.0)
    found = np.zeros(len(command), dtype=bool)
    found[row] = bend <= BEND * 0.5 * np.abs(around[:, 3] - around[:, 1])
    return found


def _whole(command: np.ndarray, actual: np.ndarray, stretch: np.ndarray, smooth: np.ndarray, most: int) -> int:
    """The lag in whole periods with the largest correlation, over smooth rows that all lags up to ``most`` have."""
    while most > 1:
        row = np.arange(most, len(actual) - most)
        row = row[(stretch[row - most] == stretch[row]) & (stretch[row + most] == stretch[row])]
        row = row[smooth[row]]
        if len(row) >= FEWEST_ROWS and np.any(actual[row]):
            break
        most //= 2
    else:
        return 0

    def likeness(lag: int) -> float:
        size = float(np.linalg.norm(command[row - lag]) * np.linalg.norm(actual[row]))
        return float(command[row - lag] @ actual[row]) / size if size else -1.0

    return max(range(-most, most + 1), key=likeness)


def _windows(
    command: np.ndarray, actual: np.ndarray, stretch: np.ndarray, lag: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Five samples of the command around ``row - lag``, the actual value of the row, and the rows, in one stretch."""
    row = np.arange(len(actual))
    first, last = row - lag + POINTS[0], row - lag + POINTS[-1]
    inside = (np.minimum(first, row) >= 0) & (np.maximum(last, row) < len(actual))
    row = row[inside]
    low, high = np.minimum(first, last)[inside], np.maximum(first, last)[inside]
    same = (stretch[low] == stretch[row]) & (stretch[high] == stretch[row])
    row = row[same]
    return command[(row - lag)[:, None] + POINTS], actual[row], row


def _lagrange(at: np.ndarray | float) -> np.ndarray:
    """Weights of the five samples for a place between them, one row each."""
    place = np.atleast_1d(np.asarray(at, float))[:, None]
    found = np.ones((len(place), len(POINTS)))
    for j, x in enumerate(POINTS):
        for other in POINTS:
            if other != x:
                found[:, j] *= (place[:, 0] - other) / (x - other)
    return found


UNLIKE = 0.5
"""Standard deviation of the error over that of the command from which the two are hardly one signal."""
IN_ORDER = 20
"""Rows of a typical stretch from which jumps can be told from rows out of order."""


def track_checks(track: Track, stretch: np.ndarray, period: float) -> list[Finding]:
    """What is odd about the two positions of an axis."""
    return [*_unlike(track, period), *_jumps(track, stretch, period), *_fast(track, stretch, period)]


def _unlike(track: Track, period: float) -> list[Finding]:
    moved, error = float(np.std(track.command)), folded(track, period)
    left = float(np.std(error))
    if not moved or left <= UNLIKE * moved or left <= 3.0 * float(np.max(track.steps)):
        return []
    return [Finding(
        "unlike", "warning",
        f"{track.name}: the error varies by {left:.3g} where the command varies by {moved:.3g} (rms): command and "
        "actual are hardly one signal; look whether the right columns were named and both are in one unit",
    )]  # fmt: skip


def _jumps(track: Track, stretch: np.ndarray, period: float) -> list[Finding]:
    """Jumps of the actual position that the command does not make, within stretches."""
    if np.median(np.bincount(stretch)) < IN_ORDER:
        return []
    step = max(encoder_step(track.actual), float(np.max(track.steps)))
    found, sizes = jumps(track.actual, period, step, noise(track.actual, step))
    if not len(found):
        return []
    own = np.abs(np.diff(folded(track, period))[found - 1]) > 0.5 * np.abs(sizes)
    near = np.clip(found[:, None] + np.arange(-3, 3), 0, len(stretch) - 1)
    own &= (stretch[near] == stretch[found][:, None]).all(axis=1)
    found, sizes = found[own], sizes[own]
    if not len(found):
        return []
    k = int(np.argmax(np.abs(sizes)))
    times = "once" if len(found) == 1 else f"{len(found)} times"
    return [Finding(
        "jump", "warning",
        f"{track.name}: the actual position jumps {times} where the command does not, most by {sizes[k]:.3g}"
        f"{' ' + track.unit if track.unit else ''} at data row {int(found[k]) + 1}: an encoder that lost counts, or a "
        "bad sample; errors and lag hold these rows",
    )]  # fmt: skip


def _fast(track: Track, stretch: np.ndarray, period: float) -> list[Finding]:
    """Speeds and travels that no axis has, where the unit is known."""
    if not track.unit:
        return []
    kind, size = length_in(track.unit)
    speed = size * track.both_speeds(period, stretch)[1]
    seen = check_units(size * track.actual, Motion(speed, np.zeros(len(speed)), 0), period, kind)
    return [Finding("unit", "warning", f"{track.name}: {f.sentence}") for f in seen if f.severity == "refused"]


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
    found = oddities(tracks, log.phase, log.table, stretch, period)
    for track in tracks:
        found += track_checks(track, stretch, period)
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
    from leadscrew.analysis.following_anomalies import checked
    from leadscrew.logs import read_table

    found, told = [], checked(units or {})
    for path in paths_of(paths):
        table = _part(read_table(path), period, time, told.get("time"), start, end)
        step = _period_of_table(table, period, time, told.get("time"))
        tracks = _tracks(table, pairs or {}, told)
        phase = None if by is None else _phases(table, by)
        found.append(Log(str(path), tracks, step, phase, _numbers(table)))
    return found


def _period_of_table(table: Table, period: float | None, time: str | None, unit: str | None) -> float:
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
    from leadscrew.analysis.following_anomalies import in_one_unit

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
