"""What forces are judged by: overshoot, rise time, steady error, and the mean over noise seeds.

With the set-point ``r`` and the force ``y`` at the samples (filtered as the operator sees it, or the true one)::

    overshoot = max(y) / r - 1        rise = from 10 to 90 % of r, first crossings, straight lines between samples
    steady = mean |y - r| / r over the last second,      bias = |mean (y - r)| / r over it
    iae = sum |y - r| T

A run is *bad* where its steady error is above 5 % or its overshoot above 30 %, or where it diverged.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leadscrew.studies.grey_turning.scenarios import FORCE_N, PERIOD_S

BAD_STEADY, BAD_OVERSHOOT = 5.0, 30.0
"""Percent."""


class Reading(NamedTuple):
    """Arrays with one value a run."""

    overshoot: np.ndarray
    """Percent of the set-point."""
    rise_s: np.ndarray
    """NaN where 90 % is never reached."""
    rise_samples: np.ndarray
    """The same in whole samples: from the first at 10 % or above to the first at 90 %."""
    steady: np.ndarray
    """Percent of the set-point."""
    bias: np.ndarray
    """Percent of the set-point."""
    iae: np.ndarray
    """N s."""
    bad: np.ndarray


def reached(y: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """First sample at which rows of ``y`` are at ``level`` or above, and the crossing between samples; NaN: never."""
    above = y >= level
    first = above.argmax(axis=1)
    rows = np.arange(len(y))
    before = np.maximum(first - 1, 0)
    step = y[rows, first] - y[rows, before]
    share = np.where(step > 0.0, (level - y[rows, before]) / np.where(step > 0.0, step, 1.0), 0.0)
    return tuple(np.where(above.any(axis=1), at, np.nan) for at in (first, before + share))  # type: ignore[return-value]


def read(
    y: Any, target: float = FORCE_N, window: tuple[float, float] | None = None, period: float = PERIOD_S
) -> Reading:
    """The reading of a response, or of rows of responses; ``window``: from and to of the steady part, s."""
    rows = np.atleast_2d(np.asarray(y, dtype=float))
    until = rows.shape[1] * period
    first, last = (round(t / period) for t in window or (until - 1.0, until))
    late = rows[:, first:last] - target
    (low, low_at), (high, high_at) = reached(rows, 0.1 * target), reached(rows, 0.9 * target)
    overshoot = 100.0 * (rows.max(axis=1) / target - 1.0)
    steady = 100.0 * np.abs(late).mean(axis=1) / target
    lost = ~np.isfinite(rows).all(axis=1)
    bad = (steady > BAD_STEADY) | (overshoot > BAD_OVERSHOOT) | lost
    return Reading(
        overshoot,
        period * (high_at - low_at),
        high - low,
        steady,
        100.0 * np.abs(late.mean(axis=1)) / target,
        np.abs(rows - target).sum(axis=1) * period,
        bad,
    )


def filtered(run: Any) -> np.ndarray:
    """The filtered force of a run or a batch, whichever the controller was given."""
    return np.asarray(run["feedback.force"] if "feedback.force" in run.signals else run["feedback"])


class SeedMean(NamedTuple):
    """A mean over noise seeds."""

    mean: float
    spread: float
    """Standard deviation of one seed."""
    seeds: int

    def __str__(self) -> str:
        return f"mean of {self.seeds} noise seeds, one scatters by {self.spread:.2g}"


def seed_mean(values: np.ndarray) -> SeedMean:
    """The mean of one value a seed."""
    return SeedMean(float(values.mean()), float(values.std(ddof=1)) if values.size > 1 else 0.0, int(values.size))
