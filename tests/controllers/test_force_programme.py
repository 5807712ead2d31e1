"""Depth feed-forward and gain normalisation: hand-worked numbers, SciPy, and the cut of a staircase."""

import numpy as np
import pytest

from leadscrew.controllers._force import depth_feed_forward, gain_normalised
from leadscrew.controllers._force.programme import Depth, aimed, cutting, followed, follower, programmed
from leadscrew.controllers._grey_fuzzy.pi_incremental import PiIncrementalState, pi_incremental
from leadscrew.plants._turning.process import RadialServo
from leadscrew.references._cutting_program import NEVER_S, CutCommand
from leadscrew.sensors._load_cell import CutReading
from leadscrew.studies.grey_turning.tunings import FORCE as TUNINGS
from leadscrew.studies.grey_turning.tunings import TUNINGS as GREY_FUZZY
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import BlockError
from tests.controllers.force_loop import RADIAL, cut

DT = 0.02
PI = pi_incremental(kp=0.001, ki=0.0002, upper=10.0)


def told(depth, next_depth, change_in_s):
    return CutCommand(150.0, depth, next_depth, change_in_s)


def test_a_change_within_a_period_counts_by_its_share():
    command = told(1.0, 0.6, 0.075)
    assert programmed(command, 0.04, DT) == 1.0
    assert programmed(command, 0.06, DT) == pytest.approx(1.0 - 0.25 * 0.4)  # 5 of the 20 ms come after it
    assert programmed(command, 0.08, DT) == pytest.approx(0.6)
    assert programmed(told(0.8, 0.8, NEVER_S), 0.06, DT) == 0.8


def test_the_feed_is_set_for_the_cut_ahead_and_in_the_air_for_the_next_one_or_the_last():
    def aim(depth, next_depth, change_in_s, last=0.0, error=0.0):
        return aimed(told(depth, next_depth, change_in_s), 0.04, DT, error, 0.2, 0.02, last)

    assert aim(1.0, 0.6, 0.04) == pytest.approx(0.6)
    assert aim(1.0, 0.6, 0.2) == 1.0
    assert aim(1.0, 0.0, 0.04) == 1.0  # the tool is about to leave: still the depth that is cut
    assert aim(1.0, 0.1, 0.04) == 1.0  # shallower than min_depth: not ahead of time
    assert aim(0.0, 0.6, 5.0, last=1.0) == 0.6  # in the air: the cut that comes
    assert aim(0.0, 0.0, NEVER_S, last=0.8) == 0.8  # none comes: the last one
    assert aim(0.0, 0.0, NEVER_S) == 0.0  # never cut
    assert aim(0.0, 0.0, NEVER_S, last=0.8, error=0.05) == 0.0  # believed to be 0.05 mm in the cut


AIR = {"depth.start": 0.0, "depth.step": 1.0, "depth.every_s": 1.0, "depth.steps": 1}
LEAVES = {"depth.start": 1.0, "depth.step": -1.0, "depth.every_s": 1.0, "depth.steps": 1}
KNOWING = ("ours.tfc_ff", "ours.constant_force")


def outing(name, stairs, radial, seconds=2.2):
    """Feed voltage and largest true force; the controller knows the radial servo."""
    block = TUNINGS[name](**{"radial.gain": radial})
    run = cut(block, radial=radial, noise_n=0.0, stairs=stairs, runout=0.0).run(
        seconds, record=["output", "plant.peak"]
    )
    return run["output"], run["plant.peak"][-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWING)
def test_told_air_the_feed_stays_an_air_feed(name):
    output, _ = outing(name, {"depth.start": 0.0, "depth.step": 0.0, "depth.every_s": 1.0, "depth.steps": 0}, 0.0, 1.0)
    assert output.max() == pytest.approx(0.1)


@pytest.mark.parametrize("radial", [0.0, RADIAL])
@pytest.mark.parametrize("name", KNOWING)
def test_a_cut_after_air_is_entered_at_the_force(name, radial):
    output, peak = outing(name, AIR, radial)
    assert output[:50].max() < 0.25 and peak < 153.0  # the TFC alone: full feed and more than 300 N
    assert output[-1] == pytest.approx(0.237, rel=0.03)


@pytest.mark.parametrize("radial", [0.0, RADIAL])
@pytest.mark.parametrize("name", KNOWING)
def test_the_feed_does_not_open_before_the_tool_has_left(name, radial):
    output, peak = outing(name, LEAVES, radial)
    assert peak < 156.0  # what the entry makes
    assert output[45:].max() < 0.245  # the last feed, also in the air behind


@pytest.mark.parametrize("name", KNOWING)
def test_a_tool_that_enters_slowly_does_not_meet_a_feed_that_has_run_up(name):
    ramp = {"depth.start": 1.0, "depth.entry_s": 0.4, "depth.step": 0.0, "depth.every_s": 1.0, "depth.steps": 0}
    _, peak = outing(name, ramp, 0.0)
    assert peak < 156.0  # the TFC alone: 210 N


def test_the_believed_depth_follows_its_programme_as_the_servo_does():
    from scipy.signal import StateSpace, lsim

    gain, lag = RADIAL, 0.017
    f = follower(RadialServo(gain, lag), DT)
    at, depth = Depth(1.0, 0.0), []
    for _ in range(60):
        at = followed(f, at, 0.8)
        depth.append(at.depth)
    system = StateSpace([[0, 1], [-gain / lag, -1 / lag]], [[0], [gain / lag]], [[1, 0]], [[0]])
    t = np.linspace(0.0, 60 * DT, 60 * 200 + 1)
    expected = lsim(system, np.full(len(t), 0.8), t, X0=[1.0, 0.0])[1]
    assert np.allclose(depth, expected[200::200], atol=1e-9)


def test_without_a_radial_servo_the_believed_depth_is_the_programme():
    assert followed(follower(RadialServo(), DT), Depth(1.0, 0.0), 0.7) == Depth(0.7, 0.0)


def test_a_depth_that_is_wrong_or_nothing_stays_a_depth():
    assert cutting(1.0, 0.05, 0.1) == 1.05
    assert cutting(0.0, 0.0, 0.1) == 0.1


def test_the_output_goes_with_the_depth_ahead_by_the_power_law():
    block = depth_feed_forward(PI, exponent=0.5, preview_s=0.02)
    p = block.prepare(block.params, DT)
    state = block.state._replace(inner=PiIncrementalState(0.0, 0.3, 1.0))
    reading = CutReading(150.0, 150.0, 0.0, 0.0)
    state, before = block.step(p, state, told(1.0, 0.8, 0.04), reading, DT)
    state, waiting = block.step(p, state, told(1.0, 0.8, 0.02), reading, DT)
    state, after = block.step(p, state, told(0.8, 0.8, NEVER_S), reading, DT)
    assert (before, waiting) == (0.3, 0.3)
    assert after == pytest.approx(0.3 * (1.0 / 0.8) ** 2)  # no error: nothing else moves it


def test_increments_grow_with_the_feed():
    block = gain_normalised(PI, nominal_v=0.2, floor=0.3)
    p = block.prepare(block.params, DT)
    for output, factor in ((0.0, 0.3), (0.2, 1.3), (0.6, 3.3)):
        _, found = block.step(p, PiIncrementalState(10.0, output, 1.0), 150.0, 135.0, DT)  # e 15, change 5
        assert found == pytest.approx(output + factor * (0.001 * 5.0 + 0.0002 * 15.0))


def test_both_keep_to_the_limits_of_the_inner_controller():
    block = gain_normalised(pi_incremental, nominal_v=0.2)
    p = block.prepare(block.params, DT)
    _, found = block.step(p, PiIncrementalState(0.0, 0.99, 1.0), 1e6, 0.0, DT)
    assert found == 1.0
    block = depth_feed_forward(pi_incremental, preview_s=0.02)
    p = block.prepare(block.params, DT)
    state = block.state._replace(inner=PiIncrementalState(0.0, 0.9, 1.0))
    state, _ = block.step(p, state, told(1.0, 0.2, 0.02), CutReading(150.0, 150.0, 0.0, 0.0), DT)
    assert block.step(p, state, told(0.2, 0.2, NEVER_S), CutReading(150.0, 150.0, 0.0, 0.0), DT)[1] == 1.0


@pytest.mark.parametrize("wrapper", [depth_feed_forward, gain_normalised])
def test_what_has_no_output_to_add_to_is_refused(wrapper):
    with pytest.raises(BlockError, match="adds to its output"):
        wrapper(table_pid)
    with pytest.raises(BlockError, match="positional"):
        wrapper(GREY_FUZZY["ours.depth_tfc"])


def dips(block, **more):
    force = cut(block, noise_n=0.0, runout=0.0, **more).run(4.5, record=["actual"])["actual.force"]
    late = force[60:] / 150.0 - 1.0
    return 100.0 * late.min(), 100.0 * late.max()


@pytest.mark.slow
def test_a_staircase_hardly_shows_in_the_force():
    ahead = TUNINGS["ours.tfc_ff"](**{"radial.gain": RADIAL})
    plain, previewed, late = (
        dips(GREY_FUZZY["corrected.tfc_stfc"]), dips(ahead), dips(ahead(preview_s=0.0))
    )  # fmt: skip
    assert plain[0] < -15.0
    assert previewed[0] > -3.0 and previewed[1] < 3.0
    assert late[0] < -6.0  # the same without preview


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ours.tfc_ff", "ours.gain_normalised", "ours.inversion", "ours.constant_force"])
def test_taking_over_in_the_cut_is_bumpless(name):
    live = cut(TUNINGS["ours.tfc_ff"]).start() if name != "ours.gain_normalised" else cut(TUNINGS[name]).start()
    live.advance(60)
    moment = live.save()
    stays = live.advance(1)["output"][0]  # what the old controller would say at the same reading
    live.restore(moment)
    live = live.switch(TUNINGS[name])
    assert live.bumpless
    after = live.advance(100)
    assert after["output"][0] == pytest.approx(stays, rel=1e-9)
    reading = after["feedback"] if name == "ours.gain_normalised" else after["feedback.force"]
    assert np.abs(reading[:14] / 150.0 - 1.0).max() < 0.05  # before the first change of depth
