"""Which runs fail: against SciPy, against counting all pairs, and whether the interval holds the truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from leadscrew.tune.executors import Threads
from leadscrew.tune.montecarlo import core_of, larger_in, montecarlo, newcombe, questions, separation, shares
from leadscrew.tune.statistics import clopper_pearson
from tests.tune.shared import job


def pairs(values, failed):
    """The same by counting every pair."""
    return np.mean([(a > b) + 0.5 * (a == b) for a in values[failed] for b in values[~failed]])


@pytest.mark.parametrize("grid", [0, 4])
def test_the_statistic_is_that_of_mann_and_whitney(grid):
    rng = np.random.default_rng(1)
    for _ in range(30):
        n = int(rng.integers(3, 40))
        values = rng.integers(0, grid, n).astype(float) if grid else rng.random(n)
        failed = np.arange(n) < rng.integers(1, n)
        theirs = stats.mannwhitneyu(values[failed], values[~failed]).statistic
        found = separation(values, failed)
        assert found.larger == pytest.approx(theirs / (found.failed * found.passed), abs=1e-12)
        assert found.larger == pytest.approx(pairs(values, failed), abs=1e-12)
        assert 0.0 <= found.larger_low <= found.larger <= found.larger_high <= 1.0


def test_the_ends_of_the_interval_are_where_the_equation_says():
    """By a search over all values of a fine grid."""
    for larger, m, n in ((0.8, 20, 480), (0.0, 5, 50), (1.0, 20, 280), (0.31, 7, 9)):
        t = np.linspace(0, 1, 2_000_001)
        mean = 0.5 * (m + n)
        variance = t * (1 - t) * (1 + (mean - 1) * ((1 - t) / (2 - t) + t / (1 + t))) / (m * n)
        inside = t[np.abs(t - larger) <= stats.norm.ppf(0.975) * np.sqrt(variance)]
        low, high = newcombe(larger, m, n)
        # The ends 0 and 1 always solve it; where all pairs agree the other one counts.
        if larger in (0.0, 1.0):
            inside = np.append(inside, larger)
        assert (low, high) == pytest.approx((inside.min(), inside.max()), abs=2e-6)
        assert newcombe(1 - larger, n, m) == pytest.approx((1 - high, 1 - low), abs=1e-9)


@pytest.mark.parametrize(("m", "n", "shift"), [(20, 480, 1.5), (10, 100, 0.5), (5, 200, 2.5), (30, 30, 0.0)])
def test_the_interval_holds_the_truth_95_times_in_100(m, n, shift):
    rng = np.random.default_rng(4)
    true = stats.norm.cdf(shift / np.sqrt(2))
    failed = np.arange(m + n) < m
    held = 0
    for _ in range(800):
        values = rng.standard_normal(m + n) + shift * failed
        low, high = newcombe(larger_in(values, failed), m, n)
        held += low <= true <= high
    assert 0.93 <= held / 800 <= 0.99


def test_where_the_failures_lie_is_counted():
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    failed = np.array([False, False, False, True, False, True])
    found = separation(values, failed)
    assert (found.low, found.high, found.inside, found.failed) == (4.0, 6.0, 3, 2)


def test_the_core_is_the_window_with_the_fewest_runs():
    rng = np.random.default_rng(8)
    for _ in range(40):
        values = rng.integers(0, 60, 120) / 7
        failed = rng.random(120) < rng.choice([0.05, 0.3])
        failed[:2] = True, False
        theirs = np.sort(values[failed])
        need = int(np.ceil(0.95 * len(theirs) - 1e-9))
        windows = [
            (np.sum((values >= a) & (values <= b)), b - a, a, b)
            for a in theirs for b in theirs
            if b >= a and np.sum((theirs >= a) & (theirs <= b)) >= need
        ]  # fmt: skip
        found = separation(values, failed)
        count, width, *_ = min(windows)
        assert (found.core_inside, found.core_high - found.core_low) == pytest.approx((count, width))
        assert found.core_failed == np.sum((theirs >= found.core_low) & (theirs <= found.core_high)) >= need
    assert core_of(np.array([3.0]), np.array([1.0, 3.0])) == (3.0, 3.0)


def test_shares_take_every_run_once():
    rng = np.random.default_rng(0)
    for values in (rng.random(503), rng.integers(0, 4, 503) * 1.0, np.minimum(rng.random(503), 0.4)):
        failed = rng.random(503) < 0.2
        parts = shares(values, failed)
        assert sum(p.runs for p in parts) == 503 and sum(p.failed for p in parts) == failed.sum()
        assert len(parts) <= 10 and min(p.runs for p in parts) > 0
        for p in parts[:-1]:
            held = (values >= p.start) & ((values < p.end) | (values == p.start))
            assert (p.runs, p.failed) == (held.sum(), failed[held].sum())
            assert (p.low, p.high) == clopper_pearson(p.failed, p.runs)


def test_a_cliff_that_no_correlation_sees():
    """Short lags diverge, and nothing else about the lag matters to the gain's share in it."""
    found = montecarlo(
        job(), {"plant.lag_s": "0.0002:0.08:log", "controller.kp": "3.9:4.1"}, 400, seed=4,
        tolerances=("max_error<=1.02", "max_error<=1e9"), crew=Threads(2),
    )  # fmt: skip
    assert 0 < found.diverged.sum() < 400
    asked = questions(found)
    assert np.array_equal(asked["diverged"], found.diverged)
    assert {r.tolerance for r in found.failures} == set(asked)
    rows = {(r.tolerance, r.key): r for r in found.failures}
    lag, gain = rows["diverged", "plant.lag_s"], rows["diverged", "controller.kp"]
    assert lag.larger < 0.02 and lag.larger_high < 0.1 and lag.inside <= 1.1 * lag.failed
    assert abs(gain.larger - 0.5) < 0.1
    assert found.failures[0].key == "plant.lag_s"
    everything = montecarlo(job(), {"plant.lag_s": (0.02, 0.08)}, 50, tolerances=("rms_error<=1e9", "rms_error<=0"))
    assert everything.failures == ()
