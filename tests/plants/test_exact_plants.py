"""Exact zero-order-hold plants against SciPy's own discretisation and hand formulas."""

import math

import numpy as np
import pytest
from scipy import signal

from leadscrew.plants._lathe_servo import LatheServoParams, lathe_servo
from leadscrew.plants._linear import state_space, transfer_function
from leadscrew.util.errors import ValueRefused

DT = 0.01


def outputs(block, inputs, dt=DT):
    p, s = block.prepare(block.params, dt), block.state
    s = type(s)(*(x.copy() if isinstance(x, np.ndarray) else x for x in s))
    seen = []
    for u in inputs:
        seen.append(block.output(p, s))
        s = block.step(p, s, u, dt)
    return np.array(seen)


@pytest.mark.parametrize(
    ("num", "den"), [([2.0], [0.5, 1.0]), ([1.0, 3.0], [1.0, 0.4, 9.0, 2.0]), ([5.0], [1.0, 0.0]), ([1.0], [1, 0, 0])]
)
def test_a_transfer_function_gives_scipys_zero_order_hold_response(num, den):
    inputs = np.random.default_rng(0).normal(size=200)
    expected = signal.lsim((num, den), inputs, DT * np.arange(200), interp=False)[1]
    assert outputs(transfer_function(num, den), inputs) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_a_feed_through_shows_the_input_held_up_to_the_sample():
    block = state_space([[-1.0]], [1.0], [0.0], 2.0)
    assert outputs(block, [1.0, -3.0, 0.5]).tolist() == [0.0, 2.0, -6.0]


def test_a_double_integrator_under_constant_force_follows_the_parabola():
    y = outputs(state_space([[0, 1], [0, 0]], [0, 1], [1, 0]), np.ones(300))
    t = DT * np.arange(300)
    assert y == pytest.approx(0.5 * t * t, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: state_space([[0, 1]], [1], [1]), "do not fit"),
        (lambda: state_space([[0.0]], [1, 2], [1]), "do not fit"),
        (lambda: state_space([[math.nan]], [1], [1]), "not finite"),
        (lambda: transfer_function([1, 0, 0], [1, 1]), "degree"),
        (lambda: transfer_function([1], [0]), "zero"),
        (lambda: transfer_function([3], [2]), "no state"),
    ],
)
def test_matrices_and_polynomials_that_make_no_plant_are_refused(make, says):
    with pytest.raises(ValueRefused, match=says):
        make()


def axis_run(duties, dt=1e-3, **changes):
    block = lathe_servo(**changes)
    p, s = block.prepare(block.params, dt), block.state
    shown = []
    for u in duties:
        shown.append(block.output(p, s))
        s = block.step(p, s, u, dt)
    return np.array(shown), s


def test_the_lathe_axis_is_the_chain_of_the_papers_transfer_functions():
    duties = np.random.default_rng(5).uniform(-1, 1, 400)
    den = [0.0008, 1.0]
    for lag in (0.0015, 0.017):
        den = np.polymul(den, [lag, 1.0])
    slide = np.polymul(den, [1.0, 0.0])
    t = 1e-3 * np.arange(400)
    shown, _ = axis_run(duties)
    assert shown[:, 0] == pytest.approx(signal.lsim(([-289.0], slide), duties, t, interp=False)[1], abs=1e-9)
    reader = np.polymul(slide, [0.006, 1.0])
    assert shown[:, 1] == pytest.approx(signal.lsim(([-289.0], reader), duties, t, interp=False)[1], abs=1e-9)


def test_half_the_period_gives_the_same_motion():
    duties = np.random.default_rng(6).uniform(-1, 1, 100)
    coarse, _ = axis_run(duties)
    fine, _ = axis_run(np.repeat(duties, 2), dt=5e-4)
    assert fine[::2] == pytest.approx(coarse, abs=1e-11)


def test_a_positive_duty_moves_the_slide_down_at_the_speed_of_full_duty():
    _, state = axis_run(np.full(2000, 7.0), full_duty_speed_mm_s=300.0)
    assert state.speed == pytest.approx(-300.0) and state.position < 0.0
    lags = sum(LatheServoParams()[1:4])
    assert state.position == pytest.approx(-300.0 * (2.0 - lags), abs=1e-9)


def test_an_idle_axis_decays_to_zero_and_not_to_denormal_numbers():
    block = lathe_servo
    p = block.prepare(block.params, 1e-3)
    s = block.state._replace(pwm=1.0, current=1.0, speed=1.0)
    for _ in range(3000):
        s = block.step(p, s, 0.0, 1e-3)
    assert (s.pwm, s.current, s.speed) == (0.0, 0.0, 0.0) and s.position > 0.0
