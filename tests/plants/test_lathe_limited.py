"""The lathe axis with limits of current and speed against SciPy, the chain without limits, and formulas."""

import numpy as np
import pytest
from lathe_limited_oracle import solve

from leadscrew.actuators._pwm import pwm
from leadscrew.controllers._vud import duty_pd
from leadscrew.kernel.loop import Loop
from leadscrew.plants import _lathe_servo_limited as limited_module
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.plants._lathe_servo_limited import LatheLimitedState, lathe_servo_limited
from leadscrew.references._step import step
from leadscrew.sensors._counts import grating_count
from tests.tools import runnable

NEVER = {"current_limit_a": 1e9, "top_speed_mm_s": 1e9}


def states(duties, dt=1e-3, plant=lathe_servo_limited):
    p, s = plant.prepare(plant.params, dt), plant.state
    rows = [tuple(s)]
    for u in duties:
        s = plant.step(p, s, u, dt)
        rows.append(tuple(s))
    return np.array(rows)


def across():
    """A move to about -50 mm at full duty, braked at full duty, then a full reversal at top speed."""
    return np.concatenate([np.ones(200), -np.ones(13), np.zeros(60), -np.ones(120), np.ones(60)])


@pytest.mark.parametrize(("ampere", "within_um"), [(7.5, 0.1), (4.0, 10.0)])
def test_limits_act_as_scipy_finds_them_act(ampere, within_um):
    """The second row halves the current that the motor needs, so that its limit acts all the way."""
    duties = across()
    ours = states(duties, plant=lathe_servo_limited(current_limit_a=ampere))
    theirs = solve(duties, ampere, 258.7)
    assert abs(theirs[:, 1]).max() == pytest.approx(ampere) and abs(theirs[:, 2]).max() == pytest.approx(258.7)
    assert 1e3 * abs(ours[:, 3:] - theirs[:, 3:]).max() < within_um
    assert abs(ours[:, 1]).max() <= ampere * (1 + 1e-12) and abs(ours[:, 2]).max() <= 258.7


@pytest.mark.slow
def test_twice_the_parts_leave_less_than_half_the_error(monkeypatch):
    duties, theirs = across(), solve(across(), 4.0, 258.7)
    errors = []
    for parts in (4, 8, 16):
        monkeypatch.setattr(limited_module, "SUBSTEPS", parts)
        found = states(duties, plant=lathe_servo_limited(current_limit_a=4.0))
        errors.append(abs(found[:, 3] - theirs[:, 3]).max())
    assert errors[1] < errors[0] / 2.5 and errors[2] < errors[1] / 2.5


def test_far_from_its_limits_it_is_the_chain_without_them():
    duties = np.random.default_rng(8).uniform(-1, 1, 600)
    ours = states(duties, plant=lathe_servo_limited(**NEVER))
    plain = states(duties, plant=lathe_servo)
    assert ours[:, 2:] == pytest.approx(plain[:, 2:], abs=1e-9)
    assert abs(ours[:, 3] - plain[:, 3]).max() < 1e-6


def test_a_gain_sweep_moves_the_chain_and_not_the_limits():
    for full in (259.0, 334.0):
        duties = np.full(400, 0.5)
        ours = states(duties, plant=lathe_servo_limited(full_duty_speed_mm_s=full, **NEVER))
        plain = states(duties, plant=lathe_servo(full_duty_speed_mm_s=full))
        assert ours[:, 3] == pytest.approx(plain[:, 3], abs=1e-9)
        assert states(np.ones(500), plant=lathe_servo_limited(full_duty_speed_mm_s=full))[-1, 2] == -258.7


def test_a_blocked_motor_draws_what_ohms_law_says():
    """Speed held by a top speed of nothing: 30 V over 6.4 ohm, with the armature's time constant L/R."""
    blocked = states(np.ones(100), plant=lathe_servo_limited(top_speed_mm_s=1e-9))
    assert blocked[-1, 1] == pytest.approx(-30.0 / 6.4, rel=1e-6)


def test_at_top_speed_full_duty_draws_what_the_back_emf_leaves():
    fast = states(np.ones(300))[-1]
    assert fast[2] == -258.7
    assert fast[1] == pytest.approx(-(30.0 - 30.0 * 258.7 / 289.0) / 6.4, rel=1e-6)


def test_an_axis_that_brakes_gently_never_meets_the_current_limit():
    quiet = states(np.concatenate([np.ones(300), -0.3 * np.ones(100)]))
    bound = (30.0 * 258.7 / 289.0 + 0.3 * 30.0) / 6.4
    assert 0.8 * bound < quiet[:, 1].max() < bound < 7.5


def test_an_idle_axis_decays_to_zero_and_not_to_denormal_numbers():
    block = lathe_servo_limited
    p = block.prepare(block.params, 1e-3)
    s = LatheLimitedState(1.0, 0.1, 1.0)
    for _ in range(3000):
        s = block.step(p, s, 0.0, 1e-3)
    assert (s.voltage, s.current, s.speed) == (0.0, 0.0, 0.0) and s.position > 0.0


@pytest.mark.sweep
@pytest.mark.parametrize("engine", ["llvm", "c"])
def test_compiled_and_plain_python_give_the_same_bits(engine):
    loop = Loop(
        reference=step(target=-50.0), controller=duty_pd, plant=lathe_servo_limited, sensor=grating_count, actuator=pwm
    )
    plain = loop.run(0.4, record=("actual", "plant", "output"), engine="python")
    fast = loop.run(0.4, record=("actual", "plant", "output"), engine=runnable(engine))
    assert abs(plain["plant.speed"]).max() == 258.7
    assert all(np.array_equal(plain[name], fast[name]) for name in plain.signals)
