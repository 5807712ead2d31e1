"""The inference network and its training, against SciPy's interpolation, Mamdani in NumPy, and least squares."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from leadscrew.neural.inference_net import (
    AXIS,
    CENTRES,
    CHINESE_RULES,
    W0,
    Fired,
    fired,
    initial_rules,
    network_output,
    regressors,
)
from leadscrew.neural.samples import LEVELS, Samples, copied_rmse, reasoning_samples, train_rules, trained_start
from leadscrew.util.errors import DataError, ValueRefused

BOTH = pytest.mark.parametrize("rules", [initial_rules(), CHINESE_RULES], ids=["initial", "chinese"])


def said(weights, e, ec):
    return network_output(weights, fired(AXIS, AXIS, e, ec))


def mamdani(rules):
    """Minimum, minimum, maximum, centroid of 241 points: loops over everything, nothing shared with the toolbox."""
    points = np.linspace(-6.0, 6.0, 241)

    def member(k, x):
        return np.clip(1.0 - np.abs(np.asarray(x) - CENTRES[k]) / 2.0, 0.0, 1.0)

    found = []
    for ec in LEVELS:
        for e in LEVELS:
            united = np.zeros(points.size)
            for j in range(7):
                for i in range(7):
                    strength = min(member(j, ec), member(i, e))
                    which = round(rules[j, i] / 2.0) + 3
                    united = np.maximum(united, np.minimum(strength, member(which, points)))
            found.append((united * points).sum() / united.sum())
    return np.array(found)


# ---- what it computes
def test_outputs_worked_by_hand():
    assert said(W0, 0.0, 0.0) == 0.0
    assert said(W0, 2.0, 0.0) == pytest.approx(-2.038709, abs=1e-12)  # a peak: one rule alone
    assert said(W0, 1.0, 0.0) == pytest.approx(-2.038709 / 2.0, abs=1e-12)
    assert said(W0, 1.0, 1.0) == pytest.approx((0.0 - 2.038709 - 2.038709 - 3.718932) / 4.0, abs=1e-12)
    assert said(W0, -6.0, 0.0) == said(W0, -60.0, 0.0) == pytest.approx(5.013288)
    assert said(W0, 9.0, 9.0) == W0[48] == -5.290580


def test_it_is_the_bilinear_interpolation_of_its_consequents():
    rng = np.random.default_rng(4)
    weights = rng.normal(size=49)
    plain = RegularGridInterpolator((CENTRES, CENTRES), weights.reshape(7, 7))
    for e, ec in rng.uniform(-6.0, 6.0, (300, 2)):
        assert said(weights, e, ec) == pytest.approx(plain([[ec, e]])[0], abs=1e-12)
        assert regressors(e, ec)[0] @ weights == pytest.approx(plain([[ec, e]])[0], abs=1e-12)


def test_four_neighbours_fire_also_at_the_ends():
    assert fired(AXIS, AXIS, 0.5, -5.0) == Fired(3, 0, 0.25, 0.5)
    assert fired(AXIS, AXIS, 100.0, -100.0) == Fired(5, 0, 1.0, 0.0)
    # a reading that is no number chooses a rule that exists, and the output says that it is none
    lost = fired(AXIS, AXIS, float("nan"), 0.0)
    assert 0 <= lost.i <= 5 and np.isnan(said(W0, float("nan"), 0.0))


def test_the_initial_rules_are_those_of_macvicar_whelan():
    rules = initial_rules()
    assert rules[3].tolist() == [6.0, 4.0, 2.0, 0.0, -2.0, -4.0, -6.0]  # EC = ZO
    assert rules[0].tolist() == [6.0, 6.0, 6.0, 6.0, 4.0, 2.0, 0.0]
    assert (rules == -rules[::-1, ::-1]).all() and (rules == rules.T).all()
    # the Chinese table is not odd; its centre pushes where the other one does nothing
    assert (CHINESE_RULES[3] == [4, 4, 2, 0, -2, -4, -4]).all() and CHINESE_RULES[1, 3] == 2.0


# ---- training
@BOTH
def test_the_toolbox_reasons_as_plain_numpy_does(rules):
    samples = reasoning_samples(rules)
    assert samples.d == pytest.approx(mamdani(rules), abs=1e-12)
    assert samples.e[:13].tolist() == LEVELS.tolist() and (samples.ec[:13] == -6.0).all()


@BOTH
def test_one_pass_is_batch_least_squares(rules):
    samples = reasoning_samples(rules)
    trained = train_rules(samples)
    h = regressors(samples.e, samples.ec)
    # the filter's own optimum, in closed form: least squares with the prior 0, variance 100, and a noise of 0.01
    exact = np.linalg.solve(h.T @ h / 0.01 + np.eye(49) / 100.0, h.T @ samples.d / 0.01)
    assert trained.weights == pytest.approx(exact, abs=1e-9)
    assert trained.covariance == pytest.approx(np.linalg.inv(h.T @ h / 0.01 + np.eye(49) / 100.0), abs=1e-12)
    assert trained.rmse - trained.least == pytest.approx(0.0, abs=1e-6)
    assert trained.least == pytest.approx(np.sqrt(np.linalg.lstsq(h, samples.d)[1][0] / 169.0), rel=1e-9)


def test_training_gives_the_digests_numbers():
    assert copied_rmse() == pytest.approx(0.537, abs=5e-4)
    assert copied_rmse(CHINESE_RULES) == pytest.approx(0.321, abs=5e-4)
    assert trained_start().rmse == pytest.approx(0.1702, abs=5e-5)
    assert trained_start(CHINESE_RULES).rmse == pytest.approx(0.1561, abs=5e-5)
    assert trained_start().weights == pytest.approx(W0, abs=1e-6)


def test_49_samples_at_the_peaks_determine_all_rules():
    e, ec = (x.ravel() for x in np.meshgrid(CENTRES, CENTRES))
    wanted = np.random.default_rng(5).normal(size=49)
    trained = train_rules(Samples(e, ec, wanted))
    assert trained.weights == pytest.approx(wanted, abs=1e-3)


def test_a_pass_more_is_the_samples_once_more():
    samples = reasoning_samples()
    start = np.random.default_rng(6).normal(size=49)
    found = train_rules(samples, p0=0.1, start=start, passes=3)
    h = regressors(samples.e, samples.ec)
    exact = np.linalg.solve(3.0 * h.T @ h / 0.01 + np.eye(49) / 0.1, 3.0 * h.T @ samples.d / 0.01 + start / 0.1)
    assert found.weights == pytest.approx(exact, abs=1e-9)


# ---- refusals
@pytest.mark.parametrize(
    ("samples", "words"),
    [
        (([], [], []), "expected as many of each"),
        (([1.0], [1.0, 2.0], [1.0]), "1 of E, 2 of EC"),
        (([1.0, np.nan], [0.0, 0.0], [0.0, 0.0]), r"E\[1\] is not finite"),
    ],
)
def test_bad_samples_are_refused(samples, words):
    with pytest.raises(DataError, match=words):
        train_rules(Samples(*map(np.array, samples)))


@pytest.mark.parametrize("given", [{"r": 0.0}, {"p0": -1.0}, {"passes": 0}, {"r": np.nan}])
def test_bad_variances_are_refused(given):
    with pytest.raises(ValueRefused, match=f"{next(iter(given))} = .*train_rules"):
        train_rules(reasoning_samples(), **given)


@pytest.mark.parametrize(
    "rules", [np.zeros((7, 6)), np.full((7, 7), 1.0), np.full((7, 7), 8.0), np.full((7, 7), np.nan)]
)
def test_rules_that_are_no_sets_are_refused(rules):
    with pytest.raises(ValueRefused, match="rules"):
        reasoning_samples(rules)
