"""The cascade of an identified axis."""

import math

import numpy as np
import pytest

from leadscrew import Loop
from leadscrew.controllers._axis_cascade import AxisCascadeState, align
from leadscrew.plants._servo_axis import servo_axis
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.references._motion import Motion
from leadscrew.references._s_curve import s_curve
from leadscrew.sensors._counts import axis_reading
from leadscrew.studies.npid_xytable.tunings import table_pid
from tests.controllers.emps_cascade import emps_cascade

DT = 1e-3


def outputs(block, commands, feedbacks, state=None):
    s, found = state or block.state, []
    for command, feedback in zip(commands, feedbacks, strict=True):
        s, u = block.step(block.params, s, command, feedback, DT)
        found.append(u)
    return np.array(found)


def test_with_all_of_the_commanded_speed_it_is_a_pid():
    """Kd = kvp, Kp = kvp kpos + kvi, Ki = kvi kpos, from the second period on: the PID kicks in the first."""
    rng = np.random.default_rng(1)
    r, y = np.cumsum(rng.normal(size=(2, 200)), axis=1)
    r[0] = y[0] = 0.0
    cascade = emps_cascade(kpos=150.0, kvp=0.2, kvi=3.0, velocity_share=1.0, lower=-math.inf, upper=math.inf)
    same = table_pid(kp=0.2 * 150.0 + 3.0, ki=3.0 * 150.0, kd=0.2)
    ours = outputs(cascade, [Motion(x, 0.0, 0.0) for x in r], y)
    assert ours == pytest.approx(outputs(same, r, y), rel=1e-9, abs=1e-9)


@pytest.mark.slow
def test_on_a_ramp_it_lags_by_speed_over_position_gain():
    loop = Loop(
        reference=s_curve(distance=100.0, max_velocity=50.0, max_acceleration=500.0, max_jerk=1e4),
        controller=emps_cascade, plant=servo_axis, sensor=axis_reading(resolution=0.0), period=DT, metrics={},
    )  # fmt: skip
    run = loop.run(1.5)
    p = emps_cascade.params
    at = int(1.0 / DT)
    friction = (p.model.coulomb_forward + p.model.offset + p.model.viscous * 50.0) / p.kvp
    assert run["true_error"][at] == pytest.approx((50.0 + friction) / p.kpos, rel=0.01)


def test_with_the_model_of_the_axis_hardly_anything_is_left_to_the_feedback():
    given = {"sensor": axis_reading(resolution=0.0), "period": DT, "metrics": {}, "plant": servo_axis}
    smooth = eased_sine_motion(amplitude=20.0, frequency=0.5)
    without = Loop(reference=smooth, controller=emps_cascade(velocity_share=1.0), **given).run(4.0)["true_error"]
    modelled = emps_cascade(velocity_share=1.0, model_share=1.0)
    with_model = Loop(reference=smooth, controller=modelled, **given).run(4.0)["true_error"]
    assert np.max(np.abs(with_model)) < 0.15 * np.max(np.abs(without))


def test_it_takes_over_without_a_bump():
    params = emps_cascade.using(kvi=3.0, model_share=1.0).params
    command, feedback = Motion(5.0, 40.0, 100.0), 4.7
    state = align(params, command, feedback, 1.25)
    assert emps_cascade.step(params, state, command, feedback, DT)[1] == pytest.approx(1.25, rel=1e-12)


def test_at_its_limit_the_integral_waits():
    block = emps_cascade(kvi=3.0, lower=-1.0, upper=1.0)
    s = AxisCascadeState()
    for _ in range(100):
        s, u = block.step(block.params, s, Motion(50.0, 0.0, 0.0), 0.0, DT)
        assert u == 1.0
    assert s.integral == 0.0
