"""Paths of G-code programs, written here, against geometry by hand."""

import math

import numpy as np
import pytest

from leadscrew.paths.gcode import paths_of_gcode
from leadscrew.paths.read import read_drawing
from leadscrew.paths.shapes import rounded_rectangle
from leadscrew.references._gcode import segments_from_gcode
from leadscrew.references._gcode_reader import Dialect, moves_from_gcode
from leadscrew.tangent.emit import program as written
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import strokes_of
from leadscrew.util.errors import DataError, ValueRefused

PROGRAM = """%
G21 G90 G64 P0.01 (a knife)
M3 S1000 T1
G0 Z5
G0 X10 Y0 A90
G1 Z-1 F100
G1 X20
A45
G1 X20 Y10 A45
G3 X10 Y20 I-10 J0 A180
G1 X10 Y20
G1 Z5
G1 X0 Y0
G1 Z-1
G5 I10 J0 P0 Q-10 X30 Y30
G5 P-10 Q0 X60 Y60
G0 Z5
M30
"""


def test_a_path_is_what_is_cut_between_lifts_and_keeps_its_tangential_words(tmp_path):
    (tmp_path / "p.ngc").write_text(PROGRAM)
    drawing = read_drawing(tmp_path / "p.ngc")
    first, second = drawing.paths
    assert first.length == pytest.approx(20 + 5 * math.pi) and second.corners == []
    assert [round(c.turn_deg) for c in first.corners] == [90]
    words = drawing.programmed[0]
    np.testing.assert_allclose(words.angle, [[90, 90], [45, 45], [45, 180]])
    np.testing.assert_allclose(words.travel, [[0, 10], [10, 20], [20, 20 + 5 * math.pi]])
    assert drawing.notes == (
        "without effect on the path: 1 G64, 1 M3, 1 S1000, 1 T1",
        "1 segment of no length left out",
    )
    # The cubic from (0, 0) leaves along x and arrives along y; the next leaves as it arrived.
    np.testing.assert_allclose(second.at([0.0, second.length / 2, second.length]).heading, [0, 90, 0], atol=1e-9)


def test_inches_increments_and_the_unit_given_agree():
    metric = paths_of_gcode("G21\nG1 F9 X50.8 Y25.4\nG2 X76.2 Y0 I0 J-25.4\nG1 X0 Y0")
    for program, unit in (
        ("G20\nG1 F9 X2 Y1\nG2 X3 Y0 I0 J-1\nG1 X0 Y0", None),
        ("G1 F9 X2 Y1\nG2 X3 Y0 I0 J-1\nG1 X0 Y0", "in"),
        ("G20 G91\nG1 F9 X2 Y1\nG2 X1 Y-1 R1\nG1 X-3", None),
    ):
        drawing = paths_of_gcode(program, unit)
        (path,) = drawing.paths
        assert drawing.unit == "in"
        assert path.length == pytest.approx(metric.paths[0].length, abs=1e-9)
        assert path.closed
    assert metric.programmed == (None,)


def test_inverse_time_changes_no_path():
    feeds = "G21 G90 G94\nG0 X1\nG1 X11 F600\nG2 X21 Y0 I5 J0 F300\nG0 X0"
    times = "G21 G90\nG0 X1\nG93 G1 X11 F60\nG2 X21 Y0 I5 J0 F19.1\nG94\nG0 X0"
    one, other = paths_of_gcode(feeds), paths_of_gcode(times)
    assert one.length == other.length == pytest.approx(10 + 5 * math.pi)
    passive = Dialect(passive=True, inverse_time=True)
    rapid, line, arc, back = moves_from_gcode(times, dialect=passive)
    assert (line.per_minute, line.feed) == (60.0, 0.0) and (arc.per_minute, rapid.per_minute) == (19.1, 0.0)
    assert back.per_minute == 0.0
    # Which F was of which kind does not carry over.
    assert moves_from_gcode("G1 F600 X1\nG93 X2 F6\nG94 X3", dialect=passive)[-1].feed == 0.0
    with pytest.raises(DataError, match=r"line 2: G1 without F in inverse time \(G93\)"):
        paths_of_gcode("G93 G1 X1 F6\nX2")
    with pytest.raises(DataError, match="G94 contradicts"):
        paths_of_gcode("G93 G94 G1 X1 F6")


def test_our_own_program_in_inverse_time_is_read_back(tmp_path):
    shape = rounded_rectangle()
    s = Settings(inverse_time=True)
    text = written(strokes_of([shape], s), s)
    assert "G93" in text
    (path,) = paths_of_gcode(text).paths
    assert path.length == pytest.approx(shape.length, rel=1e-4)


def test_rapids_end_a_path_where_the_program_has_no_z():
    drawing = paths_of_gcode("G1 F9 X10\nG0 Y5\nG1 X0\nG0 X-5\nY2")
    assert [p.length for p in drawing.paths] == pytest.approx([10, 10])
    assert [p.name for p in drawing.paths] == ["line 1", "line 3"]


def test_several_passes_are_paths_of_their_own():
    drawing = paths_of_gcode("G0 Z5\nG0 X1\nG1 F9 Z-1\nX10\nG1 Z-2\nX1\nG0 Z5\nX0\nZ50")
    assert [p.length for p in drawing.paths] == pytest.approx([9, 9])


def test_a_pass_half_way_between_the_sheet_and_the_deepest_one_is_cut():
    passes = "G1 F9 Z0\nG1 X30\nG1 Z-1\nG1 X20\nG1 Z0\nG1 X0\nG1 Z-2\nG1 X10\nG1 Z0\nG1 X0"
    drawing = paths_of_gcode(f"G21\n{passes}\n")
    assert [(path.segments[0].start[0], path.segments[-1].end[0]) for path in drawing.paths] == [(30, 20), (0, 10)]


def test_a_helix_and_a_full_circle_are_seen_from_above():
    (path,) = paths_of_gcode("G0 X10\nG2 F9 X10 Y0 I-10").paths
    assert path.closed and path.turn == pytest.approx(-360) and path.length == pytest.approx(20 * math.pi)


@pytest.mark.parametrize(
    ("program", "options", "text"),
    [
        ("G1 F9 X1\nG2 X5", {}, "line 2: G2 needs the centre"),
        ("G1 F9 X1 U5", {}, "line 1: U5 is not understood"),
        ("G18 G1 X1", {}, "G18 is not understood; known: G4, G17"),
        ("G5 X1 Y1 I1 J1", {}, "G5 needs P and Q"),
        ("G5 X1 Y1 P1 Q1", {}, "the first G5 needs I and J"),
        ("G5 X1 Y1 Z1 I1 J1 P1 Q1", {}, "stays in XY"),
        ("G1 X1 A5\nX2 B7", {}, "turns A, B: say which one is the tangential axis"),
        ("G0 X1\nG0 X5", {}, "there is nothing to cut in G-code: no feed moves X or Y"),
        ("", {}, "nothing to cut"),
        ("G1 X1 X2", {}, "a second X"),
        ("G1 X" + "9" * 400, {}, r"line 1: X99999999999\.\.\. is beyond any number"),
    ],
)
def test_what_is_not_understood_is_refused_by_line_and_word(program, options, text):
    with pytest.raises(DataError, match=text):
        paths_of_gcode(program, **options)


def test_the_axis_is_chosen_and_checked():
    program = "G1 X1 A5\nX2 B7"
    np.testing.assert_allclose(paths_of_gcode(program, axis="B").programmed[0].angle, [[0, 0], [0, 7]])
    with pytest.raises(ValueRefused, match="expected A, B or C"):
        paths_of_gcode(program, axis="U")


def test_the_reference_block_still_refuses_what_it_cannot_run():
    for program, word in (("G1 F9 X1 A5", "A5"), ("G5 I1 J1 P1 Q1 X2", "G5"), ("G1 F9 X1\nM3", "M3")):
        with pytest.raises(DataError, match=f"{word} is not understood"):
            segments_from_gcode(program)


def test_inch_and_in_are_one_unit():
    assert paths_of_gcode("G1 X1", "inch").length == paths_of_gcode("G1 X1", "in").length == pytest.approx(25.4)
    with pytest.raises(ValueRefused, match="unit = 'inches': expected one of mm, cm, m, in, px"):
        paths_of_gcode("G1 X1", "inches")


def test_a_folder_is_called_one(tmp_path):
    (tmp_path / "fold.ngc").mkdir()
    with pytest.raises(DataError, match=r"fold\.ngc' is a folder, not a file"):
        read_drawing(tmp_path / "fold.ngc")


def test_a_file_that_is_not_text_is_refused(tmp_path):
    (tmp_path / "p.nc").write_bytes(b"\xff\xfe\x80")
    with pytest.raises(DataError, match="is not UTF-8 text"):
        read_drawing(tmp_path / "p.nc")
    with pytest.raises(ValueRefused, match="G-code has no layers"):
        read_drawing(tmp_path / "p.nc", layers=["CUT"])
