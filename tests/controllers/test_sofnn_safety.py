"""What keeps a network that learns in bounds: lost sensor, saturation, straight lines, long runs."""

import numpy as np
import pytest

from leadscrew.controllers.sofnn import TUNINGS, sofnn
from leadscrew.neural.inference_net import W0
from tests.controllers.sofnn_loop import CURVATURE, HEADING, QUIET, STRAIGHT, knife_loop, rms, state_of
from tests.controllers.test_sofnn import stepped, wandering
from tests.studies import tangent_oracle

LEARNING = ("paper.sofnn_pnn", "ours.sofnn_tuned", "ours.sofnn_nlms", "ours.sofc_tuned")
PUSHED = {**QUIET, "disturbance.push": 30.0, "disturbance.step_at": 1.0, "disturbance.step_for": 2.0}
"""A cut that is pushed aside by twice what the axis can make up for, for 2 s."""
LAP = 503
"""Samples of a lap of the wavy line: 40 pi 2 mm, but for 0.3 mm."""


def lost(name, from_s=3.0, for_s=1.0):
    """The knife with a sensor that is lost for a while."""
    return knife_loop(TUNINGS[name](fade_s=0.2)).using({"sensor.lost_from_s": from_s, "sensor.lost_for_s": for_s})


# ---- a lost sensor
BOTH = ["ours.sofnn_tuned", pytest.param("ours.sofc_tuned", marks=pytest.mark.slow)]


@pytest.mark.parametrize("name", BOTH)
def test_a_sensor_lost_for_a_second_holds_the_rules_and_fades_the_offset(name):
    live = lost(name).start()
    live.advance(300)
    before = state_of(live)
    during = live.advance(100)
    after = state_of(live)
    assert np.array_equal(before.weights, after.weights)
    if name == "ours.sofnn_tuned":
        assert np.array_equal(before.covariance, after.covariance)
    assert during["output"] == pytest.approx(before.offset * np.exp(-0.01 / 0.2 * np.arange(1, 101)), rel=1e-9)
    delay = 6
    live.advance(delay)
    assert np.array_equal(state_of(live).weights, before.weights), "what fired while it was lost is not known"
    live.advance(2)
    assert not np.array_equal(state_of(live).weights, before.weights)
    back = live.advance(100)["actual.deviation"]
    assert rms(back[30:]) < 0.4 < rms(during["actual.deviation"])


def test_no_difference_is_taken_across_the_gap():
    readings = np.array([1.0] * 5 + [1.0] * 4 + [20.0] * 2)
    seen = np.array([1.0] * 5 + [0.0] * 4 + [1.0] * 2)
    state = stepped(sofnn(filter_s=0.0), readings, seen)[1]
    assert state.watch.rate == 0.0 and state.watch.error == 20.0 and state.watch.known == 2


def test_a_sensor_that_never_sees_sends_nothing_and_learns_nothing():
    sent, state = stepped(sofnn, wandering(100), np.zeros(100))
    assert not sent.any() and np.array_equal(state.weights, W0)


@pytest.mark.slow
def test_holding_the_offset_through_a_long_loss_is_worse_than_fading_it_on_a_line_of_bends():
    starts = np.arange(1.0, 6.0, 0.5)
    loop = knife_loop(TUNINGS["ours.sofnn_tuned"], *tangent_oracle.flower()).using({"sensor.lost_for_s": 1.0})
    found = {}
    for fade in (0.2, 1e5):
        e = loop.using({"controller.fade_s": fade}).batch(
            7.0, {"sensor.lost_from_s": starts}, record="actual.deviation"
        )
        blind = [e["actual.deviation"][k, round(at / 0.01) + 1 :][:100] for k, at in enumerate(starts)]
        found[fade] = rms(blind)
    assert found[0.2] < 0.9 * found[1e5]


# ---- saturation
@pytest.mark.parametrize("name", [*BOTH, pytest.param("paper.sofnn_pnn", marks=pytest.mark.slow)])
def test_at_its_limit_it_learns_nothing_and_comes_back_soon(name):
    live = knife_loop(TUNINGS[name](freeze=True), *STRAIGHT).using(PUSHED).start()
    live.advance(250)
    before = state_of(live)
    pushed = live.advance(50)
    assert abs(before.offset) > 0.99 * 15.0 and np.array_equal(before.weights, state_of(live).weights)
    assert abs(pushed["output"]).max() <= 15.0
    back = abs(live.advance(300)["actual.deviation"])
    assert np.flatnonzero(back > 2.0)[-1] * 0.01 < (1.1 if name.startswith("paper") else 0.35)
    free = knife_loop(TUNINGS[name](freeze=False, leak=0.0), *STRAIGHT).using(PUSHED).start()
    free.advance(250)
    before = state_of(free)
    free.advance(50)
    if "sofnn" in name:
        assert not np.array_equal(before.covariance, state_of(free).covariance)


# ---- long runs
def healthy(state):
    """Finite, inside bounds, a covariance as it has to be."""
    assert np.isfinite(state.weights).all() and abs(state.weights).max() <= 6.0
    if hasattr(state, "covariance"):
        p = state.covariance
        assert np.array_equal(p, p.T) and p.diagonal().max() <= 4.0 * (1.0 + 1e-12)
        assert np.linalg.eigvalsh(p)[0] > 0.0


def laps(name, count):
    """RMS of each lap of the wavy line, and the state at the end."""
    live = knife_loop(TUNINGS[name], HEADING[:LAP], CURVATURE[:LAP], again=True).start()
    found = []
    for _ in range(count):
        found.append(rms(live.advance(LAP)["actual.deviation"]))
    return np.array(found), state_of(live)


@pytest.mark.parametrize("name", BOTH)
def test_ten_laps_learn_no_worse_than_two(name):
    found, state = laps(name, 10)
    healthy(state)
    assert found[-3:].mean() <= 1.1 * found[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", LEARNING)
def test_a_hundred_thousand_samples_of_learning_do_not_drift(name):
    found, state = laps(name, 200)
    healthy(state)
    assert abs(found[-50:].mean() - found[1:51].mean()) < 0.05 * found[1:51].mean()
    assert found[1:].max() < 1.3 * np.median(found[1:])


@pytest.mark.slow
@pytest.mark.parametrize("name", LEARNING)
def test_a_straight_line_with_noise_teaches_nothing_that_drifts(name):
    still = {"plant.material.bias": 0.0, "disturbance.size": 0.0}
    live = knife_loop(TUNINGS[name], *STRAIGHT).using(still).start()
    found = np.array([rms(live.advance(5000)["actual.deviation"]) for _ in range(20)])
    healthy(state_of(live))
    assert found.max() < 0.12 and abs(found[-5:].mean() - found[:5].mean()) < 0.01


def test_a_leak_brings_unused_rules_back_to_the_prior():
    learned = np.clip(W0 + 1.0, -6.0, 6.0)
    block = sofnn(leak=0.01).starting(weights=learned)
    state = stepped(block, np.zeros(206))[1]
    corner = state.weights[-1] - W0[-1]
    assert corner == pytest.approx((learned[-1] - W0[-1]) * 0.99**200, rel=1e-6)
