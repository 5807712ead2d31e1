"""What a program says, read by its letters alone: its moves against the drawn line, the blade against its moves."""

import math
import re
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial import KDTree

from leadscrew.paths import shapes
from leadscrew.paths.path import Path, polyline
from leadscrew.paths.segments import Arc, EllipseArc, Line
from leadscrew.tangent.emit import program
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke, Table, strokes_of

WORD = re.compile(r"([A-Z])(-?[\d.]+)")


class Move(NamedTuple):
    """A cutting move of a program, in its own units."""

    x: np.ndarray
    """Nine places along it."""
    y: np.ndarray
    tangent: np.ndarray
    """Of the line that the machine takes, deg, there."""
    blade: np.ndarray
    """What the axis reads there."""
    length: float
    feed: float
    minutes: bool


def cut_by(text):
    """The moves, worked out anew: words in force, arcs about I and J, the axis turning evenly."""
    now: dict[str, float] = {}
    found, minutes = [], False
    share = np.linspace(0.0, 1.0, 9)
    for line in text.splitlines():
        minutes = (minutes or line == "G93") and line != "G94"
        words = {k: float(v) for k, v in WORD.findall(re.sub(r"\(.*?\)", "", line))}
        before = dict(now)
        now |= words
        if words.get("G") not in (1.0, 2.0, 3.0) or "X" not in words:
            continue
        (x, y), (u, v) = ((d["X"], d["Y"]) for d in (before, now))
        if words["G"] == 1.0:
            length = math.hypot(u - x, v - y)
            tangent = np.full(9, math.degrees(math.atan2(v - y, u - x)))
            px, py = x + share * (u - x), y + share * (v - y)
        else:
            i, j, sign = words["I"], words["J"], 1.0 if words["G"] == 3.0 else -1.0
            first = math.atan2(-j, -i)
            angle = first + share * sign * (sign * (math.atan2(v - y - j, u - x - i) - first) % (2.0 * math.pi))
            radius = math.hypot(i, j)
            assert math.hypot(u - x - i, v - y - j) == pytest.approx(radius, abs=3e-4)
            px, py, length = x + i + radius * np.cos(angle), y + j + radius * np.sin(angle), radius * abs(np.ptp(angle))
            tangent = np.degrees(angle) + sign * 90.0
        blade = before["C"] + share * (now["C"] - before["C"])
        found.append(Move(px, py, tangent, blade, length, now["F"], minutes))
    return found


def apart(a, b):
    """Largest difference of angles, deg."""
    return np.abs((a - b + 180.0) % 360.0 - 180.0).max()


def ellipse(a, b):
    return Path([EllipseArc((0.0, 0.0), (a, 0.0), (0.0, b), 0.0, 2.0 * math.pi)], closed=True)


def rounded(size, radius, first=0):
    """A square with rounded corners that begins with one of its eight segments."""
    parts = []
    for k in range(4):
        t = 0.5 * math.pi * k
        a, b = (
            (c * math.cos(t) - d * math.sin(t), c * math.sin(t) + d * math.cos(t))
            for c, d in ((radius - size, -size), (size - radius, -size))
        )
        centre = (b[0] - radius * math.sin(t), b[1] + radius * math.cos(t))
        parts += [Line(a, b), Arc(centre, radius, t - 0.5 * math.pi, 0.5 * math.pi)]
    return Path([*parts[first:], *parts[:first]], closed=True)


CURVES = {"wave": shapes.wave, "ellipse": lambda: ellipse(30.0, 10.0), "flower": shapes.flower}


@pytest.mark.parametrize("name", [pytest.param(c, marks=() if c == "ellipse" else pytest.mark.slow) for c in CURVES])
@pytest.mark.parametrize("values", [{}, {"tolerance": 0.002, "angle_tolerance": 0.5}])
def test_the_blade_follows_its_own_moves_and_these_the_curve(name, values):
    """With chords the blade was up to 4.2 deg off its own move on this ellipse."""
    settings, path = Settings(**values), CURVES[name]()
    moves = cut_by(program(strokes_of([path], settings), settings))
    dense = path.at(np.linspace(0.0, path.length * (1.0 - 1e-12), 40000))
    tree = KDTree(np.column_stack((dense.x, dense.y)))
    for move in moves:
        assert apart(move.blade, move.tangent) < settings.angle_tolerance
        _, k = tree.query(np.column_stack((move.x, move.y)))
        angle = np.radians(dense.heading[k])
        across = (move.y - dense.y[k]) * np.cos(angle) - (move.x - dense.x[k]) * np.sin(angle)
        assert np.abs(across).max() < 1.02 * settings.tolerance + 1e-4
        # Neighbours of the 40,000 places differ by some 0.1 deg where it bends most.
        assert apart(dense.heading[k], move.tangent) < settings.angle_tolerance + 0.06
    assert sum(m.length for m in moves) == pytest.approx(path.length, rel=1e-5)


def test_a_finer_angle_costs_moves_and_a_coarse_one_saves_them():
    counts = [
        len(cut_by(program(strokes_of([ellipse(30.0, 10.0)], s), s)))
        for s in (Settings(angle_tolerance=v) for v in (0.02, 0.1, 1.0))
    ]
    assert counts[0] > 1.5 * counts[1] > 3.0 * counts[2]


@pytest.mark.parametrize("inch", [False, True])
@pytest.mark.parametrize("inverse_time", [False, True])
@pytest.mark.parametrize(
    "path", [ellipse(30.0, 10.0), ellipse(0.3, 0.1), rounded(10.0, 0.3)], ids=["", "tiny", "fillet"]
)
def test_no_move_as_written_turns_the_blade_faster_than_it_can(inch, inverse_time, path):
    """By up to 11 % it was, where the feed was taken from the arc length and the move was its chord."""
    settings = Settings(swivel=90.0, inch=inch, inverse_time=inverse_time)
    rates = []
    for move in cut_by(program(strokes_of([path], settings), settings)):
        minutes = 1.0 / move.feed if move.minutes else move.length / move.feed
        rates.append(np.ptp(move.blade) / (60.0 * minutes))
    assert 89.5 < max(rates) < 90.0 * (1.0 + 1e-5)


@pytest.mark.parametrize("first", range(0, 8, 3))
def test_a_rounding_that_a_sharp_corner_is_to_the_tolerance_lifts_the_knife(first):
    """3 um: the blade turned by 90 deg at depth, over 4.2 um."""
    text = program(strokes_of([rounded(20.0, 0.003, first)], Settings()), Settings())
    moves = cut_by(text)
    assert text.count("\nG1 Z-1 ") == 4 and len(moves) in (4, 5)
    assert all(np.ptp(m.blade) == 0.0 for m in moves)
    assert sum(m.length for m in moves) == pytest.approx(160.0, abs=1e-3)


def test_a_rounding_of_two_arcs_does_so_too_and_a_larger_one_is_cut_as_drawn():
    quarter = math.pi / 2.0
    for radius, strokes in ((0.02, 2), (0.03, 1)):
        arcs = [Arc((20.0, radius), radius, k * quarter / 2.0 - quarter, quarter / 2.0) for k in (0, 1)]
        path = Path([Line((0.0, 0.0), (20.0, 0.0)), *arcs, Line(arcs[1].end, (20.0 + radius, 20.0))])
        assert len(strokes_of([path], Settings())) == strokes


def test_a_small_hole_of_many_sides_is_no_row_of_corners():
    angles = np.linspace(0.0, 2.0 * math.pi, 97)[:-1]
    hole = polyline(0.4 * np.column_stack((np.cos(angles), np.sin(angles))), closed=True)
    assert len(strokes_of([hole], Settings())) == 1


def test_a_corner_at_the_corner_angle_itself_is_turned_in_the_material_however_the_drawing_lies():
    for turn in np.radians(np.arange(0.0, 360.0, 7.0)):
        c, s = math.cos(turn), math.sin(turn)
        bent = np.array([[0.0, 0.0], [20.0, 0.0], [20.0 + 20.0 * math.cos(math.pi / 9), 20.0 * math.sin(math.pi / 9)]])
        path = polyline(bent @ np.array([[c, s], [-s, c]]))
        assert len(strokes_of([path], Settings(corner_angle=20.0))) == 1
        assert len(strokes_of([path], Settings(corner_angle=19.999))) == 2


@pytest.mark.parametrize(
    ("tolerance", "inch", "word"),
    [(1e-4, True, "P0.000003937"), (1e-4, False, "P0.0001"), (0.00025, False, "P0.00025"), (0.0254, True, "P0.001")],
)
def test_a_small_tolerance_is_written_and_never_as_nothing(tolerance, inch, word):
    settings = Settings(tolerance=tolerance, inch=inch)
    line = Path([Line((0.0, 0.0), (10.0, 0.0))])
    assert f"\nG64 {word}\n" in program(strokes_of([line], settings), settings)


def test_offsets_turn_the_blade_off_a_curve_s_moves_by_just_themselves():
    (stroke,) = strokes_of([ellipse(30.0, 10.0)], Settings())
    s = stroke.grid(0.5)
    turned = Stroke(stroke.path, stroke.length, table=Table(s, 5.0 * np.sin(s / 9.0)))
    moves = cut_by(program([turned], Settings()))
    place = np.cumsum([m.length for m in moves])
    asked = turned.offset(np.minimum(place, turned.length))
    given = np.array([(m.blade[-1] - m.tangent[-1] + 180.0) % 360.0 - 180.0 for m in moves])
    assert np.abs(given - asked).max() < 0.15 and np.abs(given).max() > 4.9
