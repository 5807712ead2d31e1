"""G-code paths against programs worked by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.references._gcode import path_from_gcode, segments_from_gcode
from leadscrew.references._path import PathPoint, arc, duration
from leadscrew.util.errors import DataError, ValueRefused


def trace(block, times):
    """Positions, velocities, accelerations of X and Y (and Z) at the times: shape (time, axis, 3)."""
    p = block.prepare(block.params, 1e-3)
    return np.array([block.step(p, float(t)) for t in times])


SQUARE = """%
(a square of 20 mm) ; run clockwise
N10 G21 G90 G17 G61
N20 G1 F1200 X0 Y20
N30 X20
N40 Y0
N50 g1 x0 (home)
M30
this is after the end
"""


def test_square_runs_each_side_with_a_stop_at_each_corner():
    block = path_from_gcode(SQUARE, max_acceleration=400.0)
    # 20 mm at 20 mm/s and 400 mm/s^2: 1 s + 0.05 s a side.
    assert duration(block) == pytest.approx(4.2, rel=1e-12)
    corners = trace(block, np.arange(5) * 1.05)
    np.testing.assert_allclose(corners[:, :, 0], [[0, 0], [0, 20], [20, 20], [20, 0], [0, 0]], atol=1e-12)
    np.testing.assert_allclose(corners[:, :, 1], 0, atol=1e-9)
    middle = trace(block, [0.525, 1.575])
    np.testing.assert_allclose(middle[:, :, 0], [[0, 10], [10, 20]], atol=1e-12)
    np.testing.assert_allclose(middle[:, :, 1], [[0, 20], [20, 0]], atol=1e-12)
    p = block.prepare(block.params, 1e-3)
    assert isinstance(block.step(p, 0.1), PathPoint)


def test_incremental_and_inch_programs_give_the_same_path():
    inches = f"G20 G91 G1 F{1200 / 25.4} Y{20 / 25.4}\nX{20 / 25.4}\nY-{20 / 25.4}\nX-{20 / 25.4}"
    t = np.linspace(0, 4.3, 87)
    for program in (inches, inches.splitlines()):
        other = path_from_gcode(program, max_acceleration=400.0)
        np.testing.assert_allclose(
            trace(other, t)[..., :2], trace(path_from_gcode(SQUARE, max_acceleration=400.0), t)[..., :2], atol=1e-9
        )


CIRCLES = {
    "quarters with I J": ["G1 F600 G2 X50 Y0 I0 J-50", "X0 Y-50 I-50", "X-50 Y0 J50", "X0 Y50 I50"],
    "quarters with R": ["G2 F600 X50 Y0 R50", "X0 Y-50 R50", "X-50 Y0 R50", "X0 Y50 R50"],
    "one full turn": ["F600", "G02 J-50."],
    "three quarters and one": ["G2 F600 X-50 Y0 R-50", "X0 Y50 R50"],
}


@pytest.mark.parametrize("name", CIRCLES)
def test_circle_keeps_its_radius_direction_and_feed(name):
    lines = [line.replace("G1 F600 G2", "F600 G2") for line in CIRCLES[name]]
    block = path_from_gcode(lines, start=(0.0, 50.0, 0.0), max_acceleration=1000.0)
    end = duration(block)
    stops = len(block.params.segments)
    # 10 mm/s; speeding up at sqrt(3)/2 of 1000 mm/s^2 costs v/a a stop.
    assert end == pytest.approx(2 * math.pi * 50 / 10 + stops * 10 / (1000 * math.sqrt(3) / 2), rel=1e-12)
    t = np.linspace(0, end, 4001)
    (x, vx, ax), (y, vy, ay) = np.moveaxis(trace(block, t), 0, -1)
    np.testing.assert_allclose(np.hypot(x, y), 50.0, rtol=1e-12)
    speed = np.hypot(vx, vy)
    assert speed.max() == pytest.approx(10.0, rel=1e-9)
    np.testing.assert_allclose(x * vx + y * vy, 0, atol=1e-9)
    assert (x * vy - y * vx <= 1e-9).all(), "G2 is clockwise"
    swept = np.unwrap(np.arctan2(y, x))
    assert swept[-1] - swept[0] == pytest.approx(-2 * math.pi, rel=1e-9)
    assert np.hypot(ax, ay).max() <= 1000.0 * (1 + 1e-9)
    for when in np.random.default_rng(3).uniform(0, end, 100):
        before, here, after = trace(block, [when - 1e-6, when, when + 1e-6])
        np.testing.assert_allclose((after[:, 0] - before[:, 0]) / 2e-6, here[:, 1], atol=0.01)
        np.testing.assert_allclose((after[:, 1] - before[:, 1]) / 2e-6, here[:, 2], atol=1.0)


def test_counter_clockwise_is_the_mirror_image():
    left = path_from_gcode("G3 F600 X-10 Y10 I-10")
    right = path_from_gcode("G2 F600 X10 Y10 I10")
    t = np.linspace(0, duration(left), 50)
    np.testing.assert_allclose(trace(left, t)[:, 0], -trace(right, t)[:, 0], atol=1e-12)
    np.testing.assert_allclose(trace(left, t)[:, 1], trace(right, t)[:, 1], atol=1e-12)


def test_a_small_arc_is_slowed_to_keep_the_acceleration():
    block = path_from_gcode("G2 F60000 X2 Y0 I1 J0", max_acceleration=800.0)
    motion = trace(block, np.linspace(0, duration(block), 2001))
    assert np.hypot(motion[:, 0, 2], motion[:, 1, 2]).max() <= 800.0 * (1 + 1e-9)
    assert np.hypot(motion[:, 0, 1], motion[:, 1, 1]).max() == pytest.approx(20.0, rel=1e-3)


def test_a_helix_may_be_faster_than_its_circle_for_only_its_motion_in_the_plane_turns():
    """Radius 10 mm, rising by its circumference: of v only v / sqrt(2) turns, so v^2 / 2 / 10 mm = 400 mm/s^2."""
    block = path_from_gcode(f"G3 F60000 X0 Y0 I-10 Z{20.0 * math.pi}", max_acceleration=800.0, with_z=True)
    motion = trace(block, np.linspace(0, duration(block), 2001))
    assert np.linalg.norm(motion[:, :, 1], axis=1).max() == pytest.approx(math.sqrt(8000.0), rel=1e-3)
    assert np.linalg.norm(motion[:, :, 2], axis=1).max() <= 800.0 * (1 + 1e-9)


def test_helix_dwell_and_depth_take_their_time():
    block = path_from_gcode("G0 Z-1\nG4 P0.5\nG3 F600 I-10 Z-6", max_acceleration=1e6, rapid=600.0, with_z=True)
    length = math.hypot(20 * math.pi, 5)
    assert duration(block) == pytest.approx(0.1 + 0.5 + length / 10, rel=1e-3)
    end = trace(block, [duration(block)])[0, :, 0]
    np.testing.assert_allclose(end, [0, 0, -6], atol=1e-12)
    motion = trace(block, [3.0])[0]
    assert np.linalg.norm(motion[:, 1]) == pytest.approx(10.0, rel=1e-9)


def test_an_arc_with_rounded_numbers_ends_where_it_says_without_a_jump():
    block = path_from_gcode("G2 F600 X7.07 Y7.07 I0 J-10 \nG1 X20", start=(0, 10, 0))
    t = np.linspace(0, duration(block), 20001)
    x, y = trace(block, t)[:, :2, 0].T
    assert np.hypot(np.diff(x), np.diff(y)).max() <= 10.0 * (t[1] - t[0]) * (1 + 2e-3)


def test_an_incremental_circle_that_misses_its_start_by_rounding_is_a_full_turn():
    segments = segments_from_gcode("G91 G1 F100 X0.1\nX0.2\nX-0.3\nG90 G2 X0 Y0 I5", start=(0, 0, 0))
    assert segments[-1].length == pytest.approx(10 * math.pi)


def test_jerk_limit_and_feed_override_and_start_time():
    block = path_from_gcode("G1 F600 X10", max_jerk=1e4, max_acceleration=500.0, start_time=1.0, feed_override=0.5)
    # 5 mm/s: the acceleration of 500 is never reached, jerk_time = sqrt(5 / 1e4).
    assert duration(block) == pytest.approx(1.0 + 2.0 + 2 * math.sqrt(5 / 1e4), rel=1e-12)
    t = np.linspace(0, duration(block), 5001)
    motion = trace(block, t)
    assert motion[t < 1.0].any() == np.False_
    assert np.abs(np.diff(motion[:, 0, 2])).max() <= 1e4 * (t[1] - t[0]) * (1 + 1e-6)


@pytest.mark.parametrize(
    ("program", "text"),
    [
        ("G1 F100 X1\nG1 Y2 S300", r"line 2: S300 is not understood"),
        ("G64 P0.01", r"line 1: G64 is not understood"),
        ("G18", "G18"),
        ("G93 G1 F100 X1", "G93 is not understood"),
        ("M3", "M3 is not understood; known: M2, M30"),
        ("G1 X1", "F is missing"),
        ("X1", "no G0, G1, G2 or G3"),
        ("G80 G1 F9 X1\nG80\nX2", "line 3: X2: no G0"),
        ("G0 G1 X1", "G1 contradicts"),
        ("G1 F100 X1 X2", "X2: a second X"),
        ("G1 F100 X1 (open", "comment is not closed"),
        ("G1 F100 X", "cannot read 'X'"),
        ("G1 F100 X#5", "cannot read 'X#5'"),
        ("/G1 F100 X1", "cannot read '/G1"),
        ("G2 F100 X10 Y0", "needs the centre"),
        ("G2 F100 X10 Y0 I4 J0", "radius is 4 mm at the start of the arc and 6 mm"),
        ("G2 F100 X10 Y0 R2", "less than half the chord, 5 mm"),
        ("G2 F100 X10 R5 I5", "give one of them"),
        ("G2 F100 X0 Y0 R5", "start and end are the same"),
        ("G2 F100 X5 I0 J0", "radius is zero"),
        ("G1 F0 X5", "feed must be positive"),
        ("G4 X1", "G4 needs P"),
        ("G4 P1 X1", "X1 has no use"),
        ("G1 F100 X5 I3", "I3 has no use"),
        ("G21 G20", "G20 contradicts"),
        ("G90\nM2\nG1 F100 X1", "does not move"),
    ],
)
def test_what_is_not_understood_is_refused_by_line_and_word(program, text):
    with pytest.raises(DataError, match=text.replace("(", r"\(")):
        path_from_gcode(program)


def test_parameters_are_checked():
    with pytest.raises(ValueRefused, match="max_acceleration"):
        path_from_gcode("G0 X1", max_acceleration=-1.0)


coordinates = st.floats(-100, 100).map(lambda x: round(x, 3))


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=6), st.one_of(st.just(0.0), st.floats(1e-3, 1e6))
)
def test_any_polyline_is_followed_through_its_points_inside_the_limits(points, jerk):
    lines = [f"G1 F3000 X{x:.3f} Y{y:.3f}" for x, y in points]
    if all(point == (0.0, 0.0) for point in points):
        return
    block = path_from_gcode(lines, max_acceleration=500.0, max_jerk=jerk)
    p = block.prepare(block.params, 1e-3)
    starts = np.append(p.table[1:, 0], duration(block))
    visited = [point for k, point in enumerate(points) if point != ([(0.0, 0.0), *points])[k]]
    starts += 1e-12 * starts  # the profile may end a rounding error later
    at_stops = trace(block, starts)
    np.testing.assert_allclose(at_stops[:, :, 0], visited, atol=1e-9)
    motion = trace(block, np.linspace(0, duration(block), 200))
    assert np.hypot(motion[:, 0, 1], motion[:, 1, 1]).max() <= 50.0 * (1 + 1e-9)
    assert np.hypot(motion[:, 0, 2], motion[:, 1, 2]).max() <= 500.0 * (1 + 1e-9)


@pytest.mark.parametrize(("apart", "whole"), [(0.0, True), (5e-10, True), (2e-9, False), (1e-3, False)])
def test_an_arc_whose_end_is_a_nanometre_beyond_its_start_is_that_short_and_no_full_turn(apart, whole):
    end = (10.0 * math.cos(apart / 10.0), 10.0 * math.sin(apart / 10.0), 0.0)
    found = arc((10.0, 0.0, 0.0), end, (0.0, 0.0), clockwise=False)
    assert found.length == pytest.approx(20.0 * math.pi if whole else apart, rel=1e-5)
    back = arc((10.0, 0.0, 0.0), end, (0.0, 0.0), clockwise=True)
    assert back.length == pytest.approx(20.0 * math.pi - (0.0 if whole else apart), rel=1e-9)
