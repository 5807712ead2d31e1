"""The lathe study's blocks in a plain loop, against an independent one that sums over all 36 rules."""

import math

import lathe_oracle as oracle
import numpy as np
import pytest
from plain_loop import run_plain

from leadscrew.controllers._vud import duty_pd, power_law, vud, vud_beta_e
from leadscrew.plants._lathe_servo import LathePosition, lathe_servo
from leadscrew.sensors._counts import encoder_count, grating_count
from leadscrew.util.errors import ValueRefused

MILDER = vud_beta_e(output_gain=1.0, output_tau=0.5)
LAWS = {
    "vud": (vud, grating_count),
    "beta_e": (vud_beta_e, grating_count),
    "beta_e_half": (MILDER, grating_count),
    "power": (power_law, encoder_count),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("target", [-170.0, 50.0])
def test_every_law_moves_the_axis_as_the_independent_loop_does(law, target):
    controller, sensor = LAWS[law]
    mine = run_plain(controller, lathe_servo, sensor, target, 2500).signals["actual.position"]
    theirs = oracle.simulate(target, 2500, law, encoder=law == "power")
    assert np.abs(mine - theirs).max() < 1e-9


def test_the_printed_law_creeps_at_6_mm_s():
    x = run_plain(vud, lathe_servo, grating_count, -170.0, 5000).signals["actual.position"]
    assert (x[2000] - x[4000]) / 2.0 == pytest.approx(6.04, abs=0.02)


def test_the_printed_laws_memory_shrinks_a_constant_answer_to_its_tenth_power():
    rho = 1.0
    for _ in range(200):
        rho = 0.677 * (rho**0.9 + 1e-4)
    assert 289.0 * rho == pytest.approx(6.038, abs=1e-3)
    assert rho == pytest.approx(0.677**10, rel=0.05)


def test_the_printed_law_arrives_late_but_within_half_a_count():
    x = run_plain(vud, lathe_servo, grating_count, -50.0, 12000).signals["actual.position"]
    assert oracle.settled(x, -50.0, 0.5) == pytest.approx(8.68, abs=0.01)
    assert abs(x[-1] + 50.0) == pytest.approx(0.28e-3, abs=0.02e-3)


@pytest.mark.parametrize(("target", "band_s", "fine_s"), [(-50.0, 0.755, 0.979), (-170.0, 1.251, 1.560)])
def test_with_beta_of_the_error_the_papers_claims_are_met(target, band_s, fine_s):
    x = run_plain(vud_beta_e, lathe_servo, grating_count, target, 4001).signals["actual.position"]
    assert oracle.settled(x, target, 0.01 * abs(target)) == pytest.approx(band_s, abs=0.001)
    assert oracle.settled(x, target, 0.002) == pytest.approx(fine_s, abs=0.001)
    assert np.abs(x[2000:] - target).max() <= 0.31e-3
    assert 0.016 < target - x.min() < 0.020


def test_the_worked_example_shrinks_its_universes_as_printed():
    state = vud.state._replace(e=-0.25, rho=0.722, started=1.0)
    p = vud.prepare(vud.params, 1e-3)
    before = state.e * 190.0
    now, duty = vud.step(p, state, before + 0.12 * 25.87 * 0.01, 0.0, 1e-3)
    assert now.ec == pytest.approx(0.12, abs=1e-9)
    assert now.alpha_ec == pytest.approx(0.1485, abs=1e-4)
    assert now.alpha_e == pytest.approx(0.2873, abs=2e-3)
    assert duty == pytest.approx(0.505, abs=1e-3)


def test_the_first_period_contracts_nothing_and_knows_no_rate():
    p = vud.prepare(vud.params, 1e-3)
    first, duty = vud.step(p, vud.state, -50.0, 0.0, 1e-3)
    assert (first.alpha_e, first.alpha_ec, first.beta, first.ec) == (1.0, 1.0, 1.0, 0.0)
    assert duty == pytest.approx(0.505 / 0.33 * 50.0 / 190.0)


def test_a_standing_axis_at_its_target_gets_no_duty_from_any_law():
    for block in (vud, vud_beta_e, duty_pd):
        p = block.prepare(block.params, 1e-3)
        assert block.step(p, block.state, 0.0, 0.0, 1e-3)[1] == 0.0
    assert power_law.step(power_law.params, 0.0, 0.0) == 0.0


def test_the_duty_of_the_corrected_laws_never_leaves_its_range():
    x = run_plain(vud_beta_e(output_gain=5.0), lathe_servo, grating_count, -190.0, 300).signals["output"]
    assert np.abs(x).max() == 1.0


def test_the_plain_pd_settles_in_less_than_half_the_time():
    x = run_plain(duty_pd, lathe_servo, grating_count, -170.0, 2500).signals["actual.position"]
    assert oracle.settled(x, -170.0, 0.002) < 0.72
    assert np.abs(x[2000:] + 170.0).max() <= 0.31e-3 and x.min() > -170.0015


def test_the_counters_round_to_their_counts_reading_and_position_apart():
    actual = LathePosition(position=0.0016, reading=0.0009)
    assert grating_count.step(grating_count.params, actual) == pytest.approx(0.000625)
    assert encoder_count.step(encoder_count.params, actual) == pytest.approx(0.002)
    worst = max(
        abs(grating_count.step(grating_count.params, LathePosition(0.0, x)) - x) for x in np.linspace(-0.01, 0.01, 999)
    )
    assert worst <= 0.3126e-3


def test_bad_parameters_are_refused_by_name_and_range():
    with pytest.raises(ValueRefused, match=r"tau = 3.*\[0, 2\]"):
        vud(tau=3.0)
    with pytest.raises(ValueRefused, match=r"full_duty_speed_mm_s = -1.*mm/s"):
        lathe_servo(full_duty_speed_mm_s=-1.0)
    with pytest.raises(ValueRefused, match="increasing"):
        vud.prepare(vud(e_centres=[-1, -0.3, -0.67, 0.3, 0.6, 1]).params, 1e-3)
    with pytest.raises(ValueRefused, match="rules"):
        vud(rules=np.full((6, 6), math.inf))
