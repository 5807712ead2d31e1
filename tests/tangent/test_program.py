"""Programs read back: ours to rounding, and those of other people by what they say."""

import math

import numpy as np
import pytest

from leadscrew.kernel.errors import DataError
from leadscrew.paths import shapes
from leadscrew.tangent.emit import program
from leadscrew.tangent.program import program_of
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke, Table, strokes_of

VARIANTS = {
    "plain": Settings(),
    "inch, clockwise": Settings(inch=True, clockwise=True, zero=90.0, axis="A", inverse_time=True),
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
G2 X15 Y-10 R5 A90 (hard)
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
        ("G1 X1 F100 G55", "line 1: G55 is not understood here"),
        ("G21\nG1 X1", "line 2: G1 without a feed: F is missing"),
        ("G93 G1 X1 F10 C0\nX2", "line 2: a move without F, in inverse time"),
        ("G1 X10 F100", "has no words of a tangential axis"),
        ("G1 X10 C0 A0 F100", "has words for A and for C"),
        ("G0 X10 C0", "nothing is cut"),
        ("G1 X10 C0 F100\nG2 X20 I3 C5", "line 2: G2: the radius is 3 mm at the start and 7 mm at the end"),
        ("G2 X10 C0 F100", "line 1: G2 needs the centre, I and J, or the radius, R"),
        ("G0 C90\nG1 X10 F100", "line 2: the blade stands at 90 deg to its move"),
        ("G1 X#1 F100", "line 1: cannot read 'X#1F100'"),
        ("X10 F100", "line 1: no G0, G1, G2 or G3 is in force"),
        ("G1 X1 X2 F100", "a second X on this line"),
        ("G1 X10 C0 F100 (open", "a comment is not closed"),
        ("", "the program does not move"),
    ],
)
def test_what_cannot_be_read_is_refused_by_line_and_word(text, why):
    with pytest.raises(DataError, match=why):
        program_of(text, "their.ngc")


def test_words_of_another_zero_are_refused_with_what_to_say():
    settings = Settings(zero=90.0)
    text = program(strokes_of([shapes.wave()], settings), settings)
    plain = "\n".join(x for x in text.splitlines() if not x.startswith("("))
    with pytest.raises(DataError, match=r"most are -90 deg off: --zero 90 or --clockwise"):
        program_of(plain)
    assert program_of(plain, zero=90.0).strokes[0].at(0.0).heading == pytest.approx(65.556, abs=0.01)
