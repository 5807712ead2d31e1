"""The network while it learns: what interrupts it, what it keeps, what it does in the long run."""

import math

import numpy as np
import pytest

from leadscrew.neural.performance import GOLDEN
from leadscrew.neural.safety import crossing
from leadscrew.studies.sofnn_tangent import experiments
from leadscrew.studies.sofnn_tangent.claims import PUSH, range_of_the_offset
from leadscrew.studies.sofnn_tangent.cuts import (
    PNN,
    TABLE,
    TUNED,
    deviations,
    learned,
    rms,
    rules,
    started,
)
from leadscrew.studies.sofnn_tangent.scenarios import samples_of
from tests.studies.tangent_lab import lab

LOSS = {"sensor.lost_from_s": 4.0, "sensor.lost_for_s": 1.0}


@pytest.mark.slow
def test_while_the_camera_is_lost_no_rule_moves_and_the_offset_fades():
    live = lab().loop(TUNED, "wave_fabric").using(LOSS).start()
    live.advance(400)
    before = rules(live)
    sent = live.advance(100, record=("output",))["output"]
    after = rules(live)
    assert np.array_equal(before.weights, after.weights) and np.array_equal(before.covariance, after.covariance)
    fade = math.exp(-0.01 / lab().study.controllers[TUNED].params.fade_s)
    assert sent == pytest.approx(before.offset * fade ** np.arange(1, 101), rel=1e-9)
    live.advance(20)
    assert not np.array_equal(rules(live).weights, after.weights)


@pytest.mark.slow
def test_at_the_limit_of_the_offset_a_frozen_network_stands_still():
    moved = {}
    for freeze in (True, False):
        changes = {**PUSH, "disturbance.step_for": 3.0, "controller.leak": 0.0, "controller.freeze": freeze}
        live = lab().loop(TUNED, "step").using(changes).start()
        live.advance(300)
        before = rules(live)
        live.advance(50)
        assert before.offset == pytest.approx(15.0)
        moved[freeze] = np.abs(rules(live).covariance - before.covariance).max()
    assert moved[True] == 0.0 < moved[False]
    (claim,) = range_of_the_offset.judged(lab())
    assert max(claim.columns().values()) <= 15.0


@pytest.mark.slow
@pytest.mark.parametrize("name", [TABLE, PNN, TUNED])
def test_a_hundred_thousand_samples_of_learning_stay_finite_inside_and_do_not_drift(name):
    e, moved = experiments.idle(lab(), name, 100_000)
    assert np.isfinite(e).all() and abs(e.mean()) < 0.005 and rms(e[-10_000:]) < 0.1 and moved.max() <= 12.0
    assert rms(e) == pytest.approx(rms(e[:50_000]), rel=0.1)
    lap, weights, least = experiments.laps(lab(), name, 127)
    assert np.isfinite(lap).all() and np.abs(weights).max() <= 6.0 and least > 0.0
    assert lap[-20:].mean() <= 1.05 * lap[1:21].mean()


@pytest.mark.slow
def test_pieces_go_on_with_the_rules_of_the_piece_before():
    """Two pieces are one piece, and a second that starts with what the first has learned."""
    both, one = (learned(lab(), TABLE, "wave_leather", count) for count in (2, 1))
    assert np.array_equal(both.weights[0], one.weights[0]) and both.rms[0] == one.rms[0]
    live = started(lab().loop(TABLE, "wave_leather"), 1, one.weights[0], one.covariance)
    assert rms(deviations(live, samples_of("wave"))) == both.rms[1]


@pytest.mark.slow
def test_a_network_with_a_bias_rests_where_its_zero_is(monkeypatch):
    pushed = GOLDEN._replace(out_bias=0.03)
    monkeypatch.setattr(experiments, "network", lambda name: pushed)
    assert experiments.rest(lab(), "pushed") == pytest.approx(crossing(pushed) * 15.0, rel=0.03)
    assert crossing(pushed) * 15.0 > 2.0
