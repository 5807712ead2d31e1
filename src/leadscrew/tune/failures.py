"""Which runs fail: for every tolerance, how each parameter separates the runs that miss it from those that keep it.

A correlation is about all runs; a cliff in the tail of one parameter does not show in it. Here the failed runs are
set against the passed ones. ``larger`` is the probability that of one failed and one passed run the failed one has
the larger value (half of ties), the U of H. B. Mann and D. R. Whitney, Ann. Math. Statist. 18 (1947) 50, over the
number of pairs: 1/2 if the parameter says nothing, 1 or 0 if it decides alone. Its interval is R. G. Newcombe's
method 5, Statist. Med. 25 (2006) 559: the values whose own standard error (J. A. Hanley and B. J. McNeil, Radiology
143 (1982) 29, with the mean of both group sizes) puts them 1.96 of it away. It stays inside 0 to 1 and holds where
the groups do not overlap.

From ``low`` to ``high`` lie all failed runs: outside none failed. ``core_low`` to ``core_high`` is the range with the
fewest runs of all that holds 95 % of the failed ones.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.tune.sensitivity import Z95
from leadscrew.tune.statistics import clopper_pearson

if TYPE_CHECKING:
    from leadscrew.tune.montecarlo import MonteCarlo

DIVERGED = "diverged"
"""Stands in the place of a tolerance for the runs that diverged in some scenario."""
CORE = 0.95
BINS = 10


class Separation(NamedTuple):
    """How one parameter separates failed from passed runs of one tolerance."""

    tolerance: str
    """Its text, or ``diverged``."""
    key: str
    failed: int
    passed: int
    larger: float
    """Probability that a failed run has the larger value."""
    larger_low: float
    larger_high: float
    low: float
    """Smallest value of a failed run."""
    high: float
    """Largest one."""
    inside: int
    """Runs from ``low`` to ``high``, failed or not."""
    core_low: float
    core_high: float
    core_inside: int
    core_failed: int


class Share(NamedTuple):
    """The part of failed runs among those of a parameter's values from ``start`` to ``end``."""

    start: float
    end: float
    failed: int
    runs: int
    value: float
    low: float
    high: float


def questions(found: MonteCarlo) -> dict[str, np.ndarray]:
    """Which runs fail, by tolerance; and which diverge. Only where some do and others do not."""
    asked = {str(t): ~t.passes(found.samples) for t in found.tolerances} | {DIVERGED: found.diverged}
    return {name: failed for name, failed in asked.items() if failed.any() and not failed.all()}


def separations(found: MonteCarlo) -> tuple[Separation, ...]:
    """Of every tolerance that some runs miss and others keep: each parameter, the one that separates best first."""
    rows: list[Separation] = []
    for name, failed in questions(found).items():
        made = [separation(x, failed, name, key) for key, x in found.samples.columns.items()]
        rows += sorted(made, key=lambda r: -abs(r.larger - 0.5))
    return tuple(rows)


def separation(values: np.ndarray, failed: np.ndarray, tolerance: str = "", key: str = "") -> Separation:
    """One parameter, one value a run, and which runs failed; some did and others did not."""
    theirs = np.sort(values[failed])
    m, n = len(theirs), int((~failed).sum())
    larger = larger_in(values, failed)
    ordered = np.sort(values)
    ends = float(theirs[0]), float(theirs[-1])
    core = core_of(theirs, ordered)
    held = int(np.count_nonzero((theirs >= core[0]) & (theirs <= core[1])))
    return Separation(
        tolerance, key, m, n, larger, *newcombe(larger, m, n), *ends, _between(ordered, *ends), *core,
        _between(ordered, *core), held,
    )  # fmt: skip


def larger_in(values: np.ndarray, failed: np.ndarray) -> float:
    """Probability that of one failed and one passed run the failed one has the larger value, half of ties."""
    from scipy.stats import rankdata

    m, n = int(failed.sum()), int((~failed).sum())
    pairs = float(rankdata(values)[failed].sum()) - 0.5 * m * (m + 1)
    return pairs / (m * n)


def newcombe(larger: float, m: int, n: int) -> tuple[float, float]:
    """The 95 % interval of such a probability from ``m`` and ``n`` runs."""
    from scipy.optimize import brentq

    if larger == 0.0:
        low, high = newcombe(1.0, n, m)
        return 1.0 - high, 1.0 - low
    more = 0.5 * (m + n) - 1.0

    def beyond(t: float) -> float:
        spread = t * (1.0 + more * ((1.0 - t) / (2.0 - t) + t / (1.0 + t))) / (m * n)
        # Where all pairs agree both sides have the factor 1 - t: without it one root is left.
        return 1.0 - t - Z95**2 * spread if larger == 1.0 else (t - larger) ** 2 - Z95**2 * (1.0 - t) * spread

    low = float(brentq(beyond, 0.0, larger, xtol=1e-12))
    return low, 1.0 if larger == 1.0 else float(brentq(beyond, larger, 1.0, xtol=1e-12))


def core_of(theirs: np.ndarray, ordered: np.ndarray) -> tuple[float, float]:
    """The range with the fewest runs that holds 95 % of the failed ones; both sorted, the narrowest of equals."""
    need = math.ceil(CORE * len(theirs) - 1e-9)
    starts, ends = theirs[: len(theirs) - need + 1], theirs[need - 1 :]
    inside = np.searchsorted(ordered, ends, "right") - np.searchsorted(ordered, starts, "left")
    at = np.lexsort((ends - starts, inside))[0]
    return float(starts[at]), float(ends[at])


def _between(ordered: np.ndarray, low: float, high: float) -> int:
    return int(np.searchsorted(ordered, high, "right") - np.searchsorted(ordered, low, "left"))


def shares(values: np.ndarray, failed: np.ndarray) -> list[Share]:
    """The part of failed runs in each tenth of a parameter's runs; by value where there are ten values or fewer."""
    different = np.unique(values)
    if len(different) <= BINS:
        return [_share(x, x, failed[values == x]) for x in different]
    # Ends are values that occur, so that equal values stay together and no part is empty.
    ends = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1), method="inverted_cdf"))
    part = np.minimum(np.searchsorted(ends, values, "right") - 1, len(ends) - 2)
    return [_share(ends[i], ends[i + 1], failed[part == i]) for i in range(len(ends) - 1)]


def _share(start: float, end: float, failed: np.ndarray) -> Share:
    count, runs = int(failed.sum()), len(failed)
    return Share(float(start), float(end), count, runs, count / runs, *clopper_pearson(count, runs))
