"""Whether a predictor helps: the errors by hand, and a verdict that noise does not give away."""

import numpy as np
import pytest

from leadscrew.grey.score import Score, compare, standard_errors
from leadscrew.util.errors import DataError


def scored(y, *models, **options):
    return {s.model: s for s in compare(y, models, **options)[0]}


def test_errors_are_those_of_each_prediction_against_what_came():
    y = np.random.default_rng(2).uniform(100.0, 200.0, 30)
    for horizon in (1, 3):
        error = np.array([y[i] + horizon * (y[i] - y[i - 1]) - y[i + horizon] for i in range(4, 30 - horizon)])
        base = np.array([y[i] - y[i + horizon] for i in range(4, 30 - horizon)])
        found = scored(y, "two_point", "last", horizon=horizon)
        assert found["two_point"].rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
        assert found["two_point"].bias == pytest.approx(error.mean(), rel=1e-9)
        assert abs(found["two_point"].worst) == pytest.approx(np.abs(error).max(), rel=1e-12)
        assert found["two_point"].better_share == np.mean(np.abs(error) < np.abs(base))
        assert found["last"].rmse == pytest.approx(np.sqrt(np.mean(base**2)), rel=1e-12)


def test_grey_prediction_loses_on_noise_about_a_set_point():
    y = 150.0 + np.random.default_rng(1).normal(size=2000)
    found = scored(y, "gm11", "last")
    # White noise: the error of the last value has variance 2, that of the filter 1 + 1.5.
    assert found["gm11"].rmse / found["last"].rmse == pytest.approx(np.sqrt(2.5 / 2.0), rel=0.03)
    assert found["gm11"].verdict == "worse"


def test_grey_prediction_wins_on_growth():
    y = 20.0 * np.exp(0.02 * np.arange(120)) + 0.01 * np.random.default_rng(1).normal(size=120)
    assert scored(y, "gm11", "last")["gm11"].verdict == "better"


def test_equal_predictors_are_not_told_apart():
    y = np.random.default_rng(1).normal(size=50)
    assert scored(y, "last")["last"].against_last == 0.0
    assert scored(np.full(40, 3.0), "gm11", "last")["gm11"].verdict == "undecided"


def test_the_standard_error_counts_correlation_between_neighbours():
    """The sum of two neighbours of white noise: its mean scatters 1.41 times as much as its variance alone says."""
    noise = np.random.default_rng(5).normal(size=(400, 2001))
    scatter = np.std([standard_errors(x[1:] + x[:-1]) for x in noise])
    assert scatter == pytest.approx(1.0, abs=0.12)


def test_the_standard_error_is_that_of_newey_and_west():
    """With their weights it is the mean square of the sums over lag + 1 samples in a row, zeros at both ends."""
    x = 0.3 + np.cumsum(np.random.default_rng(3).normal(size=30))
    lag = 6  # 2 * 30^(1/3) = 6.2
    sums = np.convolve(x - x.mean(), np.ones(lag + 1))
    assert standard_errors(x) == pytest.approx(30 * x.mean() / np.sqrt(np.mean(sums**2) * sums.size / (lag + 1)))


def test_too_few_samples_are_refused():
    with pytest.raises(DataError, match="14 samples: windows of 5 and a horizon of 1 need at least 15"):
        compare(np.arange(14.0), ["gm11"])
    assert len(compare(np.arange(15.0), ["gm11"])[0]) == 1


def test_a_predictor_is_better_or_worse_from_two_standard_errors_on():
    verdicts = [Score("m", 1.0, 1.0, 0.0, 0.5, t).verdict for t in (-2.1, -2.0, 1.9, 2.0, 2.1)]
    assert verdicts == ["better", "undecided", "undecided", "undecided", "worse"]


def test_the_largest_error_keeps_its_sign():
    y = np.zeros(30)
    y[20] = 5.0  # the last value says 0 where 5 comes, then 5 where 0 comes: the first of equals counts
    assert scored(y, "last")["last"].worst == -5.0
    y[20] = -5.0
    assert scored(y, "last")["last"].worst == 5.0
