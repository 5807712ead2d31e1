"""Percentiles and yields: their intervals hold what they say, and 100,000 runs take no time."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy import stats

from leadscrew.tune import statistics
from leadscrew.tune.montecarlo import Tolerance, tolerance, tolerances
from leadscrew.tune.sensitivity import rank_correlations
from leadscrew.util.errors import ValueRefused
from tests.tune.shared import job


def test_the_interval_of_a_yield_is_scipys():
    for passed, runs in ((0, 10), (3, 10), (10, 10), (997, 1000), (1, 1)):
        theirs = stats.binomtest(passed, runs).proportion_ci(0.95, "exact")
        assert statistics.clopper_pearson(passed, runs) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


@pytest.mark.parametrize("percent", statistics.PERCENTILES)
@pytest.mark.parametrize("runs", [10, 59, 1000])
def test_order_statistics_cover_a_percentile_as_often_as_they_say(percent, runs):
    low, high = statistics.order_interval(runs, percent)
    below = stats.binom(runs, percent / 100)
    # X(low) <= percentile < X(high) when low to high - 1 values lie below it.
    assert below.cdf(high - 1) - below.cdf(low - 1) >= 0.95
    assert 0 <= low < high <= runs + 1


def test_the_median_of_many_experiments_is_inside_its_interval():
    drawn = np.random.default_rng(3).exponential(size=(2000, 101))
    held = [statistics.quantiles(x, (50,))[0] for x in drawn]
    inside = np.mean([q.low <= np.log(2) <= q.high for q in held])
    assert 0.945 <= inside <= 0.985


def test_too_few_runs_leave_an_end_open():
    first, last = statistics.quantiles(np.arange(20.0), (1, 99))
    assert np.isnan(first.low) and np.isnan(last.high) and first.high == first.high
    assert all(np.isnan(q.value) for q in statistics.quantiles(np.array([])))


def test_diverged_runs_and_runs_without_a_value_are_counted_apart():
    values = np.array([1.0, 2.0, 3.0, np.nan, np.nan, np.nan])
    diverged_at = np.array([np.nan] * 4 + [0.1, 0.2])
    row = statistics.spread("s", "m", values, diverged_at)
    assert (row.runs, row.diverged, row.without) == (6, 2, 1)
    assert (row.least, row.greatest, row.mean) == (1.0, 3.0, 2.0)
    assert statistics.yielded(Tolerance("m", "<=", 2.5).kept(values))[:3] == (2, 6, 2 / 6)
    assert statistics.yielded(Tolerance("m", ">=", 2.5).kept(values)).passed == 1


@pytest.mark.slow
def test_the_work_grows_with_the_runs_and_not_with_their_square():
    rng = np.random.default_rng(0)
    took = []
    for runs in (5_000, 500_000):
        columns = {k: rng.random(runs) for k in "abc"}
        values = columns["a"] + rng.random(runs)
        best = np.inf
        for _ in range(3):
            began = time.process_time()
            statistics.spread("s", "m", values, np.full(runs, np.nan))
            rank_correlations(columns, values)
            best = min(best, time.process_time() - began)
        took.append(best)
    assert took[1] < 2_000.0 * took[0]  # the square: 10,000


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("overshoot<=0.01", Tolerance("overshoot", "<=", 0.01)),
        (" rise_time >= 1e-3 ", Tolerance("rise_time", ">=", 1e-3)),
        ("overshoot@step_m50<=0", Tolerance("overshoot", "<=", 0.0, "step_m50")),
    ],
)
def test_tolerances_are_read(text, found):
    assert tolerance(text) == found and tolerance(str(found)) == found


@pytest.mark.parametrize("text", ["overshoot", "overshoot<0.1", "overshoot<=x", "overshoot<=nan", "<=1", "a=1", ""])
def test_what_is_no_tolerance_is_refused(text):
    with pytest.raises(ValueRefused, match="expected METRIC<=VALUE"):
        tolerance(text)


def test_two_tolerances_that_leave_one_value_are_no_contradiction():
    assert len(tolerances(["max_error<=1", "max_error>=1"], job())) == 2
    with pytest.raises(ValueRefused, match="contradict each other"):
        tolerances(["max_error<=1", "max_error>=1.001"], job())
