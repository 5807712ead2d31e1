"""What many runs say: percentiles and yields, with intervals that assume nothing of the distribution.

An interval of a percentile runs from one order statistic to another: of ``n`` values the number below the percentile
``q`` is binomial (n, q), whatever the distribution (W. J. Conover, *Practical Nonparametric Statistics*, 3rd ed., 1999,
section 3.2). An end is NaN where there are too few runs for it. The interval of a yield is that of C. J. Clopper and E.
S. Pearson, Biometrika 26 (1934) 404: its coverage is at least what it says.

Percentiles are of the runs that gave a value; how many diverged, and how many others gave none (a loop that has not
settled has no settling time), stands beside them. For a yield both count as failures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

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
    from scipy.special import betaincinv

    tail = 0.5 * (1.0 - confidence)
    low = float(betaincinv(passed, runs - passed + 1, tail)) if passed > 0 else 0.0
    high = float(betaincinv(passed + 1, runs - passed, 1.0 - tail)) if passed < runs else 1.0
    return low, high


def yielded(passes: np.ndarray, confidence: float = CONFIDENCE, alike: bool = False) -> Yield:
    """The yield of runs that passed or did not; without an interval where all are the same run (``alike``)."""
    runs, passed = len(passes), int(np.count_nonzero(passes))
    ends = (np.nan, np.nan) if alike else clopper_pearson(passed, runs, confidence)
    return Yield(passed, runs, passed / runs, *ends)


def without_intervals(row: Spread) -> Spread:
    """The same percentiles without their intervals, for runs that are all the same run."""
    return row._replace(quantiles=tuple(q._replace(low=np.nan, high=np.nan) for q in row.quantiles))
