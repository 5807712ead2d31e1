"""How long an axis lags behind its command, twice: from the error at speed, and from the shift between two signals.

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
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

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
