"""Point-to-point moves: limits, end points and derivatives, checked by integrating the jerk and the acceleration."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.references._motion import Motion, profile_duration, shortest_profile
from leadscrew.references._s_curve import s_curve
from leadscrew.references._trapezoid import trapezoid
from leadscrew.references._waypoints import waypoints
from leadscrew.util.errors import ValueRefused

magnitudes = st.floats(-3, 4).map(lambda e: 10.0**e)
distances = st.builds(lambda e, sign: sign * 10.0**e, st.floats(-6, 4), st.sampled_from([-1.0, 1.0]))
LIMITS = {"v": magnitudes, "a": magnitudes, "j": magnitudes}


def run(block, times):
    """The block's motion at the times, as an array with columns position, velocity, acceleration."""
    p = block.prepare(block.params, 1e-3)
    return np.array([block.step(p, float(t)) for t in times])


def pieces(profile):
    """Durations of the seven pieces of a profile."""
    jerk, hold = profile.jerk_time, profile.hold_time
    return [jerk, hold, jerk, profile.cruise_time, jerk, hold, jerk]


def integrated_jerk(profile, t):
    """Motion at ``t`` by exact integration of the piecewise constant jerk, piece after piece."""
    x = v = a = 0.0
    for length, jerk in zip(pieces(profile), profile.jerk * np.array([1, 0, -1, 0, -1, 0, 1]), strict=True):
        h = min(t, length)
        x, v, a = x + v * h + a * h**2 / 2 + jerk * h**3 / 6, v + a * h + jerk * h**2 / 2, a + jerk * h
        t -= h
    return x, v, a


def inside(profile):
    """Times inside every piece, and its edges."""
    edges = np.cumsum([0.0, *pieces(profile)])
    return np.unique(np.concatenate([edges, (edges[:-1] + edges[1:]) / 2, np.linspace(0, edges[-1], 23)]))


@settings(max_examples=80, deadline=None)
@given(distance=distances, **LIMITS)
def test_s_curve_is_the_integral_of_its_jerk_inside_its_limits(distance, v, a, j):
    block = s_curve(start=7.0, distance=distance, max_velocity=v, max_acceleration=a, max_jerk=j, start_time=0.0)
    profile = block.prepare(block.params, 1e-3).profile
    assert profile.jerk <= j * (1 + 1e-12)
    times = inside(profile)
    motion = run(block, times)
    expected = np.array([integrated_jerk(profile, t) for t in times]) * math.copysign(1.0, distance)
    scale = abs(distance)
    peak = np.abs(motion[:, 1]).max()
    # The position also carries the start, 7.0, whose rounding a short move cannot be asked to beat.
    np.testing.assert_allclose(motion[:, 0] - 7.0, expected[:, 0], rtol=0, atol=1e-9 * scale + 1e-14)
    # A time of some size is known to 1e-16 of it, and velocity and acceleration to their slope times that.
    rounding = 4e-16 * times[-1]
    slope, jolt = profile.acceleration, profile.jerk
    np.testing.assert_allclose(motion[:, 1], expected[:, 1], rtol=0, atol=1e-9 * peak + rounding * slope)
    np.testing.assert_allclose(motion[:-1, 2], expected[:-1, 2], rtol=0, atol=1e-9 * slope + rounding * jolt)
    assert peak <= v * (1 + 1e-9)
    assert np.abs(motion[:, 2]).max() <= a * (1 + 1e-9)
    end = profile_duration(profile)
    after = run(block, [end * (1 + 1e-15), 2 * end, -1.0])
    assert after[0, 0] == after[1, 0] == 7.0 + distance
    assert after[2, 0] == 7.0 and not after[:, 1:].any()


@settings(max_examples=80, deadline=None)
@given(distance=distances, v=magnitudes, a=magnitudes)
def test_trapezoid_is_the_integral_of_its_acceleration_inside_its_limits(distance, v, a):
    block = trapezoid(start=0.0, distance=distance, max_velocity=v, max_acceleration=a, start_time=0.5)
    profile = block.prepare(block.params, 1e-3).profile
    hold, cruise = profile.hold_time, profile.cruise_time
    times = inside(profile)

    def integrated(t):
        up, level, down = min(t, hold), min(max(t - hold, 0), cruise), max(t - hold - cruise, 0)
        peak = a * hold
        return a * up**2 / 2 + peak * level + peak * down - a * down**2 / 2, a * (up - down)

    motion = run(block, 0.5 + times)
    expected = np.array([integrated(t) for t in times]) * math.copysign(1.0, distance)
    # Adding and taking away the start time rounds the time by some 1e-16.
    rounding = 4e-16 * (1 + times[-1])
    peak = a * hold
    np.testing.assert_allclose(motion[:, 0], expected[:, 0], rtol=0, atol=1e-9 * abs(distance) + peak * rounding)
    np.testing.assert_allclose(motion[:, 1], expected[:, 1], rtol=0, atol=1e-9 * peak + a * rounding)
    assert np.abs(motion[:, 1]).max() <= v * (1 + 1e-9)
    assert np.abs(motion[:, 2]).max() <= a
    assert run(block, [1.0 + 2 * times[-1]])[0] == pytest.approx([distance, 0, 0], abs=0)


@settings(max_examples=80, deadline=None)
@given(distance=magnitudes, **LIMITS)
def test_no_profile_inside_the_limits_is_shorter(distance, v, a, j):
    """Time-optimal: every piece of the profile runs at a limit, so shortening it breaks one."""
    profile = shortest_profile(distance, v, a, j)
    peak = profile.acceleration * (profile.jerk_time + profile.hold_time)
    at_velocity, at_acceleration = peak >= v * (1 - 1e-9), profile.acceleration >= a * (1 - 1e-9)
    assert profile.jerk == j
    assert profile.cruise_time <= 1e-9 * profile_duration(profile) or at_velocity
    assert profile.hold_time <= 1e-6 * profile_duration(profile) or at_acceleration
    covered = peak * (2 * profile.jerk_time + profile.hold_time + profile.cruise_time)
    assert covered == pytest.approx(distance, rel=1e-9)


@pytest.mark.parametrize(
    ("distance", "duration", "what"),
    [
        # v = 10, a = 100, j = 10000: jerk_time 0.01, hold 0.09, speeding up takes 0.11 s and 0.55 mm.
        (10.0, 10 / 10 + 0.1 + 0.01, "all seven segments"),
        (1.1, 0.22, "no cruise, velocity just reached"),
        (0.02, 0.04, "acceleration just reached: 2 a^3 / j^2"),
        (0.0025, 0.02, "neither reached: jerk_time = (d / 2 j)^(1/3) = 0.005"),
    ],
)
def test_s_curve_durations_worked_by_hand(distance, duration, what):
    assert profile_duration(shortest_profile(distance, 10.0, 100.0, 1e4)) == pytest.approx(duration, rel=1e-12), what


def test_s_curve_that_never_reaches_the_acceleration_but_cruises():
    profile = shortest_profile(5.0, 1.0, 1e6, 100.0)
    assert profile.jerk_time == pytest.approx(0.1) and profile.hold_time == 0.0
    assert profile.cruise_time == pytest.approx(5.0 - 0.2)


def test_trapezoid_worked_by_hand():
    motion = run(trapezoid(start=5.0, distance=-100.0, max_velocity=50.0, max_acceleration=100.0), [0.25, 1.0, 2.25])
    np.testing.assert_allclose(motion, [[5 - 3.125, -25, -100], [5 - 37.5, -50, 0], [5 - 96.875, -25, 100]])
    triangle = run(trapezoid(distance=4.0, max_velocity=50.0, max_acceleration=100.0), [0.1, 0.2, 0.4])
    np.testing.assert_allclose(triangle, [[0.5, 10, 100], [2, 20, -100], [4, 0, 0]], atol=1e-12)


@pytest.mark.parametrize("block", [trapezoid, s_curve])
def test_a_move_of_nothing_stays(block):
    assert run(block(start=3.0, distance=0.0), [-1.0, 0.0, 1.0]).tolist() == [[3.0, 0.0, 0.0]] * 3


def test_derivatives_are_those_of_the_position():
    t = np.linspace(-0.1, 1.4, 15001)
    motion = run(s_curve(distance=-80.0), t)
    velocity = np.gradient(motion[:, 0], t)
    acceleration = np.gradient(motion[:, 1], t)
    np.testing.assert_allclose(motion[1:-1, 1], velocity[1:-1], atol=1e-3)
    np.testing.assert_allclose(motion[1:-1, 2], acceleration[1:-1], atol=2.0)  # jerk times the spacing
    assert isinstance(s_curve.step(s_curve.prepare(s_curve.params, 1e-3), 0.1), Motion)


def test_limits_that_no_number_can_carry_are_refused():
    with pytest.raises(ValueRefused, match="too far apart"):
        run(s_curve(max_jerk=5e-324), [0.0])


def test_waypoints_visit_each_position_and_rest_there():
    block = waypoints([1.0, 5.0, -3.0, -3.0], dwell=[0.5, 1.0, 0.25, 9.0], max_velocity=4.0, max_acceleration=8.0)
    # 4 mm: 1.5 s; 8 mm: 2.5 s; no way: 0 s.
    times = [0.0, 0.5, 1.25, 2.0, 2.9, 4.25, 5.5, 6.0, 99.0]
    positions = [1.0, 1.0, 3.0, 5.0, 5.0, 1.0, -3.0, -3.0, -3.0]
    motion = run(block, times)
    np.testing.assert_allclose(motion[:, 0], positions, atol=1e-12)
    assert motion[2, 1] == pytest.approx(4.0) and motion[5, 1] == pytest.approx(-4.0)
    smooth = run(block.using(max_jerk=100.0), np.linspace(0, 8, 4001))
    assert np.abs(np.diff(smooth[:, 2])).max() <= 100.0 * 0.002 * (1 + 1e-6)
    assert smooth[-1].tolist() == [-3.0, 0.0, 0.0]


def test_waypoints_refuse_one_position_and_values_out_of_range():
    with pytest.raises(ValueRefused, match="two or more"):
        waypoints([1.0])
    with pytest.raises(ValueRefused, match="max_velocity"):
        waypoints([1.0, 2.0], max_velocity=0.0)
    with pytest.raises(ValueRefused, match="dwell"):
        waypoints([1.0, 2.0], dwell=-1.0)
