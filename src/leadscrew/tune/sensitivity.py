"""Which parameter matters: rank correlations of the runs at hand, and Sobol indices of runs made for them.

Rank correlation (Spearman) sees what rises or falls throughout, whatever its curve. The partial one is between what is
left of both after the other parameters' ranks were taken out linearly. Intervals are R. A. Fisher's: normal in ``atanh
r``, with the variance ``(1 + r^2 / 2) / (n - 3)`` of D. G. Bonett and T. A. Wright, Psychometrika 65 (2000) 23, one
run less for each parameter taken out.

Sobol indices say which part of the variance a parameter explains alone (first order) and with all its interactions
(total); A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259, as SALib computes them. Every run has noise of its
own, so noise counts as a part of every total index.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from leadscrew.tune.statistics import CONFIDENCE
from leadscrew.util.errors import LeadscrewError, ValueRefused

Z95 = 1.959963984540054
"""Quantile 97.5 % of the normal distribution."""


UNKNOWN = 1.0
"""A Sobol index lies between 0 and 1: where the half width of its interval is larger, nothing is known of it."""


class RankCorrelation(NamedTuple):
    """Of one parameter with one metric in one scenario; NaN where one of the two does not vary."""

    scenario: str
    metric: str
    key: str
    value: float
    low: float
    high: float
    partial: float
    partial_low: float
    partial_high: float
    runs: int
    """Runs that gave a value."""


class SobolIndex(NamedTuple):
    """Of one parameter for one metric in one scenario; the intervals are ``± first_width`` and ``± total_width``."""

    scenario: str
    metric: str
    key: str
    first: float
    first_width: float
    total: float
    total_width: float
    without: int
    """Runs that gave no value; one is enough for there to be no index."""

    @property
    def first_known(self) -> bool:
        """Whether the runs tell the first-order index; True where there is none at all."""
        return math.isnan(self.first) or self.first_width <= UNKNOWN

    @property
    def total_known(self) -> bool:
        """Whether the runs tell the total index; True where there is none at all."""
        return math.isnan(self.total) or self.total_width <= UNKNOWN


def rank_correlations(
    columns: Mapping[str, np.ndarray], values: np.ndarray, metric: str = "", scenario: str = ""
) -> list[RankCorrelation]:
    """Of each column with the values; runs without a value are left out."""
    from scipy.stats import rankdata

    if not columns:
        return []
    known = ~np.isnan(values)
    n, d = int(known.sum()), len(columns)
    if n < 4:
        nothing = (math.nan,) * 6
        return [RankCorrelation(scenario, metric, key, *nothing, n) for key in columns]
    ranks = np.array([rankdata(a[known]) for a in (*columns.values(), values)])
    ranks -= ranks.mean(axis=1, keepdims=True)
    length = np.sqrt((ranks**2).sum(axis=1, keepdims=True))
    varied = length[:, 0] > 0.0
    ranks = np.divide(ranks, length, out=np.zeros_like(ranks), where=length > 0.0)
    matrix = ranks @ ranks.T
    found = []
    for i, key in enumerate(columns):
        if not (varied[i] and varied[-1]):
            found.append(RankCorrelation(scenario, metric, key, *(math.nan,) * 6, n))
            continue
        r = float(np.clip(matrix[i, -1], -1.0, 1.0))
        others = [j for j in range(d) if j != i and varied[j]]
        p = _partial(matrix, i, others)
        whole, part = fisher(r, n), fisher(p, n - len(others))
        found.append(RankCorrelation(scenario, metric, key, r, *whole, p, *part, n))
    return found


def _partial(matrix: np.ndarray, i: int, others: Sequence[int]) -> float:
    """The correlation of ``i`` with the last row after ``others`` were taken out of both."""
    at = [i, len(matrix) - 1]
    left = matrix[np.ix_(at, at)]
    if others:
        across = matrix[np.ix_(others, at)]
        left = left - across.T @ np.linalg.lstsq(matrix[np.ix_(others, others)], across, rcond=None)[0]
    size = left[0, 0] * left[1, 1]
    # What is explained to the last digits has no rest that could correlate.
    if min(left[0, 0], left[1, 1]) < 1e-12 or size <= 0.0:
        return math.nan
    return float(np.clip(left[0, 1] / math.sqrt(size), -1.0, 1.0))


def fisher(r: float, runs: int) -> tuple[float, float]:
    """The 95 % interval of a rank correlation."""
    if runs < 4 or math.isnan(r):
        return math.nan, math.nan
    if abs(r) == 1.0:
        return r, r
    half = Z95 * math.sqrt((1.0 + 0.5 * r * r) / (runs - 3))
    return math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half)


def check(dimensions: int, count: int) -> None:
    """Refuses what gives no indices.

    Raises:
        ValueRefused: nothing varies, or ``count`` is no power of two.
        LeadscrewError: SALib is not installed.
    """
    if dimensions < 1:
        raise ValueRefused("Sobol indices need at least one parameter that varies")
    if count < 2 or count & (count - 1):
        near = 2 ** max(1, round(math.log2(max(count, 2))))
        raise ValueRefused(f"Sobol indices: {count} points; allowed are powers of two, for example {near}")
    _salib("sample")


def points(dimensions: int, count: int, seed: int = 0) -> np.ndarray:
    """Saltelli's points of the unit cube: ``count (dimensions + 2)`` of them, ``[point, dimension]``.

    Raises:
        LeadscrewError: see :func:`check`.
    """
    check(dimensions, count)
    made = _salib("sample").sample(_problem(dimensions), count, calc_second_order=False, seed=seed + 1)
    return np.asarray(made, dtype=np.float64)


def indices(
    values: np.ndarray, keys: Sequence[str], metric: str = "", scenario: str = "", seed: int = 0
) -> list[SobolIndex]:
    """The indices of values at :func:`points`, in their order; NaN where a value is missing or none differs."""
    without = int(np.isnan(values).sum())
    if without or np.ptp(values) == 0.0:
        return [SobolIndex(scenario, metric, k, *(math.nan,) * 4, without) for k in keys]
    # SALib takes a seed of 0 as none.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        found = _salib("analyze").analyze(
            _problem(len(keys)), values, calc_second_order=False, conf_level=CONFIDENCE, seed=seed + 1
        )
    rows = zip(keys, *(found[k] for k in ("S1", "S1_conf", "ST", "ST_conf")), strict=True)
    return [SobolIndex(scenario, metric, k, float(a), float(b), float(c), float(d), 0) for k, a, b, c, d in rows]


def sobol(
    evaluate: Callable[[np.ndarray], Mapping[tuple[str, str], np.ndarray]],
    keys: Sequence[str],
    count: int,
    seed: int = 0,
) -> tuple[SobolIndex, ...]:
    """Indices of every result of ``evaluate``, which takes points of the unit cube.

    It gives one value a point by metric and scenario.
    """
    results = evaluate(points(len(keys), count, seed))
    return tuple(row for (m, s), values in results.items() for row in indices(values, keys, m, s, seed))


def _problem(dimensions: int) -> dict[str, Any]:
    return {
        "num_vars": dimensions,
        "names": [f"x{i}" for i in range(dimensions)],
        "bounds": [[0.0, 1.0]] * dimensions,
    }


def _salib(part: str) -> Any:
    from importlib import import_module

    try:
        return import_module(f"SALib.{part}.sobol")
    except ImportError:
        raise LeadscrewError("Sobol indices need SALib: pip install 'leadscrew[tune]'") from None
