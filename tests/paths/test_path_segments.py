"""Segments against quadrature by SciPy, differences of points, and geometry worked by hand."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipeinc

from leadscrew.paths.segments import Arc, Bezier, EllipseArc, Line, Spline
from leadscrew.paths.shapes import Rosette, clamped_spline
from leadscrew.util.errors import ValueRefused

NURBS = Spline(
    [[0, 0], [10, 20], [25, 25], [40, 0], [55, -10], [70, 15]],
    [0, 0, 0, 0, 0.3, 0.7, 1, 1, 1, 1],
    3,
    [1, 2, 0.5, 1.5, 1, 1],
)
SEGMENTS = {
    "line": Line((1, 2), (31, -8)),
    "arc": Arc((5, 5), 12, 0.3, -4.0),
    "ellipse": EllipseArc((3, -2), (20, 5), (-2, 8), -0.4, 5.0),
    "quadratic": Bezier.quadratic((0, 0), (20, 30), (45, -5)),
    "cubic": Bezier([[0, 0], [30, 40], [5, 45], [50, 0]]),
    "quintic": Bezier([[0, 0], [10, 20], [30, 20], [35, -20], [50, -10], [60, 0]]),
    "spline": clamped_spline(np.array([[0, 0], [10, 20], [25, 25], [40, 0], [55, -10], [70, 15.0]])),
    "unclamped spline": Spline([[0, 0], [10, 20], [25, 25], [40, 0], [55, -10]], np.arange(9.0)),
    "nurbs": NURBS,
    "rosette": Rosette(50, 11, 5, 0.2, 2.5),
}
MAPS = {
    "as drawn": [[1, 0, 0], [0, 1, 0]],
    "turned and larger": [[1.2, -1.6, 30], [1.6, 1.2, -4]],
    "mirrored": [[1, 0, 5], [0, -1, 9]],
    "skewed": [[1.5, 0.7, 0], [-0.2, 0.6, 100]],
}


def looked_at(segment, matrix):
    """Travel, places and the points that the map gives."""
    mapped = segment.transformed(matrix)
    return mapped, np.linspace(0.0, mapped.length, 41)


@pytest.mark.parametrize("chart", MAPS)
@pytest.mark.parametrize("name", SEGMENTS)
def test_length_is_the_integral_and_travel_is_inverted_to_a_nanometre(name, chart):
    mapped, s = looked_at(SEGMENTS[name], MAPS[chart])
    linear, shift = np.array(MAPS[chart])[:, :2], np.array(MAPS[chart])[:, 2]
    edges = np.concatenate(([0.0], mapped.breaks, [1.0]))
    # The speed of the curve as drawn, mapped: not what the mapped curve says of itself.
    speed = lambda u: np.hypot(*(linear @ SEGMENTS[name].derivative(np.array([u]), 1)[0]))  # noqa: E731
    parts = [quad(speed, a, b, epsabs=1e-11, epsrel=1e-12, limit=200)[0] for a, b in pairwise(edges)]
    assert mapped.length == pytest.approx(sum(parts), abs=1e-9)
    u, _ = mapped._parameter(s)
    for k in (1, 17, 33):
        inside = edges[(edges > 0) & (edges < u[k])]
        way = sum(
            quad(speed, a, b, epsabs=1e-11, epsrel=1e-12)[0]
            for a, b in zip([0.0, *inside], [*inside, u[k]], strict=True)
        )
        assert way == pytest.approx(s[k], abs=1e-9)
    drawn = SEGMENTS[name].derivative(u, 0) @ linear.T + shift
    places = mapped.at(s)
    np.testing.assert_allclose(np.column_stack((places.x, places.y)), drawn, atol=1e-9)


@pytest.mark.parametrize("name", SEGMENTS)
def test_a_segment_that_was_moved_and_is_then_turned_lies_where_its_points_do(name):
    u = np.array([0.0, 0.3, 1.0])
    linear, shift = np.array(MAPS["turned and larger"])[:, :2], np.array(MAPS["turned and larger"])[:, 2]
    moved = SEGMENTS[name].transformed(MAPS["skewed"])
    expected = moved.derivative(u, 0) @ linear.T + shift
    np.testing.assert_allclose(moved.transformed(MAPS["turned and larger"]).derivative(u, 0), expected, atol=1e-9)


@pytest.mark.parametrize("chart", MAPS)
@pytest.mark.parametrize("name", SEGMENTS)
def test_heading_is_the_direction_of_travel_and_curvature_its_change(name, chart):
    mapped, s = looked_at(SEGMENTS[name], MAPS[chart])
    h = 1e-4
    s = s[1:-1]
    before, here, after = mapped.at(s - h), mapped.at(s), mapped.at(s + h)
    slope = np.arctan2(after.y - before.y, after.x - before.x)
    np.testing.assert_allclose(np.cos(slope - np.radians(here.heading)), 1.0, atol=1e-10)
    np.testing.assert_allclose(np.hypot(after.x - before.x, after.y - before.y), 2 * h, rtol=1e-6)
    np.testing.assert_allclose(np.radians(after.heading - before.heading) / (2 * h), here.curvature, atol=2e-5)
    assert np.abs(np.diff(here.heading)).max() < 135, "the heading is unwrapped"


@pytest.mark.parametrize("name", SEGMENTS)
def test_reversed_and_part_are_the_same_points(name):
    segment = SEGMENTS[name]
    back = segment.reversed()
    s = np.linspace(0, segment.length, 9)
    there, returned = segment.at(s), back.at(segment.length - s)
    np.testing.assert_allclose([returned.x, returned.y], [there.x, there.y], atol=1e-9)
    np.testing.assert_allclose(np.cos(np.radians(returned.heading - there.heading)), -1.0, atol=1e-12)
    np.testing.assert_allclose(returned.curvature[1:-1], -there.curvature[1:-1], atol=1e-9)
    middle = segment.part(0.2, 0.7)
    assert segment.part(0.0, 0.2).length + middle.length + segment.part(0.7, 1.0).length == pytest.approx(
        segment.length, abs=1e-9
    )
    np.testing.assert_allclose([middle.start, middle.end], segment.derivative(np.array([0.2, 0.7]), 0), atol=1e-11)


def test_an_arc_mirrored_stays_an_arc_and_skewed_becomes_that_of_an_ellipse():
    arc = Arc((0, 0), 10, 0.0, math.pi / 2)
    mirrored = arc.transformed([[1, 0, 0], [0, -1, 0]])
    assert isinstance(mirrored, Arc)
    assert mirrored.sweep == pytest.approx(-math.pi / 2)
    assert mirrored.end == pytest.approx((0, -10))
    assert mirrored.at(0.0).curvature == pytest.approx(-0.1)
    wide = arc.transformed([[2, 0, 0], [0, 1, 0]])
    assert isinstance(wide, EllipseArc)
    # A quarter of an ellipse of half axes 20 and 10; curvature a / b^2 at the end of the long one.
    assert wide.length == pytest.approx(20 * ellipeinc(math.pi / 2, 1 - 10**2 / 20**2), rel=1e-13)
    assert wide.at([0.0, wide.length]).curvature == pytest.approx([20 / 10**2, 10 / 20**2])


def test_a_nurbs_is_the_circle_it_was_made_from():
    w = math.sqrt(0.5)
    quarter = Spline([[10, 0], [10, 10], [0, 10]], [0, 0, 0, 1, 1, 1], 2, [1, w, 1])
    assert quarter.length == pytest.approx(5 * math.pi, abs=1e-12)
    places = quarter.at(np.linspace(0, quarter.length, 7))
    np.testing.assert_allclose(np.hypot(places.x, places.y), 10, atol=1e-12)
    np.testing.assert_allclose(places.curvature, 0.1, atol=1e-12)
    np.testing.assert_allclose(places.heading, np.linspace(90, 180, 7), atol=1e-9)


@pytest.mark.parametrize(
    ("points", "first", "last"),
    [
        ([[0, 0], [0, 0], [10, 10], [20, 0]], 45, -45),
        ([[0, 0], [0, 0], [20, 10], [20, 10]], math.degrees(math.atan2(1, 2)), math.degrees(math.atan2(1, 2))),
        ([[0, 0], [0, 0], [0, 0], [0, 20]], 90, 90),
        ([[0, 0], [10, 0], [10, 10], [10, 10]], 0, 90),
    ],
)
def test_where_control_points_coincide_the_tangent_is_that_of_the_next_one(points, first, last):
    curve = Bezier(points)
    assert curve.headings == pytest.approx((first, last), abs=1e-9)
    places = curve.at(np.linspace(0, curve.length, 11))
    assert all(np.isfinite(row).all() for row in places)
    chord = np.hypot(np.diff(places.x), np.diff(places.y))
    assert (chord <= curve.length / 10 + 1e-9).all() and chord.min() > 0.05 * curve.length


def test_a_cusp_cuts_a_curve_in_two():
    # x' = 30 (1 - 2u)^2 and y' = 30 (1 - 2u): both vanish at u = 1/2, where y' changes its sign.
    curve = Bezier([[0, 0], [10, 10], [0, 10], [10, 0]])
    left, right = curve.pieces()
    assert left.end == right.start == pytest.approx((5, 7.5))
    assert left.headings[1] == pytest.approx(90)
    assert right.headings[0] == pytest.approx(-90)
    assert left.length == pytest.approx(right.length)
    back = Bezier([[0, 0], [30, 0], [-10, 0], [20, 0]])
    assert len(back.pieces()) == 3
    assert [p.headings[0] % 360 for p in back.pieces()] == pytest.approx([0, 180, 0])
    # x' = 30 (3 - 14 u + 14 u^2): how far it runs to its roots.
    roots = np.sort(np.roots([14, -14, 3]))
    way = np.abs(np.diff(np.polyval([140, -210, 90, 0], [0, *roots, 1])))
    assert [p.length for p in back.pieces()] == pytest.approx(way, abs=1e-9)


def test_a_knot_of_full_multiplicity_cuts_a_spline_at_its_corner():
    points = [[0, 0], [1, 2], [3, 3], [4, 0], [6, 1], [7, 2], [9, 0]]
    for weights in (None, [1, 2, 1, 3, 1, 1, 1]):
        spline = Spline(points, np.array([0, 0, 0, 0, 1, 1, 1, 2.2, 2.2, 2.2, 2.2]) / 3.0, 3, weights)
        left, right = spline.pieces()
        assert left.end == pytest.approx((4, 0)) and right.start == pytest.approx((4, 0))
        assert left.headings[1] == pytest.approx(math.degrees(math.atan2(-3, 1)))
        assert right.headings[0] == pytest.approx(math.degrees(math.atan2(1, 2)))
        assert left.length + right.length == pytest.approx(spline.length, abs=1e-11)


finite = st.floats(-80, 80).map(lambda v: round(v, 2))


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(finite, finite), min_size=4, max_size=4), st.floats(0.05, 0.95))
def test_any_cubic_is_followed_at_unit_speed_between_its_corners(points, share):
    curve = Bezier(points)
    for piece in curve.pieces():
        if piece.length < 1.0:
            continue
        s = share * piece.length
        before, here, after = piece.at(s - 1e-3), piece.at(s), piece.at(s + 1e-3)
        if abs(here.curvature) > 1.0 or abs(before.curvature - after.curvature) > 0.01:
            continue
        assert math.hypot(after.x - before.x, after.y - before.y) == pytest.approx(2e-3, rel=1e-6)
        slope = math.degrees(math.atan2(after.y - before.y, after.x - before.x))
        assert math.cos(math.radians(slope - here.heading)) == pytest.approx(1, abs=1e-9)
        assert math.radians(after.heading - before.heading) / 2e-3 == pytest.approx(float(here.curvature), abs=1e-4)
    # The length lies between that of the chord and that of the polygon.
    p = np.array(points)
    polygon = np.hypot(*np.diff(p, axis=0).T).sum()
    assert math.dist(p[0], p[-1]) - 1e-9 <= curve.length <= polygon + 1e-9


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Line((0, math.nan), (1, 1)), "first point of a line"),
        (lambda: Arc((0, 0), 0.0, 0, 1), "radius"),
        (lambda: Bezier([[0, 0], [1, math.inf]]), "finite"),
        (lambda: Spline([[0, 0], [1, 1]], [0, 0, 1, 1], 3), "expected 4 or more"),
        (lambda: Spline([[0, 0], [1, 1]], [0, 1, 0, 1], 1), "rising order"),
        (lambda: Spline([[0, 0], [1, 1]], [0, 0, 1, 1], 1, [1, 0]), "weights above 0"),
        (lambda: Spline([[0, 0], [1, 1]], [1, 1, 1, 1], 1), "all equal"),
        (lambda: Line((0, 0), (1, 1)).transformed([[1, 0], [0, 1]]), "2 x 3"),
        (lambda: EllipseArc((0, 0), (1, 0), (0, math.nan), 0, 1), "second"),
    ],
)
def test_numbers_that_make_no_curve_are_refused(make, text):
    with pytest.raises(ValueRefused, match=text):
        make()
