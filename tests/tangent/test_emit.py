"""G-code for a tangential knife: moves and words by hand, headings against differences of points, corners, feeds."""

import math
import re

import numpy as np
import pytest

from leadscrew.paths import shapes
from leadscrew.paths.path import Path, polyline
from leadscrew.paths.segments import Arc, Line
from leadscrew.tangent.emit import program
from leadscrew.tangent.moves import moves_of
from leadscrew.tangent.program import program_of
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke, Table, strokes_of
from leadscrew.util.errors import DataError, ValueRefused

CUTTING = re.compile(r"^G[0-3] ")


def lines_of(paths, settings=None):
    """Lines that move."""
    settings = settings or Settings()
    return [x for x in program(strokes_of(paths, settings), settings).splitlines() if CUTTING.match(x)]


def hook():
    """A line, and a quarter of a circle to the left."""
    return Path([Line((0.0, 0.0), (10.0, 0.0)), Arc((10.0, 5.0), 5.0, -0.5 * math.pi, 0.5 * math.pi)])


def test_a_line_and_an_arc_are_the_moves_worked_by_hand():
    assert lines_of([hook()]) == [
        "G0 Z5",
        "G0 X0 Y0 C0",
        "G1 Z-1 F600",
        "G1 X10 Y0 C0 F3000",
        "G3 X15 Y5 I0 J5 C90",
        "G0 Z5",
    ]


def test_inches_an_a_axis_that_counts_clockwise_and_its_zero_are_at_the_edge_alone():
    settings = Settings(
        axis="A", clockwise=True, zero=90.0, inch=True, lift=25.4, depth=-2.54, feed=2540.0, plunge=254.0
    )
    assert lines_of([hook()], settings) == [
        "G0 Z1",
        "G0 X0 Y0 A90",
        "G1 Z-0.1 F10",
        "G1 X0.3937 Y0 A90 F100",
        "G3 X0.59055 Y0.19685 I0 J0.19685 A0",
        "G0 Z1",
    ]


def test_in_inverse_time_f_is_one_by_the_minutes_of_each_move():
    found = lines_of([hook()], Settings(inverse_time=True))
    assert found[3].endswith(" F300")
    assert float(found[4].split("F")[1]) == pytest.approx(3000.0 / (2.5 * math.pi), rel=1e-5)


def test_a_square_is_lifted_turned_and_plunged_at_each_corner():
    found = lines_of([polyline(np.array([[0, 0], [20, 0], [20, 20], [0, 20]]), closed=True)])
    assert [x for x in found if x.startswith("G0 X")] == [
        "G0 X0 Y0 C0", "G0 X20 Y0 C90", "G0 X20 Y20 C180", "G0 X0 Y20 C270",
    ]  # fmt: skip
    assert sum(x.startswith("G1 Z-1") for x in found) == 4
    assert found[-2] == "G1 X0 Y0 C270 F3000"


def test_a_closed_line_that_begins_elsewhere_begins_at_its_corner_and_is_cut_once():
    drop = Path(
        [
            Line((10.0, 0.0), (20.0, 0.0)),
            Arc((20.0, 5.0), 5.0, -0.5 * math.pi, math.pi),
            Line((20.0, 10.0), (0.0, 0.0)),
            Line((0.0, 0.0), (10.0, 0.0)),
        ],
        closed=True,
    )
    strokes = strokes_of([drop], Settings(corner_angle=100.0))
    assert [s.length for s in strokes] == pytest.approx([drop.length])
    assert (strokes[0].path.segments[0].start) == (0.0, 0.0)


def test_a_small_corner_is_turned_over_the_blend_and_the_blade_is_half_way_at_it():
    bent = polyline(np.array([[0.0, 0.0], [20.0, 0.0], [20.0 + 20.0 * math.cos(0.2), 20.0 * math.sin(0.2)]]))
    (stroke,) = strokes_of([bent], Settings(blend=4.0))
    heading = stroke.at([17.9, 19.0, 20.0, 21.0, 22.1]).heading
    assert heading == pytest.approx(np.degrees([0.0, 0.05, 0.1, 0.15, 0.2]), abs=1e-9)
    assert stroke.at(20.5).curvature == pytest.approx(0.05)
    assert len(strokes_of([bent], Settings(corner_angle=11.0))) == 2


def test_an_edge_of_a_polygon_shorter_than_the_blend_is_shared_by_its_corners():
    angles = np.linspace(0.0, math.pi, 41)
    half = polyline(20.0 * np.column_stack((np.cos(angles), np.sin(angles))))
    (stroke,) = strokes_of([half], Settings(blend=5.0))
    s = stroke.grid(0.1)
    heading = stroke.at(s).heading
    assert (np.diff(heading) >= -1e-9).all()
    assert np.abs(heading - (90.0 + np.degrees(s / 20.0))).max() < 3.0


@pytest.mark.parametrize("shape", [shapes.wave, pytest.param(shapes.flower, marks=pytest.mark.slow)])
def test_words_are_the_tangent_of_the_curve_itself(shape):
    path, settings = shape(), Settings()
    for move in moves_of(strokes_of([path], settings)[0], settings)[::7]:
        ahead, behind = (path.at(min(max(move.last + d, 0.0), path.length)) for d in (1e-4, -1e-4))
        slope = math.degrees(math.atan2(float(ahead.y - behind.y), float(ahead.x - behind.x)))
        assert (move.angle - slope + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.01)


def test_words_run_on_beyond_a_turn_and_begin_at_the_nearest():
    settings = Settings(start_angle=700.0)
    rows = lines_of([shapes.flower()], settings)
    words = [float(x.split("C")[1].split()[0]) for x in rows if "C" in x]
    assert words[0] == 810.0 and words[-1] == 1170.0
    assert np.abs(np.diff(words)).max() < 30.0


def test_an_offset_is_in_the_words_and_said_beside_them():
    stroke = strokes_of([hook()], Settings())[0]
    shifted = Stroke(stroke.path, stroke.length, table=Table(np.array([0.0, 10.0, 20.0]), np.array([0.0, 5.0, 5.0])))
    text = program([shifted], Settings())
    assert "G1 X10 Y0 C5 F3000 (d 5)" in text and "C95 (d 5)" in text and "(offsets: compensated)" in text


def test_the_feed_is_lowered_to_what_the_blade_can_turn():
    settings = Settings(swivel=100.0)
    rows = lines_of([shapes.rounded_rectangle()], settings)
    arcs = [x for x in rows if x.startswith("G3")]
    # 90 deg in 5 pi mm at 100 deg/s: 0.9 s.
    assert float(arcs[0].split("F")[1]) == pytest.approx(60.0 * 5.0 * math.pi / 0.9, abs=0.1)
    assert all(m.feed <= 60.0 * 100.0 * m.length / abs(m.turn) + 1e-9
               for m in moves_of(strokes_of([shapes.flower()], settings)[0], settings))  # fmt: skip


def test_overcut_goes_on_beyond_the_start_of_a_closed_line():
    settings = Settings(overcut=3.0)
    (stroke,) = strokes_of([shapes.rounded_rectangle()], settings)
    rows = lines_of([shapes.rounded_rectangle()], settings)
    assert stroke.length == pytest.approx(stroke.path.length + 3.0)
    assert rows[-2] == "G1 X13 Y0 C360"
    assert strokes_of([hook()], settings)[0].length == pytest.approx(hook().length)


def test_a_full_circle_is_cut_in_arcs_that_their_ends_tell_apart():
    rows = [x for x in lines_of([Path([Arc((0.0, 0.0), 10.0, 0.0, -2.0 * math.pi)], closed=True)]) if x[:2] == "G2"]
    assert len(rows) == 4 and rows[-1].startswith("G2 X10 Y0 ")
    assert [float(x.split("C")[1].split()[0]) for x in rows] == [-180.0, -270.0, -360.0, -450.0]


def test_marks_are_pricked_before_the_cut_and_are_no_strokes():
    settings = Settings(pricks="-5,2.5 80,-3")
    rows = lines_of([hook()], settings)
    assert rows[:8] == [
        "G0 Z5", "G0 X-5 Y2.5", "G1 Z-1 F600", "G0 Z5", "G0 X80 Y-3", "G1 Z-1 F600", "G0 Z5", "G0 X0 Y0 C0",
    ]  # fmt: skip
    found = program_of(program(strokes_of([hook()], settings), settings))
    assert len(found.strokes) == 1 and found.settings.places() == [(-5.0, 2.5), (80.0, -3.0)]


def test_the_same_drawing_makes_the_same_file():
    texts = {program(strokes_of([shapes.rounded_rectangle()], Settings()), Settings(), ["a (b) ü"]) for _ in range(2)}
    assert len(texts) == 1 and "(a [b] ?)" in texts.pop()


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"axis": "B"}, "axis = 'B': expected C or A"),
        ({"feed": 0.0}, "feed = 0: allowed range is 1 to 1e"),
        ({"feed": math.nan}, "feed = nan: allowed range"),
        ({"lift": -1.0}, "depth = -1: expected less than lift, -1 mm"),
        ({"pricks": "1,2 3"}, "prick 3: expected X,Y, two numbers in mm"),
        ({"tolerance": 0.0}, "tolerance = 0: allowed range is 0.0001 to 1 mm"),
    ],
)
def test_settings_out_of_range_are_refused_with_the_range(values, why):
    with pytest.raises(ValueRefused) as refused:
        Settings(**values)
    assert why in str(refused.value)


def test_a_drawing_of_points_has_nothing_to_cut():
    with pytest.raises(DataError, match="no line to cut"):
        strokes_of([polyline(np.array([[0.0, 0.0], [5e-4, 0.0]]))], Settings())
