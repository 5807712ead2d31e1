"""Statistics of a comparison: per plant, over plants, and paired by plant; intervals by a bootstrap over plants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint, Goal

RESAMPLES = 4000
"""Of the bootstrap."""


class Interval(NamedTuple):
    """A number with its 95 % confidence interval; the ends are NaN where there is no spread to take one from."""

    value: float
    low: float
    high: float


class Standing(NamedTuple):
    """One metric of one contender over the unseen plants."""

    mean: Interval
    p95: Interval
    worst: float
    judged: int
    """Plants on which it could be judged."""


@dataclass(frozen=True)
class Pair:
    """Two neighbours of the ranking."""

    better: str
    worse: str
    order: float
    """Part of the resamples in which the order is this one; NaN without spread."""
    difference: Interval
    """First goal of the better one less that of the worse one, in the mean over plants on which both were judged."""
    judged: int

    @property
    def shown(self) -> bool:
        """Whether the order is supported: at least 95 % of the resamples have it."""
        return self.order >= 0.95


def resamples(seed: int, count: int) -> np.ndarray:
    """Which of ``count`` plants each resample has, ``[resample, plant]``."""
    return np.random.default_rng([seed, 4]).integers(0, count, (RESAMPLES, count))


def plain(wanted: Goal) -> str:
    """A metric and where it counts."""
    return f"{wanted.metric}{f'@{wanted.scenario}' if wanted.scenario else ''}"


def per_plant(wanted: Goal, samples: Samples) -> np.ndarray:
    """One number a plant: the worst over the scenarios, or their mean; NaN where a run failed."""
    values = wanted.values(samples)
    if wanted.statistic == "mean":
        return np.asarray(values.mean(axis=0))
    return np.asarray(values.max(axis=0) if wanted.upper else values.min(axis=0))


def bad_plants(samples: Samples, goals: Sequence[Goal], constraints: Sequence[Constraint]) -> np.ndarray:
    """Plants on which a run fails or a worst-case constraint is missed."""
    bad = np.isfinite(np.array(list(samples.diverged_at.values()))).any(axis=0)
    for wanted in (*goals, *constraints):
        values = wanted.values(samples)
        bad |= np.isnan(values).any(axis=0)
        if isinstance(wanted, Constraint) and wanted.statistic == "worst":
            bad |= ~wanted.met(values).all(axis=0)
    return np.asarray(bad)


def standing(values: np.ndarray, seed: int, upper: bool = True, same: bool = False) -> Standing:
    """Mean, 95th percentile and worst over plants; without intervals where all are the ``same`` run."""
    known = values[~np.isnan(values)]
    if not len(known):
        nothing = Interval(np.nan, np.nan, np.nan)
        return Standing(nothing, nothing, np.nan, 0)
    drawn = known[resamples(seed, len(known))]
    high = 95.0 if upper else 5.0
    return Standing(
        _interval(float(known.mean()), drawn.mean(axis=1), same or len(known) < 2),
        _interval(float(np.percentile(known, high)), np.percentile(drawn, high, axis=1), same or len(known) < 2),
        float(known.max() if upper else known.min()), len(known),
    )  # fmt: skip


def _interval(value: float, drawn: np.ndarray, single: bool) -> Interval:
    """A value with its bootstrap interval; without one for a ``single`` run, which shows no spread."""
    if single:
        return Interval(value, np.nan, np.nan)
    low, high = np.percentile(drawn, (2.5, 97.5))
    return Interval(value, float(low), float(high))


def paired(
    better: str, worse: str, a: np.ndarray, b: np.ndarray, bad_a: np.ndarray, bad_b: np.ndarray, seed: int,
    same: bool = False,
) -> Pair:  # fmt: skip
    """Two contenders on the same plants; without intervals and order where all plants are the ``same`` run."""
    picks = resamples(seed, len(a))
    bads = bad_a[picks].sum(axis=1) - bad_b[picks].sum(axis=1)
    with np.errstate(invalid="ignore"):
        means = _means(a[picks]) - _means(b[picks])
    order = np.nan if same else float(np.mean((bads < 0) | ((bads == 0) & (means < 0.0))))
    both = ~(np.isnan(a) | np.isnan(b))
    if not both.any():
        return Pair(better, worse, order, Interval(np.nan, np.nan, np.nan), 0)
    d = (a - b)[both]
    drawn = d[resamples(seed, len(d))].mean(axis=1)
    return Pair(better, worse, order, _interval(float(d.mean()), drawn, same or len(d) < 2), int(both.sum()))


def difference(a: np.ndarray, b: np.ndarray, seed: int = 0) -> Interval:
    """Mean of ``a - b`` over the same plants, with its 95 % interval."""
    nothing = np.zeros(len(a), bool)
    return paired("", "", a, b, nothing, nothing, seed).difference


def _means(values: np.ndarray) -> np.ndarray:
    """Means over the plants that were judged; infinite where none was."""
    known = ~np.isnan(values)
    count = known.sum(axis=1)
    return np.where(count, np.where(known, values, 0.0).sum(axis=1) / np.maximum(count, 1), np.inf)
