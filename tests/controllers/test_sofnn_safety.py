"""What keeps a network that learns in bounds: lost sensor, saturation, straight lines, long runs."""

import numpy as np
import pytest

from leadscrew.controllers._sofnn import fnn, sofc, sofnn
from leadscrew.controllers._sofnn.network import sofnn_all_weights
from leadscrew.neural.inference_net import W0
from leadscrew.sensors._cut_camera import SeenCut
from leadscrew.studies.sofnn_tangent.tunings import TUNINGS
from leadscrew.util.errors import ValueRefused
from tests.controllers.sofnn_loop import CURVATURE, HEADING, QUIET, STRAIGHT, knife_loop, rms, state_of
from tests.controllers.test_sofnn import COMMAND, T, fresh, stepped, wandering
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


def test_the_offset_fades_out_and_in_as_worked_by_hand():
    # 30 deg: rule 7*3 + 4 says -2.038709 levels of 2.5 deg
    rule, keep = -2.5 * 2.038709, np.exp(-T / 0.2)
    sent = stepped(fnn, np.full(40, 30.0), np.repeat([1.0, 0.0, 1.0], [3, 12, 25]))[0]
    gone = rule * keep ** np.arange(1, 13)
    back = rule - (rule - gone[-1]) * keep ** np.arange(1, 26)
    assert sent == pytest.approx(np.concatenate([np.full(3, rule), gone, back]), rel=1e-12)


def test_seen_in_every_second_sample_it_does_half():
    rule, keep = -2.5 * 2.038709, np.exp(-T / 0.2)
    sent = stepped(fnn, np.full(400, 30.0), np.tile([1.0, 0.0], 200))[0]
    assert sent[-2:] == pytest.approx([rule / (1.0 + keep), keep * rule / (1.0 + keep)], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ours.sofnn_tuned", "ours.sofc_tuned", "paper.sofnn_pnn", "corrected.fnn"])
def test_the_offset_does_not_jump_when_the_cut_is_seen_again(name):
    bends = knife_loop(TUNINGS[name], *tangent_oracle.flower())
    largest = {}
    for case, more in {
        "plain": {"sensor.lost_for_s": 0.0},
        "lost": {},
        "at once": {"controller.fade_s": 1e-4},
    }.items():
        starts = {"sensor.lost_from_s": np.arange(1.0, 6.0, 0.5)}
        loop = bends.using({"sensor.lost_for_s": 1.0, **more})
        largest[case] = abs(np.diff(loop.batch(7.5, starts, record="output")["output"], axis=1)).max()
    assert largest["lost"] < 1.6 * largest["plain"] < 0.8 * largest["at once"]


@pytest.mark.parametrize("block", [fnn, sofnn, sofc, sofnn_all_weights])
@pytest.mark.parametrize("reading", [float("nan"), 40.0])
def test_taking_over_while_nothing_is_seen_fades_and_then_fades_in(block, reading):
    block = block if block is fnn else block(learning=False)
    p, rules = block.prepare(block.params, T), getattr(block.params, "prior", W0)
    state = fresh(block.align(p, COMMAND, SeenCut(reading, 0.0), 10.0))
    found = []
    for k in range(160):
        state, d = block.step(p, state, COMMAND, SeenCut(reading, 0.0) if k < 20 else SeenCut(20.0, 1.0), T)
        found.append(d)
    keep = np.exp(-T / 0.2)
    assert found[:20] == pytest.approx(10.0 * keep ** np.arange(1, 21), rel=1e-12)
    rule = stepped(block, [20.0])[0][0]
    assert np.array_equal(getattr(state, "weights", rules), rules), "a reading that is not seen moves no rule"
    assert found[20:] == pytest.approx(rule - (rule - found[19]) * keep ** np.arange(1, 141), abs=1e-9)


@pytest.mark.parametrize("block", [fnn, sofnn(clamp=2.0), sofc(clamp=2.0), sofnn_all_weights(clamp=2.0)])
def test_an_offset_that_the_rules_cannot_say_is_taken_over_and_fades(block):
    p, seen = block.prepare(block.params, T), SeenCut(1.0, 1.0)
    state = fresh(block.align(p, COMMAND, seen, 14.0))
    state, first = block.step(p, state, COMMAND, seen, T)
    state, second = block.step(p, state, COMMAND, seen, T)
    assert first == pytest.approx(14.0, abs=1e-12) and 0.0 < first - second < 0.05 * 15.0


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


# ---- a target that is believed exactly
@pytest.mark.parametrize("block", [sofnn, sofnn_all_weights])
def test_exact_targets_and_rules_that_do_not_walk_are_learned_without_an_error(block):
    sent, state = stepped(block(q=0.0, r=1e-9, passes=2, delay=1), wandering(12))
    assert np.isfinite(sent).all() and np.isfinite(state.covariance).all() and abs(state.weights - W0).max() > 0.1
    with pytest.raises(ValueRefused, match="r = 1e-300"):
        block(r=1e-300)


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
