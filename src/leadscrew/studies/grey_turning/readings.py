"""What Figures 6 to 11 are judged by: overshoot, rise time, steady error and activity, of runs and of batches.

With the set-point ``r`` and the force ``y`` at the samples (filtered as the operator sees it, or the true one):

    overshoot = max(y) / r - 1        rise = from 10 to 90 % of r, first crossings, straight lines between samples
    steady = mean |y - r| / r over the last second,      bias = |mean (y - r)| / r over it
    activity = sum |u_k - u_(k-1)|, V
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leadscrew.studies.grey_turning.machines import PERIOD_S


class Reading(NamedTuple):
    """Arrays with one value a run, or single numbers."""

    overshoot: Any
    """Percent of the set-point."""
    rise_s: Any
    """NaN where 90 % is never reached."""
    steady: Any
    """Percent of the set-point."""
    bias: Any
    """Percent of the set-point."""


def crossing_s(y: np.ndarray, level: float, period: float = PERIOD_S) -> np.ndarray:
    """When rows of ``y`` first reach ``level``, seconds; NaN where they never do."""
    above = y >= level
    first = above.argmax(axis=-1)
    rows = np.arange(len(y))
    before = np.maximum(first - 1, 0)
    rise = y[rows, first] - y[rows, before]
    share = np.where(rise > 0.0, (level - y[rows, before]) / np.where(rise > 0.0, rise, 1.0), 0.0)
    return np.where(above.any(axis=-1), period * (before + share), np.nan)


def read(y: Any, target: float = 150.0, window: tuple[float, float] | None = None, period: float = PERIOD_S) -> Reading:
    """The reading of a response, or of rows of responses; ``window``: from and to of the steady part, s."""
    rows = np.atleast_2d(np.asarray(y, dtype=float))
    until = rows.shape[1] * period
    a, b = (round(t / period) for t in window or (until - 1.0, until))
    late = rows[:, a:b] - target
    found = Reading(
        100.0 * (rows.max(axis=1) / target - 1.0),
        crossing_s(rows, 0.9 * target, period) - crossing_s(rows, 0.1 * target, period),
        100.0 * np.abs(late).mean(axis=1) / target,
        100.0 * np.abs(late.mean(axis=1)) / target,
    )
    return found if np.ndim(y) > 1 else Reading(*(float(v[0]) for v in found))


def activity_v(output: Any, window: tuple[float, float] | None = None, period: float = PERIOD_S) -> Any:
    """Sum of the changes of the output, V; ``window`` in seconds."""
    rows = np.atleast_2d(np.asarray(output, dtype=float))
    a, b = (0, rows.shape[1]) if window is None else (round(window[0] / period), round(window[1] / period))
    total = np.abs(np.diff(rows[:, a:b], axis=1)).sum(axis=1)
    return total if np.ndim(output) > 1 else float(total[0])
