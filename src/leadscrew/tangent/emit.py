"""A program for LinuxCNC: cutting moves with tangential words, lift and plunge between strokes, and how it was made.

    G0 X Y C        above the start of a stroke, the blade turned by the shorter way
    G1 Z            plunge
    G1 X Y C        a line;    G2 G3 X Y I J C: an arc, on which the axis turns evenly: exactly tangent
    G0 Z            lift

**F.** In G94, LinuxCNC takes F as the speed of X, Y and Z where any of them moves; the turning axis comes along and
does not count (LinuxCNC, *G-Code Overview*, "Feed Rate"). So F is mm/min along the line. Other controls count degrees
as millimetres: for these there is G93 (``inverse_time``), where F is one by the minutes of a move.

**Turns.** Words are unwrapped: they run on beyond 360. The axis must not be ``WRAPPED_ROTARY``, and its limits must
hold the turns of a stroke.

**Offsets.** Where the axis is offset from the tangent, each line says by how much: ``(d 1.234)``. A program that was
cut can so be read back with both.

Numbers are rounded to 0.1 um (0.00001 inch) and 0.0001 deg: the same input makes the same file.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from leadscrew.references._gcode_reader import MM_PER_INCH
from leadscrew.tangent.moves import Move, moves_of
from leadscrew.tangent.settings import ANGLE_DIGITS, Settings, nearest_turn
from leadscrew.tangent.stroke import Stroke
from leadscrew.util.escape import gcode_comment

FIRST_LINE = "(leadscrew tangent 1)"
"""How our programs begin."""
OFFSET = "(d "


def program(
    strokes: Sequence[Stroke],
    settings: Settings,
    notes: Sequence[str] = (),
    moves: Sequence[Sequence[Move]] | None = None,
) -> str:
    """The program of some strokes; ``notes`` become comments at its head, ``moves`` are those of each, if known."""
    shift = "compensated" if any(s.table.offset.any() for s in strokes) else "none"
    head = [
        FIRST_LINE,
        *(f"({gcode_comment(n)})" for n in notes),
        *settings.lines(),
        f"(offsets: {shift})",
        f"{'G20' if settings.inch else 'G21'} G90 G17 G40 G49 G80 G94",
        f"G64 P{_small(settings.tolerance, settings)}",
        f"G0 Z{_number(settings.lift, settings)}",
        *_pricks(settings),
    ]
    writer = _Writer(settings, shift != "none")
    for k, stroke in enumerate(strokes):
        writer.stroke(k + 1, stroke, moves_of(stroke, settings) if moves is None else moves[k])
    return "\n".join([*head, *writer.lines, "M2", ""])


def _pricks(s: Settings) -> list[str]:
    """Down and up at each mark, the axis as it stands."""
    found = []
    for x, y in s.places():
        found += [
            f"(prick X{x:g} Y{y:g} mm)",
            f"G0 X{_number(x, s)} Y{_number(y, s)}",
            f"G1 Z{_number(s.depth, s)} F{_feed(s.plunge, s)}",
            f"G0 Z{_number(s.lift, s)}",
        ]
    return found


class _Writer:
    """The lines so far, and what the machine's words are."""

    def __init__(self, settings: Settings, offsets: bool) -> None:
        self.settings = settings
        self.offsets = offsets
        self.lines: list[str] = []
        self.reading = settings.start_angle

    def stroke(self, number: int, stroke: Stroke, moves: Sequence[Move]) -> None:
        s = self.settings
        x, y, heading, _ = stroke.at(0.0)
        offset = float(stroke.offset(0.0))
        # The turn to the start is the one nearest to where the axis stands.
        word = s.word(float(heading) + offset)
        turns = nearest_turn(word, self.reading) - word
        here = (float(x), float(y))
        self.lines += [
            f"(stroke {number}: {stroke.length:.3f} mm{', closed' if stroke.path.closed else ''})",
            f"G0 X{_number(here[0], s)} Y{_number(here[1], s)} {s.axis}{_angle(word + turns)}{self._tail(offset)}",
            f"G1 Z{_number(s.depth if stroke.depth is None else stroke.depth, s)} F{_feed(s.plunge, s)}",
        ]
        if s.inverse_time:
            self.lines.append("G93")
        feed = ""
        for move in moves:
            word = s.word(move.angle) + turns
            words = [f"X{_number(move.x, s)} Y{_number(move.y, s)}"]
            code = "G1"
            if move.arc is not None:
                code = "G3" if move.arc.sweep > 0.0 else "G2"
                # From the start as it is written, so that the two radii agree.
                i, j = (c - s.rounded(h) for c, h in zip(move.arc.centre, here, strict=True))
                words.append(f"I{_number(i, s)} J{_number(j, s)}")
            words.append(f"{s.axis}{_angle(word)}")
            asked = self._feed(move)
            if s.inverse_time or asked != feed:
                words.append(f"F{asked}")
                feed = asked
            self.lines.append(f"{code} {' '.join(words)}{self._tail(move.offset)}")
            here = (move.x, move.y)
            self.reading = word
        if s.inverse_time:
            self.lines.append("G94")
        self.lines.append(f"G0 Z{_number(s.lift, s)}")

    def _feed(self, move: Move) -> str:
        if self.settings.inverse_time:
            return f"{move.feed / move.length:.6g}"
        return _feed(move.feed, self.settings)

    def _tail(self, offset: float) -> str:
        return f" {OFFSET}{_zero(f'{offset:.4f}')})" if self.offsets else ""


def _number(mm: float, settings: Settings) -> str:
    return _zero(f"{mm / MM_PER_INCH:.5f}" if settings.inch else f"{mm:.4f}")


def _small(mm: float, settings: Settings) -> str:
    """A length of which the smallest allowed has four digits in either unit."""
    return _zero(f"{mm / MM_PER_INCH:.9f}" if settings.inch else f"{mm:.7f}")


def _angle(deg: float) -> str:
    return _zero(f"{deg:.{ANGLE_DIGITS}f}")


def _feed(mm_min: float, settings: Settings) -> str:
    """Rounded down, so that a limit stays one."""
    value = mm_min / (MM_PER_INCH if settings.inch else 1.0)
    digits = 3 if settings.inch or value < 100.0 else 1
    floor = math.floor(value * 10**digits + 1e-6) / 10**digits
    return f"{max(floor, 10.0**-digits):.{digits}f}".rstrip("0").rstrip(".")


def _zero(text: str) -> str:
    """Without a sign before nothing, and without idle zeros."""
    short = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if short in ("-0", "") else short
