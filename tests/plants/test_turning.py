"""The cut in turning: chip, surface and force against other ways of working them out."""

import math

import numpy as np
import pytest

from leadscrew import Loop, controller
from leadscrew.disturbances._step_load import step_load
from leadscrew.plants._turning import turning
from leadscrew.plants._turning.chip import CELLS, IRON, S45C, blank, cut, leave_surface, surface_before
from leadscrew.plants._turning.process import hold
from leadscrew.references._cutting_program import cutting_force, depth_at
from leadscrew.sensors._load_cell import load_cell
from leadscrew.util.errors import ValueRefused

STEADY_V = 35.5 / 150.0
"""Feed of 35.5 mm/min: 150 N on S45C at 1 mm and 1,200 1/min."""


@controller()
def held(command, feedback):
    return STEADY_V + 0.0 * command


def loop(changes=None, **more):
    made = Loop(
        reference=cutting_force, controller=held, plant=turning(runout=0.0), sensor=load_cell(noise_n=0.0),
        period=0.02, substeps=20, metrics={}, **more,
    )  # fmt: skip
    return made.using(changes) if changes else made


@pytest.mark.parametrize("law", [S45C, IRON])
@pytest.mark.parametrize("depth", [0.05, 0.4, 1.0, 3.0])
@pytest.mark.parametrize("stiffness", [1e3, 2e4, 1e9])
@pytest.mark.parametrize("room", [1e-6, 0.003, 0.03, 0.6])
def test_the_chip_is_the_root_that_brentq_finds(law, depth, stiffness, room):
    from scipy.optimize import brentq

    k = law.kf * depth / stiffness
    h = brentq(lambda x: x + k * x**law.exponent - room, 0.0, room, xtol=1e-18, rtol=1e-14)
    now = cut(law, depth, 1.0 / stiffness, room)
    assert now.force == pytest.approx(law.kf * depth * h**law.exponent, rel=1e-9)
    assert now.chip == pytest.approx(h, rel=1e-7, abs=1e-12)


def test_out_of_the_cut_there_is_no_force():
    for room in (0.0, -0.5):
        assert cut(S45C, 1.0, 1e-5, room) == (0.0, 0.0)
    assert cut(S45C, 0.0, 1e-5, 0.1).force == 0.0


@pytest.mark.slow
def test_the_surface_is_that_of_one_revolution_ago_at_any_speed():
    """Against linear interpolation in the record of all steps."""
    ring, turns, surface = blank(), 0.0, 0.0
    angles, heights = [0.0], [0.0]
    for k in range(4000):
        speed = 20.0 + 15.0 * math.sin(0.003 * k)  # revolutions a second
        following = turns + 1e-3 * speed
        expected = np.interp(following - 1.0, angles, heights) if following >= 1.0 else 0.0
        assert surface_before(ring, following) == pytest.approx(expected, abs=2e-5)
        height = 0.01 * following + 0.003 * math.sin(5.0 * following)
        leave_surface(ring, turns, surface, following, height)
        turns, surface = following, height
        angles.append(turns)
        heights.append(surface)
    assert turns > 60.0 and CELLS * 1e-3 * 35.0 > 8.0


def test_the_force_settles_where_equation_1_says():
    """A compliant tool cuts the whole feed in the steady state."""
    for stiffness in (1e4, 2e4, 1e9):
        force = loop({"plant.stiffness": stiffness}).run(1.0)["actual.force"][-1]
        assert force == pytest.approx(2256.3 * (35.5 / 1200.0) ** 0.77, rel=1e-6)


def test_the_force_builds_up_over_a_revolution():
    """A rigid tool behind an instant servo: the chip grows in a straight line for 50 ms, then stands."""
    made = loop({"plant.stiffness": 1e9, "plant.servo.rate": 900.0, "plant.servo.damping": 0.55})
    chip = made.run(0.3)["actual.chip"]
    per_turn = 35.5 / 1200.0
    assert chip[2] == pytest.approx(0.8 * per_turn, rel=0.05) and chip[1] == pytest.approx(0.4 * per_turn, rel=0.08)
    assert chip[4:] == pytest.approx(per_turn, rel=1e-3)


def test_a_hard_spot_that_doubles_the_specific_force_doubles_a_rigid_tools_force():
    made = loop({"plant.stiffness": 1e9}, disturbance=step_load(size=1.0, time=0.6))
    force = made.run(0.8)["actual.force"]
    assert force[31] == pytest.approx(2.0 * force[29], rel=1e-3)


def test_runout_turns_with_the_spindle_and_does_not_move_the_mean():
    made = loop({"plant.runout": 0.01, "plant.spindle_rpm": 1230.0})
    late = made.run(4.0)["actual.force"][100:]
    steady = 2256.3 * (35.5 / 1230.0) ** 0.77
    assert late.mean() == pytest.approx(steady, rel=1e-3)
    assert 0.005 < (late.max() - late.min()) / (2.0 * steady) < 0.0101


def test_the_depth_follows_its_programme_through_the_radial_axis():
    stairs = {"plant.depth.step": -0.2, "plant.depth.every_s": 1.0, "plant.depth.steps": 2}
    at_once = loop(stairs).run(3.0)["actual.depth"]
    followed = loop(stairs | {"plant.radial.gain": 8.57}).run(3.0)["actual.depth"]
    program = loop(stairs).blocks["plant"].params.depth
    assert at_once[1:] == pytest.approx([depth_at(program, 0.02 * k - 1e-6) for k in range(1, 150)])
    after = followed[50:100]
    rise = 0.02 * (np.argmax(after < 0.82) - np.argmax(after < 0.98))
    assert 0.18 < rise < 0.28 and after.min() > 0.795 and followed[-1] == pytest.approx(0.6, abs=1e-3)


def test_a_tool_that_has_left_the_cut_has_no_force_and_comes_back_to_an_uneven_surface():
    made = loop({"plant.depth.leave_s": 0.5})
    force = made.run(1.0)["actual.force"]
    assert force[20] > 100.0 and (force[27:] == 0.0).all()


def test_the_voltage_acts_after_the_dead_time():
    prompt = loop().run(0.6)["actual.force"]
    late = loop({"plant.servo.dead_time_s": 0.04}).run(0.6)["actual.force"]
    # the servo stands at rest until then, while the spindle has turned 0.8 revolutions: nothing has been cut
    assert (late[:3] == 0.0).all() and late[2:] == pytest.approx(prompt[:-2], rel=1e-3)
    with pytest.raises(ValueRefused, match="less than 64 steps"):
        loop({"plant.servo.dead_time_s": 0.08}).run(0.1)


@pytest.mark.parametrize("damping", [0.05, 0.7, 1.0, 3.0])
@pytest.mark.parametrize("rate", [0.5, 40.0, 3000.0])
def test_the_drives_are_stepped_by_the_matrix_exponential(rate, damping):
    from scipy.linalg import expm

    exact = expm(1e-3 * np.array([[0.0, 1.0, 0.0], [-rate * rate, -2.0 * damping * rate, 0.0], [1.0, 0.0, 0.0]]))
    found = np.array(hold(rate, damping, 1e-3)).reshape(3, 2)
    assert found == pytest.approx(exact[:, :2], rel=1e-9, abs=1e-9 * np.abs(exact).max(axis=1).min())


def force_by_scipy(plant, volt, samples, step=2e-5):
    """Force at the end of each 20 ms: drives by ``solve_ivp``, the chip by ``brentq`` on the surface's own history."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    w, zeta, gain, lag = plant.servo.rate, plant.servo.damping, plant.radial.gain, plant.radial.lag_s

    def motion(t, y):
        feed, rate, _, depth, speed = y
        asked = min(plant.servo.gain * volt, plant.servo.max_feed)
        to = float(depth_at(plant.depth, t))
        return (
            rate,
            w * w * (asked - feed) - 2 * zeta * w * rate,
            feed / 60.0,
            speed,
            (gain * (to - depth) - speed) / lag,
        )

    time = step * np.arange(samples * round(0.02 / step) + 1)
    start = [0.0, 0.0, 0.0, float(depth_at(plant.depth, 0.0)), 0.0]
    y = solve_ivp(motion, (0.0, time[-1]), start, t_eval=time, rtol=1e-9, atol=1e-12, max_step=5e-3).y
    turns, give, left = time * plant.spindle_rpm / 60.0, plant.feed_force_ratio / plant.stiffness, np.zeros(len(time))
    found = np.zeros(len(time))
    for k in range(1, len(time)):
        before = np.interp(turns[k] - 1.0, turns[:k], left[:k]) if turns[k] >= 1.0 else 0.0
        c = plant.law.kf * (y[3][k] + plant.runout * math.sin(2.0 * math.pi * turns[k]))
        room = y[2][k] - before
        h = (
            brentq(lambda h, c=c, room=room: h + give * c * h**plant.law.exponent - room, 0.0, room)
            if room > 0
            else 0.0
        )
        found[k] = c * h**plant.law.exponent
        left[k] = max(y[2][k] - give * found[k], before)
    return found[:: round(0.02 / step)]


@pytest.mark.slow
def test_steps_of_1_ms_give_the_force_of_scipys_fine_integration():
    """Servo at rest, chip build-up, runout, a depth that falls through the radial axis: all that moves."""
    changes = {
        "plant.runout": 0.01, "plant.spindle_rpm": 1000.0, "plant.radial.gain": 8.57, "plant.depth.step": -0.3,
        "plant.depth.every_s": 0.4, "plant.depth.steps": 1,
    }  # fmt: skip
    made = loop(changes)
    force = made.run(0.8)["actual.force"]
    exact = force_by_scipy(made.blocks["plant"].params, STEADY_V, len(force))[1:]
    assert np.abs(force[1:] - exact[: len(force) - 1]).max() < 1e-3 * exact.max()


def test_a_step_of_nearly_a_revolution_still_cuts_what_was_left_and_a_larger_one_is_refused():
    fastest = 60.0 * (CELLS - 1) / CELLS / 1e-3
    force = loop({"plant.spindle_rpm": fastest}).run(0.6)["actual.force"]
    assert force[-1] == pytest.approx(2256.3 * (35.5 / fastest) ** 0.77, rel=1e-6)
    with pytest.raises(ValueRefused, match=r"spindle_rpm = 6\d+.* 1/min \(turning\): at most 59765.6 1/min with steps"):
        loop({"plant.spindle_rpm": 60.0 / 1e-3}).run(0.1)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    made = loop({"plant.runout": 0.01, "plant.radial.gain": 8.57, "plant.depth.step": -0.1, "plant.depth.steps": 1})
    fast, plain = made.run(0.2), made.run(0.2, engine="python")
    assert all(np.array_equal(fast[name], plain[name]) for name in fast.signals)
