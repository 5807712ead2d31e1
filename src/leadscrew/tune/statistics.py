"""What many runs say: percentiles and yields, with intervals that assume nothing of the distribution.

An interval of a percentile runs from one order statistic to another: of ``n`` values the number below the percentile
``q`` is binomial (n, q), whatever the distribution (W. J. Conover, *Practical Nonparametric Statistics*, 3rd ed., 1999,
section 3.2). An end is NaN where there are too few runs for it. The interval of a yield is that of C. J. Clopper and E.
S. Pearson, Biometrika 26 (1934) 404: its coverage is at least what it says.

Percentiles are of the runs that gave a value; how many diverged, and how many others gave none (a loop that has not
settled has no settling time), stands beside them. For a yield both count as failures.

Comparisons are paired by plant, with intervals by a bootstrap over plants.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint, Goal

PERCENTILES = (1, 5, 25, 50, 75, 95, 99)
CONFIDENCE = 0.95


class Quantile(NamedTuple):
    """One percentile and its interval."""

    percent: float
    value: float
    low: float
    high: float


class Spread(NamedTuple):
    """One metric in one scenario over all runs."""

    scenario: str
    metric: str
    runs: int
    diverged: int
    without: int
    """Runs that did not diverge and gave no value."""
    least: float
    greatest: float
    mean: float
    quantiles: tuple[Quantile, ...]


class Yield(NamedTuple):
    """The part of the runs that passed."""

    passed: int
    runs: int
    value: float
    low: float
    high: float


def order_interval(runs: int, percent: float, confidence: float = CONFIDENCE) -> tuple[int, int]:
    """Which order statistics (from 1 on) bound a percentile; 0 and ``runs + 1`` say that there is no bound."""
    from scipy.stats import binom

    tail = 0.5 * (1.0 - confidence)
    low, high = binom.ppf((tail, 1.0 - tail), runs, percent / 100.0)
    return int(low), int(high) + 1


def quantiles(
    values: np.ndarray, percents: Sequence[float] = PERCENTILES, confidence: float = CONFIDENCE
) -> tuple[Quantile, ...]:
    """Percentiles of values without NaN; NaN where there is no value."""
    ordered = np.concatenate([[np.nan], np.sort(values), [np.nan]])
    n = len(values)
    if n == 0:
        return tuple(Quantile(p, np.nan, np.nan, np.nan) for p in percents)
    at = np.percentile(ordered[1:-1], percents)
    made = []
    for percent, value in zip(percents, at, strict=True):
        low, high = order_interval(n, percent, confidence)
        made.append(Quantile(percent, float(value), float(ordered[low]), float(ordered[high])))
    return tuple(made)


def spread(scenario: str, metric: str, values: np.ndarray, diverged_at: np.ndarray) -> Spread:
    """A metric over all runs of a scenario."""
    known = values[~np.isnan(values)]
    lost = int(np.isfinite(diverged_at).sum())
    ends = (known.min(), known.max(), known.mean()) if len(known) else (np.nan,) * 3
    least, greatest, mean = (float(x) for x in ends)
    runs = len(values)
    return Spread(scenario, metric, runs, lost, runs - lost - len(known), least, greatest, mean, quantiles(known))


def clopper_pearson(passed: int, runs: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """The exact interval of a probability of which ``passed`` of ``runs`` were seen."""
    from scipy.stats import binomtest

    ends = binomtest(passed, runs).proportion_ci(confidence, "exact")
    return float(ends.low), float(ends.high)


def yielded(passes: np.ndarray, confidence: float = CONFIDENCE, alike: bool = False) -> Yield:
    """The yield of runs that passed or did not; without an interval where all are the same run (``alike``)."""
    runs, passed = len(passes), int(np.count_nonzero(passes))
    ends = (np.nan, np.nan) if alike else clopper_pearson(passed, runs, confidence)
    return Yield(passed, runs, passed / runs, *ends)


def without_intervals(row: Spread) -> Spread:
    """The same percentiles without their intervals, for runs that are all the same run."""
    return row._replace(quantiles=tuple(q._replace(low=np.nan, high=np.nan) for q in row.quantiles))


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
