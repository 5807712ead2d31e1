"""The lathe's PID in duty against its difference equation by SciPy, and what its integral does to the axis."""

import numpy as np
import pytest
from scipy import signal

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.actuators._offset import offset
from leadscrew.controllers._vud.duty_pd import duty_pd
from leadscrew.controllers._vud.duty_pid import duty_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.lathe_loop import lathe_loop

PERIOD = 1e-3
SMALL = 0.01 * np.random.default_rng(5).normal(size=300)
"""Errors that never bring the duty to its limit."""


def duties(block, errors):
    s, seen = block.state, []
    for error in errors:
        s, rho = block.step(block.params, s, float(error), 0.0, PERIOD)
        seen.append(rho)
    return np.array(seen)


def test_the_difference_equation_is_the_one_of_the_z_transform_with_the_lathes_sign():
    block = duty_pid(kp=0.3, ki=2.0, kd=0.001, filter_s=0.002)
    slope = signal.lfilter([0.001, -0.001], [0.002 + PERIOD, -0.002], SMALL, zi=[-SMALL[0] / 3.0])[0]
    expected = 0.3 * SMALL + 2.0 * signal.lfilter([PERIOD], [1.0, -1.0], SMALL) + slope
    assert duties(block, SMALL) == pytest.approx(-expected, rel=1e-11, abs=1e-13)


def test_a_step_of_the_command_gives_no_derivative_kick_in_the_first_period():
    assert duties(duty_pid(ki=0.0, kp=0.01), [1.0])[0] == pytest.approx(-0.01)


def test_the_duty_stays_inside_its_limit_and_the_integral_does_not_wind_up_there():
    block = duty_pid(kd=0.0, anti_windup=1)
    seen = duties(block, [50.0] * 500 + [-0.01] * 3)
    assert (seen[:500] == -1.0).all()
    assert seen[500] > 0.0
    assert duties(block(anti_windup=0), [50.0] * 500 + [-0.01])[-1] == -1.0


def test_without_integral_it_settles_like_the_plain_pd():
    same = duty_pid(kp=duty_pd.params.kp, ki=0.0, kd=duty_pd.params.kp * duty_pd.params.t_d, filter_s=0.00055)
    mine, theirs = (lathe_loop(block).run(1.0, every=0).metrics["settling_2um"] for block in (same, duty_pd))
    assert mine == pytest.approx(theirs, abs=0.01)


@pytest.mark.parametrize(("target", "seconds"), [(-50.0, 0.30), (-170.0, 0.72)])
def test_the_axis_settles_within_2_um_and_stays_within_a_count(target, seconds):
    metrics = lathe_loop(duty_pid, target).run(4.0, every=0).metrics
    assert metrics["settling_2um"] < seconds
    assert metrics["error_after_2s"] < 0.625e-3


def test_the_integral_takes_away_what_a_drift_leaves_of_the_error():
    """A duty of 0.01 added to the controller's: a PD stands 0.01 / kp off, 40 um."""
    drifting = offset(bias=0.01)
    left = [lathe_loop(b, actuator=drifting).run(4.0, every=0).metrics["error_after_2s"] for b in (duty_pd, duty_pid)]
    assert left[0] == pytest.approx(0.01 / duty_pd.params.kp, abs=0.4e-3)
    assert left[1] < 0.625e-3


def test_clamping_overshoots_where_back_calculation_does_not():
    clamped, brought_back = (
        lathe_loop(duty_pid(anti_windup=kind)).run(2.0, every=0).metrics["overshoot"] for kind in (1, 2)
    )
    assert brought_back < 1.5e-3 and clamped > 1.0


def test_in_a_dead_zone_the_integral_hunts():
    run = lathe_loop(duty_pid, actuator=dead_zone(threshold=0.01)).run(4.0)
    late = run["actual.position"][2000:] + 50.0
    assert late.max() > 1e-3 and late.min() < -1e-3


def test_a_bumpless_start_gives_the_last_output_again():
    state = duty_pid.align(duty_pid.params, -50.0, -49.9, -0.2)
    after, rho = duty_pid.step(duty_pid.params, state, -50.0, -49.9, PERIOD)
    assert rho == pytest.approx(-0.2, abs=1e-12) and after.started == 1.0


def test_a_bad_gain_is_refused_by_name():
    with pytest.raises(ValueRefused, match="kp = -1"):
        duty_pid(kp=-1.0)
