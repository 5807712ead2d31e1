"""Intervals, covariances, whiteness and the one rule for identifiable, against SciPy and by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import optimize, stats

from leadscrew.identify.estimation import (
    coloured,
    correlations,
    fitted,
    fixed,
    given,
    identifiable,
    quantile,
    white,
    whiteness,
)


@pytest.mark.parametrize(
    ("value", "half", "negligible", "known"),
    [
        (100.0, 25.0, 0.0, True),
        (100.0, 25.1, 0.0, False),
        (-100.0, 25.0, 0.0, True),
        (0.0, 1e-9, 0.0, False),
        (0.001, 0.004, 0.004, True),
        (0.001, 0.0041, 0.004, False),
        (100.0, math.inf, math.inf, False),
        (100.0, math.nan, 1.0, False),
    ],
)
def test_identifiable_is_known_to_a_quarter_or_too_small_to_matter(value, half, negligible, known):
    assert identifiable(value, half, negligible) is known


def test_static_friction_counts_by_what_it_is_above_coulomb_friction():
    assert fitted(24.0, (23.0, 25.0)).identifiable
    assert fitted(24.0, (23.0, 25.0), counted=4.0).identifiable
    assert not fitted(24.0, (22.9, 25.1), counted=4.0).identifiable


def test_what_is_given_is_known_and_what_is_fixed_is_not():
    assert given(3.0, "kg").identifiable and not fixed(0.0, "N", "no reversal").identifiable
    assert math.isnan(given(3.0, "kg").low) and fixed(0.0, "N", "no reversal").note == "no reversal"


def test_quantiles_are_those_of_scipy():
    assert quantile() == stats.norm.ppf(0.975)
    assert [quantile(d) for d in (1.0, 2.5, 39.0)] == list(stats.t.ppf(0.975, [1.0, 2.5, 39.0]))


def test_the_covariance_of_independent_residuals_is_that_of_scipy():
    rng = np.random.default_rng(2)
    x = np.linspace(0.0, 1.0, 60)
    y = 2.0 + 3.0 * x + rng.normal(0.0, 0.1, 60)
    (a, b), covariance = optimize.curve_fit(lambda t, a, b: a + b * t, x, y)
    spread = white(np.column_stack([np.ones(60), x]), y - a - b * x)
    assert spread.covariance == pytest.approx(covariance, rel=1e-6) and spread.degrees[0] == 58.0
    table = correlations(spread.covariance, ("a", "b"))
    assert table["a"]["b"] == pytest.approx(covariance[0, 1] / math.sqrt(covariance[0, 0] * covariance[1, 1]), rel=1e-6)


def test_coloured_noise_widens_an_interval_by_what_its_correlation_asks_for():
    """Of a first-order residual with 0.8 from sample to sample the mean is (1 + 0.8) / (1 - 0.8) = 9 times as vague."""
    rng = np.random.default_rng(3)
    left = np.zeros(20_000)
    for k, e in enumerate(rng.normal(size=len(left))):
        left[k] = 0.8 * left[k - 1] + e
    mean = np.ones((len(left), 1))
    ratio = coloured(mean, left - left.mean())[0, 0] / white(mean, left - left.mean()).covariance[0, 0]
    assert ratio == pytest.approx(9.0, rel=0.15)


def test_noise_is_white_and_a_drift_is_not():
    rng = np.random.default_rng(8)
    noise = rng.normal(size=3000)
    assert whiteness(noise).percent > 85.0
    assert whiteness(np.cumsum(noise)).percent < 20.0
    noise[500:900] = np.nan
    assert whiteness(noise).percent > 85.0
    assert np.isnan(whiteness(np.full(50, np.nan)).percent)
    assert whiteness(np.zeros(50)).percent == 100.0


@pytest.mark.parametrize(("changes", "inside"), [(40, 0.0), (41, 100.0), (60, 100.0), (61, 0.0)])
def test_a_residual_is_white_up_to_1_96_standard_errors(changes, inside):
    """Of 102 signs the first autocorrelation is (101 - 2 changes) / 101; allowed are 1.96 / sqrt(101)."""
    runs = [1] * (changes + 1)
    runs[0] += 51 - len(runs[0::2])
    runs[1] += 51 - len(runs[1::2])
    signs = np.concatenate([np.full(n, (-1.0) ** k) for k, n in enumerate(runs)])
    assert len(signs) == 102 and signs.sum() == 0.0 and np.sum(np.diff(signs) != 0.0) == changes
    assert whiteness(signs, lags=1).percent == inside
