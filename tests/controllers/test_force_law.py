"""Adaptive inversion and the learned cutting law: hand-worked numbers, a plain NumPy filter, and cuts."""

import math

import numpy as np
import pytest

from leadscrew.controllers._force import constant_force, power_law_inversion
from leadscrew.controllers._force.cutting_law import MOST, Belief, feed_for, learned, prior
from leadscrew.controllers._force.revolution import ROOM, nothing_yet, one_ago, recorded, speed
from leadscrew.kernel.layout import copied
from leadscrew.references._cutting_program import NEVER_S, CutCommand
from leadscrew.sensors._load_cell import CutReading
from leadscrew.studies.grey_turning.tunings import FORCE as TUNINGS
from leadscrew.util.errors import ValueRefused
from tests.controllers.force_loop import cut

DT = 0.02
STEADY = {"depth.step": 0.0}


def history(rpm, feed, force, samples):
    """Readings of a steady feed in mm/min."""
    s = nothing_yet()
    for k in range(samples):
        t = k * DT
        s = recorded(s, feed * t / 60.0, rpm * t / 60.0, force * t)
    return s


def test_one_revolution_ago_is_found_between_samples():
    s = history(1200.0, 36.0, 100.0, 8)  # 0.4 revolutions a sample: one revolution is 2.5 samples
    found = one_ago(s)
    assert found.travel == pytest.approx(36.0 * (0.14 - 0.05) / 60.0)
    assert found.force == pytest.approx(100.0 * 0.09)
    assert found.whole == 1.0
    assert speed(s, s.last + 0.4, 500.0, DT) == pytest.approx(1200.0)


def test_the_ring_of_readings_turns_over():
    found = one_ago(history(300.0, 36.0, 100.0, 5 * ROOM + 7))
    last = (5 * ROOM + 6) * DT
    assert found.travel == pytest.approx(36.0 * (last - 0.2) / 60.0)


def test_the_first_revolution_cuts_uncut_work():
    found = one_ago(history(1200.0, 36.0, 100.0, 2))
    assert found == (0.0, 0.0, 1.0)


def test_nothing_is_concluded_from_a_spindle_too_slow_or_a_start_in_the_cut():
    assert one_ago(history(60.0, 36.0, 100.0, 3 * ROOM)).whole == 0.0
    s = nothing_yet(uncut=0.0)
    s = recorded(s, 5.0, 100.0, 150.0)
    assert one_ago(s).whole == 0.0


def plain_inversion(readings, p, target):
    """The update, written anew on lists, with NumPy's interpolation."""
    x, turns, y = (np.array([r[i] for r in readings]) for i in (0, 1, 2))
    k_hat, variance, feed, u, out = p.first_k, 1.0, 0.0, 0.0, []
    for k in range(len(x)):
        place = turns[k] - 1.0
        x1, y1 = (np.interp(place, turns[: k + 1], v[: k + 1]) if place >= 0.0 else 0.0 for v in (x, y))
        feed = 0.8 * feed + 0.2 * (x[k] - x1)
        power = max(feed - (y[k] - y1) / p.stiffness, 1e-9) ** p.exponent
        if power > 0.002 and y[k] > 5.0:
            variance += 2e-4
            nu = (y[k] - k_hat * power) / (k_hat * power)
            variance += 0.05 if abs(nu) > 0.06 else 0.0
            g = variance / (variance + (1.2 / (power * p.first_k)) ** 2)
            k_hat, variance = k_hat * (1.0 + g * nu), (1.0 - g) * variance
        u = min(max(u + 0.3 * (1200.0 * (target / k_hat) ** (1.0 / p.exponent) / 150.0 - u), 0.0), 1.0)
        out.append(u)
    return np.array(out)


def test_the_inversion_is_the_update_written_anew():
    run = cut(TUNINGS["ours.inversion"]).run(4.0, record=["feedback", "output"])
    readings = list(zip(run["feedback.travel"], run["feedback.turns"], run["feedback.force"], strict=True))
    assert np.allclose(run["output"], plain_inversion(readings, power_law_inversion.params, 150.0), atol=1e-10)


def test_one_reading_moves_the_law_as_a_kalman_filter_does():
    b = Belief()
    x = math.log(0.02 / b.chip_mm)
    covariance = np.diag([b.spread**2 + b.drift, b.exponent_spread**2])
    expected = 0.8 * 150.0 * math.exp(0.8 * x)
    h = np.array([1.0, x])
    scatter = (b.noise_n / expected) ** 2 + b.floor**2
    gain = covariance @ h / (h @ covariance @ h + scatter)
    wanted = np.array([math.log(150.0), 0.8]) + gain * math.log(100.0 / expected)
    left = covariance - np.outer(gain, h @ covariance)
    found = learned(b, prior(b), 0.8, 0.02, 100.0, 100.0, 90.0)
    assert np.allclose(found[:2], wanted, rtol=1e-12)
    assert np.allclose(found[2:], [left[0, 0], left[0, 1], left[1, 1]], rtol=1e-12)


def test_compliance_takes_its_share_of_the_feed():
    b = Belief(slack=0.0)
    stiff = learned(b, prior(b), 1.0, 0.02, 90.0, 90.0, 90.0)
    yielding = learned(b, prior(b), 1.0, 0.02 + 60.0 / 20000.0, 90.0, 30.0, 90.0)
    assert yielding == pytest.approx(stiff)


def test_air_and_dust_teach_nothing():
    b = Belief()
    assert learned(b, prior(b), 1.0, 0.02, 4.0, 4.0, 4.0) == prior(b)
    assert learned(b, prior(b), 1.0, 0.0005, 50.0, 50.0, 50.0) == prior(b)


def test_a_load_cell_stuck_at_a_low_force_cannot_ask_for_any_feed():
    b = Belief()
    s = prior(b)
    for _ in range(500):
        s = learned(b, s, 1.0, 0.05, 6.0, 6.0, 6.0)
    assert s.level == pytest.approx(math.log(b.force_per_mm) - MOST)


def test_the_feed_wanted_gives_the_force_and_is_held_back_while_little_is_known():
    b = Belief(spread=0.0, exponent_spread=0.0)
    assert feed_for(b, prior(b), 150.0, 1.0, 0.5, 0.1) == pytest.approx(b.chip_mm)
    assert feed_for(b, prior(b), 75.0, 0.25, 0.5, 0.1) == pytest.approx(b.chip_mm * 2.0 ** (1.0 / 0.8))
    doubtful = b._replace(spread=0.4)
    assert feed_for(doubtful, prior(doubtful), 150.0, 1.0, 0.5, 0.1) == pytest.approx(b.chip_mm * math.exp(-0.15 / 0.8))


def test_a_chip_thicker_than_any_that_was_cut_is_approached_by_a_part_of_the_way():
    b = Belief(spread=0.0, exponent_spread=0.1)
    right = b.chip_mm * 2.0 ** (1.0 / 0.8)  # half the force per depth of the belief, known to 1 in 10 of P
    soft = prior(b)._replace(level=math.log(75.0))
    assert feed_for(b, soft, 150.0, 1.0, 0.0, 0.1, b.chip_mm, 0.0) == pytest.approx(right)
    half_way = feed_for(b, soft, 150.0, 1.0, 0.0, 0.1, b.chip_mm, 8.0)  # 1 / (1 + 8 0.1 / 0.8) of it in logarithms
    assert half_way == pytest.approx(math.sqrt(b.chip_mm * right))
    assert feed_for(b, soft, 150.0, 1.0, 0.0, 0.1, 1.1 * right, 8.0) == pytest.approx(right)
    hard = prior(b)._replace(level=math.log(300.0))
    assert feed_for(b, hard, 150.0, 1.0, 0.0, 0.1, b.chip_mm, 8.0) == pytest.approx(b.chip_mm**2 / right)


@pytest.mark.parametrize("block", [power_law_inversion, constant_force])
def test_limits_the_wrong_way_round_are_refused(block):
    with pytest.raises(ValueRefused, match="must be below"):
        block.prepare(block(lower=1.0, upper=0.5).params, DT)


@pytest.mark.parametrize("name", ["ours.inversion", "ours.constant_force"])
def test_a_spindle_that_stands_gets_no_feed(name):
    block = TUNINGS[name]
    p, state = block.prepare(block.params, DT), copied(block.initial(block.params) if block.initial else block.state)
    for _ in range(60):
        state, u = block.step(p, state, CutCommand(150.0, 1.0, 1.0, NEVER_S), CutReading(0.0, 0.0, 0.0, 3.0), DT)
    assert abs(u) < 1e-6


def entry(block, **changes):
    """True force after the entry at a steady depth without noise, relative to the command."""
    loop = cut(block, radial=0.0, noise_n=0.0, runout=0.0, **(STEADY | {"depth.steps": 0}))
    loop = loop.using({"reference.depth.steps": 0} | changes)
    return loop.run(3.0, record=["actual"])["actual.force"] / 150.0


@pytest.mark.slow
@pytest.mark.parametrize("hardness", [0.6, 1.0, 1.6])
def test_any_material_is_cut_at_the_force_without_overshoot(hardness):
    force = entry(TUNINGS["ours.constant_force"], **{"plant.law.kf": hardness * 2256.3})
    assert abs(force[-1] - 1.0) < 1e-3
    assert force.max() < (1.04 if hardness <= 1.0 else 1.15)


@pytest.mark.slow
def test_iron_is_entered_without_a_peak_and_in_a_quarter_of_a_second():
    """Iron needs three times the feed of the belief, and its exponent is 0.96; without the care it peaks at 14 %."""
    iron = {"plant.law.kf": 1450.0, "plant.law.exponent": 0.96}
    careful = entry(TUNINGS["ours.constant_force"], **iron)
    assert careful.max() < 1.06 and careful[13] > 0.9
    assert entry(TUNINGS["ours.constant_force"](exponent_caution=0.0), **iron).max() > 1.10


def test_without_compliance_the_inversion_overshoots():
    assert entry(TUNINGS["ours.inversion"]).max() < 1.04
    assert entry(TUNINGS["ours.inversion"](stiffness=1e9)).max() > 1.10
