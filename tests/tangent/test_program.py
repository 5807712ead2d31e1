"""Programs read back: ours to rounding, and those of other people by what they say."""

import math

import numpy as np
import pytest

from leadscrew.paths import shapes
from leadscrew.paths.gcode import paths_of_gcode
from leadscrew.tangent.emit import program
from leadscrew.tangent.interpreter import read_moves
from leadscrew.tangent.program import program_of
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke, Table, strokes_of
from leadscrew.util.errors import DataError, ValueRefused

VARIANTS = {
    "plain": Settings(angle_tolerance=0.1),
    "inch, clockwise": Settings(inch=True, clockwise=True, zero=90.0, axis="A", inverse_time=True, angle_tolerance=0.1),
}


@pytest.mark.parametrize("settings", VARIANTS.values(), ids=VARIANTS)
@pytest.mark.parametrize(
    "shape",
    [*(pytest.param(s, marks=pytest.mark.slow) for s in (shapes.wave, shapes.flower)), shapes.rounded_rectangle],
)
def test_a_program_of_ours_is_read_back_with_its_line_its_headings_and_its_offsets(shape, settings):
    (stroke,) = strokes_of([shape()], settings)
    s = stroke.grid(0.5)
    offsets = 4.0 * np.sin(s / 20.0)
    written = Stroke(stroke.path, stroke.length, stroke.bends, table=Table(s, offsets))
    found = program_of(program([written], settings))
    assert found.settings == settings and found.ours
    (read,) = found.strokes
    shared = np.linspace(0.0, min(read.length, stroke.length), 1500)
    a, b = stroke.at(shared), read.at(shared)
    assert read.length == pytest.approx(stroke.length, rel=2e-4)
    assert np.hypot(a.x - b.x, a.y - b.y).max() < 0.03
    turns = a.heading - b.heading
    assert np.abs(turns - 360.0 * np.round(turns / 360.0)).max() < 0.5
    assert np.abs(read.offset(shared) - 4.0 * np.sin(shared / 20.0)).max() < 0.15


def test_parts_of_an_arc_and_of_a_line_become_one_again():
    settings = Settings()
    (stroke,) = strokes_of([shapes.rounded_rectangle()], settings)
    s = stroke.grid(0.5)
    cut = program([Stroke(stroke.path, stroke.length, table=Table(s, 5.0 * np.sin(s / 7.0)))], settings)
    assert cut.count("G3") > 12
    (read,) = program_of(cut).strokes
    assert len(read.path.segments) == 8 and read.path.closed


OTHERS = """
G21 G90 G64 P0.05 M3 S1000
G0 X0 Y0 Z10 A90
G1 Z-2 F500
N10 G1 X10 A90 F1200
A0
G1 Y-5
G3 X15 Y-10 R5 A90 (hard)
G0 Z10
M5
M30
"""


def test_a_program_of_others_is_read_by_its_words():
    found = program_of(OTHERS, "theirs.ngc", zero=-90.0)
    assert not found.ours and found.passed == ["line 2: M3", "line 2: S1000", "line 10: M5"]
    (stroke,) = found.strokes
    assert stroke.length == pytest.approx(15.0 + 2.5 * math.pi)
    # Turned on the spot: over the millimetres before the corner.
    assert stroke.at([1.0, 7.9, 9.0, 10.0, 14.9]).heading == pytest.approx([0.0, 0.0, -45.0, -90.0, -90.0])
    assert stroke.at(15.0 + 1.25 * math.pi).heading == pytest.approx(-45.0)
    assert found.settings.depth == -2.0 and found.settings.lift == 10.0 and found.settings.feed == 1200.0


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("G1 X1 F100 G28", "line 1: G28 is not understood; known: "),
        ("G21\nG1 X1", "line 2: G1 without a feed: F is missing"),
        ("G93 G1 X1 F10 C0\nX2", "line 2: G1 without F in inverse time \\(G93\\)"),
        ("G1 X10 F100", "has no words of a tangential axis"),
        ("G1 X10 C0 A0 F100", "has words for A and for C"),
        ("G0 X10 C0", "nothing is cut"),
        ("G1 X10 C0 F100\nG2 X20 I3 C5", "line 2: G2: the radius is 3 mm at the start of the arc and 7 mm at its end"),
        ("G2 X10 C0 F100", "line 1: G2 needs the centre, I and J, or the radius, R"),
        ("G0 C90\nG1 X10 F100", "line 2: the blade stands at 90 deg to its move"),
        ("G1 X#1 F100", "line 1: cannot read 'X#1F100'"),
        ("X10 F100", "line 1: X10: no G0, G1, G2 or G3 is in force"),
        ("G1 X1 X2 F100", "a second X on this line"),
        ("G1 X10 C0 F100 (open", "a comment is not closed"),
        ("", "the program does not move"),
    ],
)
def test_what_cannot_be_read_is_refused_by_line_and_word(text, why):
    with pytest.raises(DataError, match=why):
        program_of(text, "their.ngc")


def cut_of(body, head="G21 G90 G64 P0.02\nG0 Z5\nG0 X0 Y0 C0\n", tail="\nG0 Z5\nM2"):
    return program_of(head + body + tail, "their.ngc")


def test_a_program_that_a_new_one_cuts_as_well_keeps_its_plunge_its_rounding_and_its_lift():
    found = cut_of("G1 Z-1 F150\nG1 X100 C0 F1000\nG0 Z5\nG0 X0 Y20\nG0 Z1\nG1 Z-2 F90\nG1 X100 F1000")
    assert found.lost == [] and found.passed == []
    assert found.settings.plunge == 90.0 and found.settings.tolerance == 0.02 and found.settings.lift == 5.0
    assert [s.depth for s in found.strokes] == [-1.0, -2.0] and "several feeds" in found.changed[0]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("G21 G90\nG0 X0 Y0 C0\nG1 X100 C0 F1000", "has no Z word"),
        ("G21 G90\nG0 X0 Y0 C0\nG1 Z-1 F150\nG1 X100 C0 F1000", "never lifts the knife above Z-1"),
        ("G21 G90\nG0 Z5\nG1 Z-1 F150\nG1 X9 C0\nG0 X30\nG1 X40\nG0 Z5", "line 5: G0 moves X or Y in the depth"),
        ("G21 G90\nG0 Z5\nG1 Z-1 F150\nG1 X9 C0\nG0 Z5\nX20\nG1 Z-1\nG0 Z5", "line 7: the knife goes down and up"),
        ("G21 G90\nG0 Z5\nG1 Z-1 F150\nG1 X9 C0\nG1 C90\nG1 Y9\nG0 Z5", "turns on the spot by 90 deg"),
        ("G21 G90\nG0 Z5\nG1 Z-2 F150\nG1 X9 C0\nG0 Z-1\nG1 X18\nG0 Z5", "nothing goes down to this cut"),
        ("G64 P0.1\nG0 Z5\nG1 Z-2 F150\nG1 X9 C0\nG64 P0.01\nG1 X18\nG0 Z5", "G64 P is not the same"),
    ],
)
def test_a_program_that_a_new_one_would_cut_otherwise_says_why(text, why):
    (lost,) = program_of(text).lost
    assert why in lost


def test_what_a_new_program_would_lose_is_listed_with_its_line():
    found = cut_of("G61\nG1 Z-1 F150\nG55 G43 H1\nG1 X100 C0 F1000\nG4 P1")
    assert found.passed == ["line 4: G61", "line 6: G55", "line 6: G43", "line 6: H1", "line 8: G4 P1"]


def test_feeds_at_the_lift_do_not_cut_and_are_said():
    found = cut_of("G1 X10 Y10 F3000\nG1 Z-1 F200\nG1 X110 C0 F1000\nG1 Z5\nG1 X0 Y0")
    assert [s.length for s in found.strokes] == [100.0] and found.lost == []
    assert found.changed == [
        "moves above the work that lead to no cut are not kept (line 8): each stroke is approached straight, at Z5 mm"
    ]


def test_of_two_depths_without_a_lift_between_both_are_cut():
    found = program_of("G1 Z-1 F90\nG1 X50 C0\nG1 Z-3\nG1 X90\nG0 Z2", "their.ngc")
    assert [s.length for s in found.strokes] == [50.0, 40.0]


OWN = program(strokes_of([shapes.rounded_rectangle()], Settings()), Settings())


def test_a_program_of_ours_that_was_edited_is_not_made_faster():
    assert program_of(OWN).lost == []
    assert program_of(OWN.replace("G1 Z-1 F600", "G1 Z-1 F200")).settings.plunge == 200.0
    assert program_of(OWN.replace("G0 Z5", "G0 Z30")).settings.lift == 30.0
    (lost,) = program_of(OWN.replace("F3000", "F1000")).lost
    assert "its feed is 1000 mm/min, and a new program would have that by the head of this one, 3000" in lost


def test_an_axis_other_than_the_head_of_our_program_says_is_refused():
    assert program_of(OWN, zero=0.0, clockwise=False).ours
    with pytest.raises(ValueRefused, match="zero = 90: the head of program says 0 deg"):
        program_of(OWN, zero=90.0)
    with pytest.raises(ValueRefused, match="says that the axis counts counter-clockwise"):
        program_of(OWN, clockwise=True)


@pytest.mark.parametrize("comment", ["(d 1.2.3)", "(d .)", "(d " + 400 * "9" + ")", "(d 46)"])
def test_an_offset_of_ours_that_is_none_is_refused_and_a_comment_of_others_is_one(comment):
    lines = OWN.splitlines()
    k = next(k for k, x in enumerate(lines) if x.startswith("G1 X"))
    text = "\n".join([*lines[:k], f"{lines[k]} {comment}", *lines[k + 1 :]])
    with pytest.raises(DataError, match=rf"line {k + 1}: its comment \(d .* is no offset: expected a number from -45"):
        program_of(text)
    assert cut_of(f"G1 Z-1 F90\nG1 X9 C0 {comment}").strokes[0].offset(5.0) == 0.0


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("G1 Z-1 F90\nG1 X100 C720", "line 5: the blade turns by 720 deg in a move that turns by 0 deg"),
        ("G1 Z-1 F90\nG1 X100 C-90\nG1 Y9 C90", "the blade stands at -90 deg to its move"),
        ("G0 C350\nG1 Z-1 F90\nG1 X10 C350\nG1 X20 C0", "words must run on beyond 360"),
        ("G1 X20 Z-1 C0 F90\nG1 X120\nG1 X140 Z0", "line 4: X or Y moves together with Z: a ramp"),
        ("G1 Z-1 F90\nG1 X1" + 60 * "0" + " C0", "line 5: X is 1e.60 mm: expected up to 1e.06 mm"),
        ("G1 Z-1 F90\nG1 X10 C0 B5\nG1 X20 B0 C1", "has words for B and for C"),
    ],
)
def test_words_that_no_blade_follows_are_refused(body, why):
    with pytest.raises(DataError, match=why):
        cut_of(body)


READ = {
    "G91": "G91\nG1 X10 C0 F100\nG1 X10 C0",
    "G5": "G5 X10 Y0 I3 J0 P-3 Q0 C0 F100",
    "tool": "T1 M6\nG43 H1\nG1 X10 C0 F100",
    "idle A": "G1 X10 Y1 C5 A0 F100\nG1 X20 C0",
    "G93": "G93 G1 X10 C0 F10\nG94 G1 X20 F100",
    "origin": "G55 G1 X10 C0 F100",
}
REFUSED = {
    "two G": "G0 G1 X10 C0 F100",
    "two axes": "G1 X10 C1 A1 F100",
    "no F in G93": "G93 G1 X10 C0 F10\nX20",
    "G92": "G92 X0\nG1 X10 C0 F100",
    "plane": "G18 G1 X10 C0 F100",
    "variable": "G1 X#1 C0 F100",
    "R of nothing": "G2 X10 R1 C0 F100",
}


@pytest.mark.parametrize("text", [*READ.values(), *REFUSED.values()], ids=[*READ, *REFUSED])
def test_a_program_is_read_as_a_drawing_is(text):
    seen = []
    for read in (
        lambda: sum(p.length for p in paths_of_gcode(text).paths),
        lambda: sum(s.flat for s in read_moves(text, "p").steps if s.code),
    ):
        try:
            seen.append(round(read(), 6))
        except DataError:
            seen.append(None)
    assert seen[0] == seen[1] and (seen[0] is None) == (text in REFUSED.values())


def test_words_of_another_zero_are_refused_with_what_to_say():
    settings = Settings(zero=90.0)
    text = program(strokes_of([shapes.wave()], settings), settings)
    plain = "\n".join(x for x in text.splitlines() if not x.startswith("("))
    with pytest.raises(DataError, match=r"most are -90 deg off: --zero 90 or --clockwise"):
        program_of(plain)
    assert program_of(plain, zero=90.0).strokes[0].at(0.0).heading == pytest.approx(65.556, abs=0.01)
