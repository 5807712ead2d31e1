"""Loops draw circles: against the frequency response worked out by hand, and what is refused."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import Loop
from leadscrew.analysis.circular import simulation
from leadscrew.analysis.circular.diagnosis import diagnose
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.analysis.circular.simulation import Circle, Machine, draw
from leadscrew.kernel.block import controller, plant, sensor
from leadscrew.references._path import line, path
from leadscrew.references._sine import sine, sine_motion
from leadscrew.util.errors import DataError, Diverged, ValueRefused


class Pair(NamedTuple):
    x: float = 0.0
    y: float = 0.0


class Gains(NamedTuple):
    x: float = 40.0
    y: float = 25.0


class Gain(NamedTuple):
    gain: float = 40.0


class Place(NamedTuple):
    position: float = 0.0


def shown(s):
    """Both axes."""
    return s


@plant(Pair(), Pair(), output=shown, unit="mm")
def table(p, s, u):
    """Two axes whose speed is what is asked of them."""
    return Pair(u.x, u.y)


@plant(Gain(), Place(), unit="mm")
def axis(p, s, u):
    """One of them."""
    return Place(u)


@controller(Gains())
def two_gains(p, command, feedback):
    """A velocity for each axis, from motions."""
    return Pair(p.x * (command.x.position - feedback.x), p.y * (command.y.position - feedback.y))


@controller(Gains())
def two_gains_of_points(p, command, feedback):
    """The same from positions."""
    return Pair(p.x * (command.x - feedback.x), p.y * (command.y - feedback.y))


@controller(Gains())
def swapped(p, command, feedback):
    """X follows the command of Y, and the other way round."""
    return Pair(p.x * (command.y.position - feedback.x), p.y * (command.x.position - feedback.y))


@controller(Gain())
def one_gain(p, command, feedback):
    """A velocity from a position."""
    return p.gain * (command - feedback)


@controller(Gain())
def one_gain_of_motion(p, command, feedback):
    """A velocity from a motion."""
    return p.gain * (command.position - feedback)


@sensor(Gain(0.002))
def coarse(p, actual):
    """Steps of 2 um on both axes."""
    return Pair(p.gain * math.floor(actual.x / p.gain + 0.5), p.gain * math.floor(actual.y / p.gain + 0.5))


@sensor(Gain(0.001))
def drifting(p, actual, t):
    """A scale that creeps."""
    return actual + p.gain * t


def moving(block=two_gains, **more):
    there = path([line((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), 1000.0)])
    return Loop(reference=there, controller=block, plant=table, period=1e-3, **more)


def alone(gain, block=one_gain_of_motion, reference=sine_motion, place=axis):
    return Loop(reference=reference, controller=block(gain=gain), plant=place, period=1e-3)


def response(gain, omega, period=1e-3):
    """Steady response of the sampled loop x(k+1) = x(k) + gain period (r(k) - x(k)) to exp(j omega t)."""
    return gain * period / (cmath.exp(1j * omega * period) - 1.0 + gain * period)


RADIUS, FEED = 50.0, 3000.0
OMEGA = FEED / 60.0 / RADIUS


def by_hand(direction):
    """The steady ellipse of both axes, at the 1,800 angles of the command."""
    sign = 1.0 if direction == "ccw" else -1.0
    turn = np.exp(1j * 2.0 * np.pi * np.arange(1800) / 1800)
    gx, gy = response(40.0, OMEGA), response(25.0, OMEGA)
    return RADIUS * (gx * turn).real, sign * RADIUS * (gy * turn).imag


@pytest.mark.parametrize("block", [two_gains, two_gains_of_points])
def test_the_path_is_the_ellipse_of_the_frequency_response(block):
    loop = moving(block)
    if block is two_gains_of_points:
        loop = Loop(reference=simulation.circle_point, controller=block, plant=table, period=1e-3)
    test = draw(Machine(loop), Circle(RADIUS, FEED))
    for turn in test.turns:
        x, y = by_hand(turn.direction)
        # 1 nm: the points lie between control periods, where the deviation is interpolated.
        assert np.abs(turn.x_mm - x).max() < 1e-6 and np.abs(turn.y_mm - y).max() < 1e-6


@pytest.mark.slow
def test_the_servo_mismatch_is_the_difference_of_the_lags():
    test = draw(Machine(moving()), Circle(RADIUS, 300.0))
    omega = 300.0 / 60.0 / RADIUS
    lags = [-cmath.phase(response(k, omega)) / omega for k in (40.0, 25.0)]
    found = diagnose(test)
    assert found["servo mismatch"].more["ms"] == pytest.approx(1000.0 * (lags[0] - lags[1]), rel=0.01)
    # 1/40 s - 1/25 s = -15 ms.
    assert found["servo mismatch"].more["ms"] == pytest.approx(-15.0, rel=0.02)
    assert abs(found["squareness"].um) < 0.05


@pytest.mark.parametrize(
    ("block", "reference"), [(one_gain_of_motion, sine_motion), (one_gain, sine)], ids=["motion", "position"]
)
def test_two_loops_of_one_axis_draw_the_same_circle_as_one_of_two(block, reference):
    machine = Machine(alone(40.0, block, reference), alone(25.0, block, reference))
    one, other = (draw(m, Circle(RADIUS, FEED, start_deg=30.0)) for m in (machine, Machine(moving())))
    for a, b in zip(one.turns, other.turns, strict=True):
        assert np.abs(a.x_mm - b.x_mm).max() < 1e-9 and np.abs(a.y_mm - b.y_mm).max() < 1e-9


def test_axes_and_directions_side_by_side_have_the_bits_of_one_by_one():
    machine, circle = Machine(alone(40.0), alone(25.0)), Circle(1.0, 600.0, points=360)
    seen = []
    together = draw(machine, circle, progress=lambda what, done: seen.append(done))
    assert seen == [0.0, 0.25, 0.5, 0.75]
    # The python engine runs one after the other; with one direction alone there is less side by side.
    for other in (draw(machine, circle, engine="python"), draw(machine, replace(circle, direction="cw"))):
        for turn in other.turns:
            mine = together.cw if turn.direction == "cw" else together.ccw
            assert np.array_equal(mine.x_mm, turn.x_mm) and np.array_equal(mine.y_mm, turn.y_mm)


def test_the_encoder_s_circle_is_what_the_sensor_says_and_is_labelled():
    loop = moving(sensor=coarse)
    seen = draw(Machine(loop), Circle(RADIUS, FEED, source="encoder", points=500))
    assert "encoder signals" in " ".join(seen.notes())
    true = draw(Machine(loop), Circle(RADIUS, FEED, points=500))
    assert quantities(seen).ccw.circular > quantities(true).ccw.circular


def test_the_command_starts_at_rest_without_a_jump_and_its_derivatives_are_exact():
    params = simulation.CircleParams(radius=3.0, speed=2.0, turning=-1.0, start=0.4, centre_x=1.0, centre_y=-2.0)
    start = simulation.circle_motion.step(params, 0.0)
    assert (start.x.velocity, start.y.velocity, start.x.acceleration, start.y.acceleration) == (0, 0, 0, 0)
    assert start.x.position == pytest.approx(1.0 + 3.0 * math.cos(0.4))
    for t in np.linspace(0.05, 4.0, 37):
        before, now, after = (simulation.circle_motion.step(params, t + h) for h in (-1e-4, 0.0, 1e-4))
        for a, b, c in ((before.x, now.x, after.x), (before.y, now.y, after.y)):
            assert (c.position - a.position) / 2e-4 == pytest.approx(b.velocity, abs=1e-5)
            assert (c.velocity - a.velocity) / 2e-4 == pytest.approx(b.acceleration, abs=2e-4)
    speed = simulation.circle_motion.step(params, 3.0)
    assert math.hypot(speed.x.velocity, speed.y.velocity) == pytest.approx(6.0)


# ---- refused
@pytest.mark.parametrize(
    ("values", "said"),
    [({"radius_mm": 0.0}, "radius = 0.0 mm"), ({"feed_mm_min": -1.0}, "feed"), ({"direction": "left"}, "ccw or cw"),
     ({"points": 2}, "36 to"), ({"source": "eye"}, "path or encoder"), ({"start_deg": math.nan}, "start")],
)  # fmt: skip
def test_circles_that_are_none_are_refused(values, said):
    with pytest.raises(ValueRefused, match=said):
        Circle(**values)


def test_machines_that_cannot_draw_one_are_refused():
    with pytest.raises(ValueRefused, match=r"has not two axes.*give the loop of the other axis"):
        draw(Machine(alone(40.0)), Circle())
    with pytest.raises(ValueRefused, match="has both axes already"):
        draw(Machine(moving(), moving()), Circle())
    with pytest.raises(ValueRefused, match="control periods; expected at least 8"):
        draw(Machine(moving()), Circle(0.001, 6000.0))
    turning = replace(axis, unit="rad")
    with pytest.raises(ValueRefused, match="moves in rad; a circle needs a length"):
        draw(Machine(alone(40.0, place=turning), alone(40.0, place=turning)), Circle())
    with pytest.raises(ValueRefused, match="different units: mm, um"):
        Machine(alone(40.0), alone(40.0, place=replace(axis, unit="um"))).mm()
    with pytest.raises(ValueRefused, match="does not say the unit"):
        Machine(alone(40.0, one_gain, sine, replace(axis, unit=""))).mm()
    with pytest.raises(DataError, match="are the axes swapped"):
        draw(Machine(moving(swapped)), Circle(RADIUS, FEED))


def test_a_loop_that_diverges_on_the_circle_says_so():
    with pytest.raises(Diverged, match="on the circle"):
        draw(Machine(moving(two_gains(x=2500.0))), Circle(RADIUS, FEED))


def test_a_path_that_drifts_does_not_close_and_is_noted():
    still, warm = (
        draw(Machine(alone(40.0), Loop(reference=sine_motion, controller=one_gain_of_motion, plant=axis, sensor=s)),
             Circle(RADIUS, FEED))
        for s in (None, drifting)
    )  # fmt: skip
    assert still.open_um < 1e-3 and "does not close" not in " ".join(still.notes())
    # A scale that creeps by 1 um/s, for one turn.
    assert warm.open_um == pytest.approx(2.0 * math.pi / OMEGA, rel=1e-3)
    assert "does not close: it ends 6.28 um beside its start" in " ".join(warm.notes())


def test_micrometres_are_micrometres():
    small = replace(axis, unit="um")
    test = draw(Machine(alone(40.0, place=small), alone(25.0, place=small)), Circle(RADIUS, FEED))
    assert np.abs(test.ccw.x_mm - by_hand("ccw")[0]).max() < 1e-6
