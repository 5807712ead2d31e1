"""The linear loop that the stability criteria start from: the one that runs."""

import numpy as np
import pytest

from leadscrew import Loop
from leadscrew.actuators._saturation import saturation
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.loop import continuous_loop, sampled_loop
from leadscrew.controllers._npid import npid
from leadscrew.kernel.block import plant
from leadscrew.plants._linear import transfer_function
from leadscrew.plants._mass_dahl import mass_dahl
from leadscrew.plants._xy_table import XYTableState, xy_table
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.sensors._counts import ruler
from leadscrew.studies.npid_xytable.reference_loops import reference_loops, table_i_sampled
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.xy_loop import PERIOD, xy_loop

W = np.geomspace(1.0, 6000.0, 60)


def drive(period=PERIOD, **more):
    parts = {"reference": sine, "controller": table_pid, "plant": xy_table, "metrics": {}, "period": period, **more}
    return Loop(**parts)


@plant(xy_table.params, xy_table.state, output="position")
def by_derivative(p, s, u):
    return XYTableState(s.velocity, p.gain * u - p.damping * s.velocity - p.stiffness * s.position)


def test_the_loop_without_delay_is_the_pid_times_the_plant_under_a_hold():
    control = pytest.importorskip("control")
    held = control.sample_system(control.tf([69380.0], [1.0, 144.8, 166.3]), PERIOD, method="zoh")
    z = np.exp(1j * W * PERIOD)
    law = 1.32 + 0.000825 * PERIOD * z / (z - 1.0) + 0.006805 * (z - 1.0) / (PERIOD * z)
    assert np.allclose(sampled_loop(drive()).response(W), law * held(z), rtol=1e-9)


def test_a_delay_of_whole_periods_turns_the_phase_and_nothing_else():
    late = sampled_loop(drive(computation_delay=3 * PERIOD))
    assert np.allclose(late.response(W), sampled_loop(drive()).response(W) * np.exp(-3j * W * PERIOD), rtol=1e-9)


def test_the_compiled_loop_has_the_error_that_the_linear_loop_foretells():
    """Closed by hand: x+ = a x + b e, e = command - y, on a step of 10 um, with a delay of 1.55 periods."""
    loop = xy_loop(table_pid, step(target=0.01, time=0.0))
    linear = sampled_loop(loop)
    x, foretold = np.zeros((len(linear.a), 1)), []
    for _ in range(120):
        e = 0.01 - float((linear.c @ x)[0, 0])
        foretold.append(e)
        x = linear.a @ x + linear.b * e
    seen = loop.run(120 * PERIOD, record="error", engine="python")["error"]
    assert np.allclose(seen, foretold, rtol=0.0, atol=1e-14)
    assert max(foretold) - min(foretold) > 0.01


def test_a_delay_of_the_sensor_is_one_of_the_output():
    a = sampled_loop(drive(substeps=20, computation_delay=0.775e-3))
    b = sampled_loop(drive(substeps=20, computation_delay=0.3e-3, transport_delay=0.475e-3))
    assert np.allclose(a.response(W), b.response(W), rtol=1e-10)
    assert np.allclose(a.response(W), table_i_sampled(0.775e-3).response(W), rtol=1e-10)


def test_a_plant_that_gives_a_derivative_is_held_exactly():
    continuous = sampled_loop(drive(plant=by_derivative))
    assert np.allclose(continuous.response(W), sampled_loop(drive()).response(W), rtol=1e-8)


def test_a_plant_of_matrices_gives_the_same_loop_as_one_of_equations():
    matrices = sampled_loop(drive(plant=transfer_function([69380.0], [1.0, 144.8, 166.3])))
    assert np.allclose(matrices.response(W), sampled_loop(drive()).response(W), rtol=1e-8)


def test_weights_of_the_command_do_not_change_the_stability():
    soft = sampled_loop(drive(controller=table_pid(b=0.0, c=0.0)))
    assert np.allclose(soft.response(W), sampled_loop(drive()).response(W), rtol=1e-12)


def test_limits_and_counts_are_left_out_and_named():
    loop = sampled_loop(drive(actuator=saturation, sensor=ruler, controller=table_pid(lower=-10.0, upper=10.0)))
    assert np.allclose(loop.response(W), sampled_loop(drive()).response(W), rtol=1e-9)
    said = " ".join(loop.notes)
    assert "actuator saturation" in said and "sensor ruler" in said and "limit of its output" in said


def test_a_filtered_derivative_is_a_state():
    """Backward Euler: Kd (z - 1) / ((Tf + T) z - Tf)."""
    control = pytest.importorskip("control")
    held = control.sample_system(control.tf([69380.0], [1.0, 144.8, 166.3]), PERIOD, method="zoh")
    z = np.exp(1j * W * PERIOD)
    law = 1.32 + 0.000825 * PERIOD * z / (z - 1.0) + 0.006805 * (z - 1.0) / ((1e-3 + PERIOD) * z - 1e-3)
    assert np.allclose(sampled_loop(drive(controller=table_pid(filter_s=1e-3))).response(W), law * held(z), rtol=1e-9)


def test_a_nonlinear_controller_is_sent_to_lure():
    with pytest.raises(ValueRefused, match=r"npid: this controller is not linear .* lure\(\)"):
        sampled_loop(drive(controller=npid))


def test_a_plant_with_friction_is_refused_by_name():
    with pytest.raises(ValueRefused, match="mass_dahl: this plant is not linear"):
        sampled_loop(drive(plant=mass_dahl))


def test_rightmost_poles_under_a_dead_time_are_those_of_lambert():
    """The poles of x' = -k x(t - 1) are W_n(-k)."""
    from scipy.special import lambertw

    loop = continuous_loop([1.0], [1.0], [1.0], [1.0, 0.0], dead_time=1.0)
    known = np.array([lambertw(-2.0, n) for n in (0, -1, 1, -2)])
    found = loop.closed_poles(2.0)
    assert all(np.min(np.abs(found - s)) < 1e-10 for s in known)
    assert loop.gain_limit() == pytest.approx(np.pi / 2, rel=1e-12)
    assert loop.stable(1.57) and not loop.stable(1.5709)


def test_closed_poles_of_the_delayed_axis_solve_its_characteristic_equation():
    loop = reference_loops()["Lc"]
    for s in loop.closed_poles(2.0)[:6]:
        law = 1.32 + 0.000825 / s + 0.006805 * s
        assert abs(1.0 + 2.0 * law * 69380.0 / (s * s + 144.8 * s + 166.3) * np.exp(-s * 1.2888e-3)) < 1e-7


@pytest.mark.parametrize("name", ["Lc", "L_star", "L0", "L_500us", "Lc_filter_500us"])
def test_the_closed_loop_turns_unstable_at_the_gain_limit(name):
    loop = reference_loops()[name]
    k = loop.gain_limit()
    assert loop.stable(0.9999 * k) and not loop.stable(1.0001 * k)


def test_an_unstable_plant_has_its_limit_above_the_gain_that_stabilises_it():
    """G = 1/(s - 1) with a lag: stable for 1 < k < 1 + 10 (Routh: k > 1 and 1/0.1 > 1)."""
    loop = continuous_loop([1.0], [0.1, 1.0], [1.0], [1.0, -1.0])
    assert loop.gain_limit() == 0.0
    assert loop.gain_limit(1.5) == np.inf
    triple = continuous_loop([1.0], [0.1, 1.0], [1.0], np.polymul([1.0, -1.0], [0.1, 1.0]))
    # 0.01 s^3 + 0.19 s^2 + 0.8 s + k - 1: Routh asks for 1 < k < 1 + 0.19 * 0.8 / 0.01
    assert triple.gain_limit(1.5) == pytest.approx(16.2, rel=1e-9)


def test_strong_integral_action_is_unstable_at_small_gains_and_has_its_limit_above_one():
    """(s + 10)^2 / s^3: s^3 + k (s + 10)^2 is stable for k > 5 by Routh; with a dead time there is a limit above."""
    loop = continuous_loop([8.0, 160.0, 800.0], [1.0], [1.0], [1.0, 0.0, 0.0, 0.0], dead_time=5e-3)
    assert loop.gain_limit(0.0) == 0.0
    k = loop.gain_limit()
    assert k > 1.0 and loop.stable(0.999 * k) and not loop.stable(1.001 * k)


def test_a_negative_lower_bound_counts_the_gains_below_zero():
    """G = 1/(s^2 + s + 1) is unstable for gains below -1 and stable for all above."""
    loop = continuous_loop([1.0], [1.0], [1.0], [1.0, 1.0, 1.0])
    assert loop.gain_limit(-0.9) == np.inf
    assert loop.gain_limit(-1.1) == -1.1


def test_matrices_that_do_not_fit_are_refused():
    with pytest.raises(ValueRefused, match="do not fit"):
        LinearLoop(np.eye(2), np.ones((1, 1)), np.ones((1, 2)), np.zeros((1, 1)))
    with pytest.raises(ValueRefused, match="degree 2 exceeds"):
        continuous_loop([1.0, 0.0, 0.0], [1.0], [1.0], [1.0, 1.0])


def test_python_control_gets_the_same_loop():
    control = pytest.importorskip("control")
    loop = reference_loops()["L_star"]
    assert np.allclose(loop.to_control()(np.exp(1j * W * PERIOD)), loop.response(W), rtol=1e-8)
    assert isinstance(loop.to_control(), control.StateSpace)
