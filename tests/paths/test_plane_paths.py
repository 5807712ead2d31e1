"""Paths and the shapes of the study, against known numbers and geometry worked by hand."""

import math

import numpy as np
import pytest

from leadscrew.paths.path import Path, polyline, sampled, wrapped
from leadscrew.paths.segments import Arc, Bezier, Line
from leadscrew.paths.shapes import flower, rounded_rectangle, wave
from leadscrew.util.errors import ValueRefused

# Samples at 0.5 mm, smallest radius, swivel rate at 50 mm/s.
SHAPES = {
    "wave": (wave, 1.0, 923, 16.5, 174),
    "flower": (flower, 1.0, 789, 6.4, 445),
    "rrect": (rounded_rectangle, 1.5, 908, 10.0, 286),
}


@pytest.mark.parametrize("name", SHAPES)
def test_the_paths_of_the_study_have_the_known_numbers(name):
    make, laps, count, radius, swivel = SHAPES[name]
    places = sampled(make(), 0.5, laps)
    assert len(places.travel) == count
    sharpest = np.abs(places.curvature).max()
    assert 1 / sharpest == pytest.approx(radius, abs=0.05)
    assert math.degrees(50 * sharpest) == pytest.approx(swivel, abs=0.5)
    steps = np.hypot(np.diff(places.x), np.diff(places.y))
    assert steps.max() <= 0.5 + 1e-9 and steps.min() > 0.499
    # The curvature is what the heading does.
    middle = 0.5 * np.radians(places.heading[2:] - places.heading[:-2]) / 0.5
    smooth = np.abs(np.diff(places.curvature, 2)) < 0.01
    np.testing.assert_allclose(middle[smooth], places.curvature[1:-1][smooth], atol=2e-3)


def test_the_wave_stays_inside_a_right_angle_and_measures_462_mm():
    assert wave().length == pytest.approx(462, abs=0.5)
    heading = sampled(wave(), 0.5).heading
    assert heading.min() == pytest.approx(-65, abs=0.5)
    assert heading.max() == pytest.approx(76, abs=0.5)
    assert wave().corners == []


def test_the_flower_closes_and_its_radius_is_the_formula():
    path = flower()
    places = sampled(path, 0.5)
    angle = np.arctan2(places.y, places.x)
    np.testing.assert_allclose(np.hypot(places.x, places.y), 50 + 11 * np.cos(5 * angle), atol=1e-9)
    assert path.turn == pytest.approx(360)
    assert (places.curvature < 0).any(), "it has inflections"


def test_a_lap_of_the_rounded_rectangle_by_hand():
    path = rounded_rectangle(100, 60, 10)
    assert path.length == pytest.approx(2 * 80 + 2 * 40 + 20 * math.pi, abs=1e-12)
    arc = 5 * math.pi
    places = path.at([0.0, 80.0, 80 + arc / 2, 80 + arc, path.length + 10])
    np.testing.assert_allclose(places.x, [10, 90, 90 + 10 * math.sqrt(0.5), 100, 20], atol=1e-12)
    np.testing.assert_allclose(places.y, [0, 0, 10 - 10 * math.sqrt(0.5), 10, 0], atol=1e-12)
    np.testing.assert_allclose(places.heading, [0, 0, 45, 90, 360], atol=1e-12)
    np.testing.assert_allclose(places.curvature, [0, 0.1, 0.1, 0, 0], atol=1e-12)
    assert path.corners == []
    laps = sampled(path, 0.5, 1.5)
    assert laps.travel[-1] == pytest.approx(453.5)
    assert laps.heading[-1] == pytest.approx(540, abs=5)


def test_whole_laps_join_without_a_step():
    path = flower()
    lap = sampled(path, 0.5, whole=True)
    step = lap.travel[1]
    assert len(lap.travel) * step == pytest.approx(path.length)
    assert abs(step - 0.5) < 0.001
    again = path.at(lap.travel + path.length)
    np.testing.assert_allclose(again.heading, lap.heading + lap.turn, atol=1e-6)
    np.testing.assert_allclose([again.x, again.y], [lap.x, lap.y], atol=1e-9)


def test_corners_of_a_square_and_the_heading_that_goes_on():
    square = polyline(np.array([[0, 0], [20, 0], [20, 20], [0, 20.0]]), closed=True)
    assert [c.turn_deg for c in square.corners] == pytest.approx([90, 90, 90, 90])
    assert [c.travel for c in square.corners] == pytest.approx([20, 40, 60, 80])
    assert square.turn == pytest.approx(360)
    np.testing.assert_allclose(square.at([0, 19.9, 20, 79, 81]).heading, [0, 0, 90, 270, 360])
    clockwise = square.reversed()
    assert [c.turn_deg for c in clockwise.corners] == pytest.approx([-90, -90, -90, -90])
    assert clockwise.turn == pytest.approx(-360)
    mirrored = square.transformed([[-1, 0, 0], [0, 1, 0]])
    assert mirrored.turn == pytest.approx(-360)
    open_one = polyline(np.array([[0, 0], [20, 0], [20, 20], [0, 0.0]]))
    assert [round(c.turn_deg) for c in open_one.corners] == [90, 135]
    assert open_one.turn == 0.0


def test_a_path_that_turns_back_turns_half_a_turn():
    there = polyline(np.array([[0, 0], [10, 10], [0, 0.0]]))
    assert [c.turn_deg for c in there.corners] == pytest.approx([180])
    assert [wrapped(a) for a in (180, -180, 540, -179, 181, 0)] == pytest.approx([180, 180, 180, -179, -179, 0])


def test_a_cusp_inside_a_curve_is_a_corner_of_the_path():
    (corner,) = Path([Bezier([[0, 0], [10, 10], [0, 10], [10, 0]])]).corners
    assert (corner.x, corner.y) == pytest.approx((5, 7.5))
    assert corner.turn_deg == pytest.approx(180)


def test_tiny_gaps_are_joined_and_others_refused():
    Path([Line((0, 0), (10, 0)), Line((10, 0.005), (10, 10))])
    with pytest.raises(ValueRefused, match=r"a gap of 0.02 mm after segment 1, at \(10, 0\); at most 0.01 mm"):
        Path([Line((0, 0), (10, 0)), Line((10, 0.02), (10, 10))])
    with pytest.raises(ValueRefused, match="gap of 10 mm after segment 1"):
        Path([Line((0, 0), (10, 0))], closed=True)


@pytest.mark.parametrize(
    ("act", "text"),
    [
        (lambda: Path([Line((1, 1), (1, 1))]), "one segment or more"),
        (lambda: wave().at(500.0), "at most its length, 461.541"),
        (lambda: wave().at(-1.0), "from 0 on"),
        (lambda: flower().at(math.nan), "finite"),
        (lambda: sampled(wave(), 0.0), "step_mm"),
        (lambda: sampled(wave(), 1e4), "step_mm"),
        (lambda: sampled(wave(), 0.5, 2), "1 on an open path"),
        (lambda: sampled(flower(), 0.5, -1), "above 0"),
        (lambda: rounded_rectangle(10, 10, 6), "at most half of 10"),
        (lambda: flower(5, 6), "less than the radius"),
    ],
)
def test_what_is_out_of_range_is_refused(act, text):
    with pytest.raises(ValueRefused, match=text):
        act()


def test_an_affine_map_of_a_path_maps_its_points_and_keeps_its_joints():
    path = Path([Line((0, 0), (30, 0)), Arc((30, 10), 10, -math.pi / 2, math.pi)])
    matrix = np.array([[1.2, 0.4, 3], [-0.3, 0.8, -7]])
    mapped = path.transformed(matrix)
    assert mapped.corners == []
    s = 30 + 5 * math.pi
    before = path.at(s)
    found = mapped.at(np.linspace(0, mapped.length, 4001))
    point = matrix[:, :2] @ [before.x, before.y] + matrix[:, 2]
    assert np.hypot(found.x - point[0], found.y - point[1]).min() < mapped.length / 4000
