"""Step metrics of recorded signals, from whole arrays.

They have the definitions of :mod:`leadscrew.kernel.metrics` and none of its code, so each checks the other.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np


class StepMetrics(NamedTuple):
    """How the last move of a record went; times in seconds, overshoot in the unit of the signal."""

    start: float
    """When the command stopped changing."""
    size: float
    """The move, signed: the command after it minus the command before it."""
    overshoot: float
    overshoot_percent: float
    rise_time: float
    settling_time: float
    peak_time: float
    """From the start to the largest excess; NaN without overshoot."""


def step_metrics(
    t: Any,
    command: Any,
    actual: Any,
    percent: float = 2.0,
    band: float = 0.0,
    low_percent: float = 10.0,
    high_percent: float = 90.0,
) -> StepMetrics:
    """Metrics of the last move of ``command``: a run of consecutive samples in which it changes.

    The first sample is a move from ``actual`` to ``command`` where the two differ. The settling band's half width is
    the larger of ``band`` and ``percent`` of the move. Overshoot, rise and settling time are NaN where the command
    still changes at the last sample; overshoot and rise time also without a move.

    Raises:
        ValueError: the arrays are empty or differ in length.
    """
    t, r, y = (np.asarray(x, dtype=np.float64) for x in (t, command, actual))
    if not (t.ndim == 1 and t.size and t.shape == r.shape == y.shape):
        raise ValueError(f"expected three arrays of one length, got shapes {t.shape}, {r.shape} and {y.shape}")
    before = np.concatenate([y[:1], r[:-1]])
    moved = np.flatnonzero(r != before)
    if moved.size == 0:
        inside = np.abs(r - y) <= band
        settling = _since(t, inside, 0) if inside[-1] else math.nan
        return StepMetrics(0.0, 0.0, math.nan, math.nan, math.nan, settling, math.nan)
    last = int(moved[-1])
    ended = last + 1 < t.size
    gaps = np.flatnonzero(np.diff(moved) > 1)
    first = int(moved[gaps[-1] + 1]) if gaps.size else int(moved[0])
    origin, target = before[first], r[last]
    size = float(target - origin)
    tail, time = y[last:], t[last:]

    excess = np.sign(target - before[last]) * (tail - target)
    peak = int(np.argmax(excess))
    overshoot = max(0.0, float(excess[peak])) if ended else math.nan

    rise = math.nan
    if size != 0.0:
        way = np.sign(size) * (tail - origin)
        low, high = (_first_passing(time, way, level / 100 * abs(size)) for level in (low_percent, high_percent))
        rise = high - low

    inside = np.abs(target - tail) <= max(band, 0.01 * percent * abs(size))
    settling = _since(time, inside, 0) - time[0] if ended and inside[-1] else math.nan
    return StepMetrics(
        float(time[0]),
        float(size),
        overshoot,
        100.0 * overshoot / abs(size) if size else math.nan,
        float(rise),
        float(settling),
        float(time[peak] - time[0]) if overshoot > 0.0 else math.nan,
    )


def _since(t: np.ndarray, inside: np.ndarray, first: int) -> float:
    """The time of the first sample from which all are inside."""
    outside = np.flatnonzero(~inside)
    return float(t[outside[-1] + 1 if outside.size else first])


def _first_passing(t: np.ndarray, way: np.ndarray, level: float) -> float:
    up = (way[:-1] <= level) & (way[1:] >= level) & (way[1:] > way[:-1])
    found = np.flatnonzero(up)
    if found.size == 0:
        return math.nan
    k = int(found[0])
    return float(t[k] + (t[k + 1] - t[k]) * ((level - way[k]) / (way[k + 1] - way[k])))
