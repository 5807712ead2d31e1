"""The Kalman update by four active rules, against the plain matrix formula; and what forgetting does."""

import math

import numpy as np
import pytest

from leadscrew.neural.inference_net import AXIS, W0, Fired, fired
from leadscrew.neural.kalman import kalman_learn
from leadscrew.neural.kalman_dense import kalman_learn_dense, regressor, updated
from leadscrew.studies.sofnn_tangent.covariance import covariance_forms, judged, kept
from leadscrew.util.errors import NameUnknown
from tests.neural.learner import learned, learner_loop, state

MILD = {"q": 0.05, "cap": 4.0, "r": 0.01}


def correlated(seed=1, size=1.0):
    """A covariance in which every rule hangs on every other."""
    a = np.random.default_rng(seed).normal(size=(49, 60))
    square = a @ a.T  # which need not be symmetric to the last bit: that hangs on the processor
    return size * (square + square.T) / 120.0


def test_one_update_worked_by_hand():
    # a peak: one rule fires, P = I; s = 1.01, the consequent moves by 0.5 / 1.01, its variance falls to 0.01 / 1.01
    weights, covariance = np.zeros(49), np.eye(49)
    s = kalman_learn(weights, covariance, Fired(2, 3, 0.0, 0.0), 0.5, 0.01, 0.0, math.inf, 6.0)
    assert s == pytest.approx(1.01)
    assert weights[23] == pytest.approx(0.5 / 1.01) and np.count_nonzero(weights) == 1
    assert covariance[23, 23] == pytest.approx(0.01 / 1.01, rel=1e-12)
    assert np.delete(covariance.diagonal(), 23).tolist() == [1.0] * 48


@pytest.mark.slow
@pytest.mark.parametrize("cap", [4.0, 0.5, math.inf])
def test_four_rules_do_what_all_of_them_do(cap):
    rng = np.random.default_rng(2)
    fast, plain = [W0.copy(), correlated()], [W0.copy(), correlated()]
    for _ in range(25):
        at = fired(AXIS, AXIS, *rng.uniform(-7.0, 7.0, 2))
        given = (at, rng.normal(), 0.01, 0.05, cap, 2.0)
        assert kalman_learn(*fast, *given) == pytest.approx(kalman_learn_dense(*plain, *given), rel=1e-12)
        assert fast[0] == pytest.approx(plain[0], abs=1e-12) and fast[1] == pytest.approx(plain[1], abs=1e-12)
        assert (fast[1] == fast[1].T).all()


def test_the_cap_scales_and_keeps_correlations():
    before = correlated(size=3.0)
    weights, covariance = np.zeros(49), before.copy()
    free = before.copy()
    for p, cap in ((covariance, 1.5), (free, math.inf)):
        kalman_learn(weights, p, Fired(0, 0, 0.3, 0.6), 0.0, 0.01, 0.05, cap, 6.0)

    def correlation(p):
        d = np.sqrt(p.diagonal())
        return p / np.outer(d, d)

    assert covariance.diagonal().max() == pytest.approx(1.5, rel=1e-12)
    assert correlation(covariance) == pytest.approx(correlation(free), abs=1e-12)
    assert (free.diagonal() > 1.5).any()


def test_consequents_stay_inside_the_clamp():
    weights, covariance = np.zeros(49), 100.0 * np.eye(49)
    kalman_learn(weights, covariance, Fired(3, 3, 0.5, 0.5), 1e6, 0.01, 0.0, math.inf, 2.5)
    assert weights.max() == 2.5
    kalman_learn(weights, covariance, Fired(3, 3, 0.5, 0.5), -1e9, 0.01, 0.05, 4.0, 2.5)
    assert weights.min() == -2.5


def test_what_decays_becomes_zero_and_not_denormal():
    weights, covariance = np.zeros(49), np.eye(49)
    covariance[10, 20] = covariance[20, 10] = 1e-29
    for _ in range(6):
        kalman_learn(weights, covariance, Fired(0, 0, 0.0, 0.0), 0.0, 0.01, 1.0, 0.5, 6.0)
    assert covariance[10, 20] == covariance[20, 10] == 0.0


def test_no_excitation_leaves_the_cap_and_not_more():
    covariance = learned(3000, **MILD)
    assert covariance[0, 0] == pytest.approx(4.0, rel=1e-12) and covariance.diagonal().max() < 4.0 + 1e-12
    assert judged(covariance)[1]


def test_after_20000_updates_it_is_symmetric_and_positive_definite():
    for given in ({}, MILD):
        covariance = learned(**given)
        assert np.abs(covariance - covariance.T).max() <= 1e-10
        assert np.linalg.eigvalsh(covariance)[0] > 0.0


def test_the_network_learns_its_teacher():
    live = learner_loop(inside=6.0, error=0.0, **MILD).start()
    live.advance(3000, every=0)
    assert state(live).weights == pytest.approx(W0, abs=1e-9)


@pytest.mark.slow
def test_it_equals_the_dense_update_over_100000_steps():
    loop = learner_loop(inside=6.5, **MILD)
    p = loop.blocks["controller"].params
    live = loop.start()
    weights, covariance, first, second = np.zeros(49), 1e4 * np.eye(49), 0.0, 0.0
    worst = 0.0
    for k in range(100_000):
        first = first + 0.7548776662466927
        second = second + 0.5698402909980532
        first, second = first - math.floor(first), second - math.floor(second)
        at = fired(AXIS, AXIS, p.inside * (2.0 * first - 1.0), p.inside * (2.0 * second - 1.0))
        h = regressor(at)
        innovation = h @ W0 + p.error * math.sin(50.0 * first) - h @ weights
        kalman_learn_dense(weights, covariance, at, innovation, p.r, p.q, p.cap, 6.0)
        if (k + 1) % 2500 == 0:
            live.advance(2500, every=0)
            ours = state(live)
            worst = max(worst, np.abs(ours.weights - weights).max(), np.abs(ours.covariance - covariance).max())
    assert worst < 1e-9


# ---- forms of the update
@pytest.mark.parametrize("form", ["naive", "symmetrised", "joseph"])
def test_all_forms_are_one_in_double_precision(form):
    p, h = correlated(), regressor(Fired(1, 4, 0.2, 0.7))
    information = np.linalg.inv(p) + np.outer(h, h) / 0.05
    gain, after = updated(p, h, 0.05, form)
    assert after == pytest.approx(np.linalg.inv(information), abs=1e-9)
    assert gain == pytest.approx(after @ h / 0.05, abs=1e-9)
    wider = updated(p, h, 0.05, form, forgetting=0.9)[1]
    assert wider == pytest.approx(updated(p / 0.9, h, 0.05, form)[1], abs=1e-12)


def test_an_unknown_form_is_refused():
    with pytest.raises(NameUnknown, match="there are naive, symmetrised, joseph"):
        updated(np.eye(49), np.ones(49), 0.1, "josef")


@pytest.mark.slow
def test_the_table_of_forms_is_what_it_is_made_of():
    again = covariance_forms()
    for ours, theirs in zip(again, kept(), strict=True):
        assert ours[:5] == theirs[:5]
        single_naive = (ours.form, ours.bits) == ("naive", 32)
        if ours.finite:
            assert ours.trace == pytest.approx(theirs.trace, rel=1e-3)
            # where the smallest eigenvalue is rounding, and so another machine's, is not compared
            assert ours.positive == theirs.positive or ours.form == "naive"
        if single_naive and ours.forgetting == 1.0 and ours.updates >= 2000:
            assert not ours.positive
