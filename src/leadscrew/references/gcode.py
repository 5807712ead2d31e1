"""A path from G-code: the subset of RS274/NGC that moves three axes along lines and arcs.

Understood: ``G0 G1 G2 G3`` (arcs in XY with ``I J`` or ``R``, helical with ``Z``), ``G4 P`` (dwell, seconds), ``G17``,
``G20 G21`` (inch, mm), ``G90 G91`` (absolute, incremental), ``G61 G61.1`` (exact stop: what is run anyway), ``G40 G49
G94`` (already so), ``G80`` (no motion in force), ``F X Y Z N``, ``M2 M30 %`` (end), comments in ``( )`` or after ``;``.
Everything else is refused by line and word, because a word that is skipped is a path that is not the program's.

Source: LinuxCNC documentation, "G-Codes" (arc formats and their tolerances: 2 * 0.001 inch or 0.1 % of the radius).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

from leadscrew.kernel.block import Block
from leadscrew.kernel.errors import DataError
from leadscrew.references.path import Segment, arc, line, path

WORD = re.compile(r"([A-Z])([+-]?(?:\d+\.?\d*|\.\d+))")
MOTION = {0.0, 1.0, 2.0, 3.0}
GROUPS = (MOTION, {4.0}, {17.0}, {20.0, 21.0}, {90.0, 91.0}, {61.0, 61.1}, {40.0}, {49.0}, {80.0}, {94.0})
"""G-codes understood; two of one group on a line contradict each other."""
ENDS = {2.0, 30.0}
MM_PER_INCH = 25.4
RADIUS_TOLERANCE_MM = 0.05
"""How far the two radii of an arc may differ, or 0.1 % of the radius: room for programs with few decimals."""


def path_from_gcode(
    program: str | Iterable[str],
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    name: str = "G-code",
    with_z: bool = False,
    **params: float,
) -> Block:
    """A reference block that runs a G-code program with an exact stop after each block of code.

    ``program`` is a text or its lines, ``start`` the position in mm before it, ``name`` what errors call it. The other
    keywords are those of :func:`leadscrew.references.path.path`: ``max_acceleration=...``, ``rapid=...``.

    Raises:
        DataError: a line that is not understood: names line and word.
        ValueRefused: a parameter out of range.
    """
    segments = segments_from_gcode(program, start, name)
    return path(segments, with_z=with_z, **params)


def segments_from_gcode(
    program: str | Iterable[str], start: tuple[float, float, float] = (0.0, 0.0, 0.0), name: str = "G-code"
) -> list[Segment]:
    """The segments of a program, in mm.

    Raises:
        DataError: see :func:`path_from_gcode`, or a program without motion.
    """
    reader = _Reader(start)
    for number, text in enumerate(program.splitlines() if isinstance(program, str) else program, start=1):
        try:
            reader.read(text)
        except _RefusedError as refused:
            raise DataError(f"{name}, line {number}: {refused}") from None
        if reader.ended:
            break
    if not any(s.length > 0.0 for s in reader.segments):
        raise DataError(f"{name}: the program does not move X, Y or Z")
    return reader.segments


class _RefusedError(Exception):
    """Why a line is refused."""


class _Reader:
    """The modal state of the interpreter and the segments so far."""

    def __init__(self, start: tuple[float, float, float]) -> None:
        self.place = (float(start[0]), float(start[1]), float(start[2]))
        self.motion: float | None = None
        self.unit = 1.0
        self.incremental = False
        self.feed = 0.0
        self.segments: list[Segment] = []
        self.started = False
        self.ended = False

    def read(self, text: str) -> None:
        gs, ms, words = _words(text, self.started)
        if text.strip() == "%":
            self.ended = self.started
            self.started = True
            return
        self.started = self.started or bool(gs or ms or words)
        if 20.0 in gs or 21.0 in gs:
            self.unit = MM_PER_INCH if 20.0 in gs else 1.0
        if 90.0 in gs or 91.0 in gs:
            self.incremental = 91.0 in gs
        if "F" in words:
            if words["F"] <= 0.0:
                raise _RefusedError(f"F{words['F']:g}: the feed must be positive")
            self.feed = words.pop("F") * self.unit
        words.pop("N", None)
        moved = [g for g in gs if g in MOTION]
        if moved:
            self.motion = moved[0]
        elif 80.0 in gs:
            self.motion = None
        if 4.0 in gs:
            self._dwell(words)
        elif any(axis in words for axis in "XYZ") or (self.motion in (2.0, 3.0) and ("I" in words or "J" in words)):
            self._move(words)
        for letter, value in words.items():
            raise _RefusedError(f"{letter}{value:g} has no use on this line")
        self.ended = bool(ms)

    def _dwell(self, words: dict[str, float]) -> None:
        if words.get("P", -1.0) < 0.0:
            raise _RefusedError("G4 needs P, the seconds to wait, not negative")
        self.segments.append(Segment(0.0, *self.place, dwell=words.pop("P")))

    def _move(self, words: dict[str, float]) -> None:
        if self.motion is None:
            raise _RefusedError(f"{_show(words, 'XYZIJ')}: no G0, G1, G2 or G3 is in force")
        rapid = self.motion == 0.0
        if not rapid and self.feed == 0.0:
            raise _RefusedError(f"G{self.motion:g} without a feed: F is missing")
        end = []
        for axis, old in zip("XYZ", self.place, strict=True):
            given = words.pop(axis, None)
            end.append(old if given is None else given * self.unit + (old if self.incremental else 0.0))
        x, y, z = end
        here, there = self.place, (x, y, z)
        if self.motion <= 1.0:
            segment = line(here, there, 0.0 if rapid else self.feed)
        else:
            clockwise = self.motion == 2.0
            centre = self._centre(here, there, words, clockwise)
            segment = arc(here, there, centre, clockwise, self.feed)
        self.place = there
        if segment.length > 0.0:
            self.segments.append(segment)

    def _centre(self, here: Any, there: Any, words: dict[str, float], clockwise: bool) -> tuple[float, float]:
        code = "G2" if clockwise else "G3"
        if "R" in words:
            if "I" in words or "J" in words:
                raise _RefusedError(f"{code} with R and with {_show(words, 'IJ')}: give one of them")
            return _centre_from_radius(here, there, words.pop("R") * self.unit, clockwise, code)
        if "I" not in words and "J" not in words:
            raise _RefusedError(f"{code} needs the centre, I and J, or the radius, R")
        i, j = words.pop("I", 0.0) * self.unit, words.pop("J", 0.0) * self.unit
        centre = (here[0] + i, here[1] + j)
        first, last = math.dist(here[:2], centre), math.dist(there[:2], centre)
        if first == 0.0:
            raise _RefusedError(f"{code}: the radius is zero")
        if abs(first - last) > max(RADIUS_TOLERANCE_MM, 1e-3 * first):
            raise _RefusedError(
                f"{code}: the radius is {first:.6g} mm at the start of the arc and {last:.6g} mm at its end "
                f"(I{i:g} J{j:g} in mm)"
            )
        return centre


def _centre_from_radius(here: Any, there: Any, r: float, clockwise: bool, code: str) -> tuple[float, float]:
    """The centre from ``R``: positive for an arc of at most half a turn, negative for more."""
    dx, dy = there[0] - here[0], there[1] - here[1]
    chord = math.hypot(dx, dy)
    if chord == 0.0:
        raise _RefusedError(f"{code} with R: start and end are the same, so the centre is not defined; use I and J")
    if abs(r) < 0.5 * chord - RADIUS_TOLERANCE_MM:
        raise _RefusedError(f"{code} R{r:g}: the radius is less than half the chord, {0.5 * chord:.6g} mm")
    height = math.sqrt(max(r * r - 0.25 * chord * chord, 0.0))
    # Seen along the chord, the centre of a short counter-clockwise arc lies to the left.
    side = height if (r > 0.0) != clockwise else -height
    return (here[0] + 0.5 * dx - side * dy / chord, here[1] + 0.5 * dy + side * dx / chord)


def _words(text: str, started: bool) -> tuple[list[float], list[float], dict[str, float]]:
    """G numbers, M numbers and the other words of one line."""
    code = re.sub(r"\([^()]*\)", " ", text)
    code = re.sub(r"\s+", "", code.split(";", 1)[0]).upper()
    if "(" in code or ")" in code:
        raise _RefusedError("a comment is not closed, or closed twice")
    if code == "%":
        return [], [], {}
    gs: list[float] = []
    ms: list[float] = []
    words: dict[str, float] = {}
    place = 0
    while place < len(code):
        found = WORD.match(code, place)
        if not found:
            raise _RefusedError(f"cannot read {code[place : place + 12]!r}")
        letter, number = found[1], float(found[2])
        word = found[0]
        if letter == "G":
            group = next((g for g in GROUPS if number in g), None)
            if group is None:
                raise _RefusedError(f"{word} is not understood; known: {_known()}")
            if any(g in group for g in gs):
                raise _RefusedError(f"{word} contradicts an earlier G word of this line")
            gs.append(number)
        elif letter == "M":
            if number not in ENDS:
                raise _RefusedError(f"{word} is not understood; known: M2, M30")
            ms.append(number)
        elif letter in "XYZIJRFNP":
            if letter in words:
                raise _RefusedError(f"{word}: a second {letter} on this line")
            words[letter] = number
        else:
            raise _RefusedError(f"{word} is not understood")
        place = found.end()
    return gs, ms, words


def _known() -> str:
    return ", ".join(f"G{g:g}" for group in GROUPS for g in sorted(group))


def _show(words: dict[str, float], letters: str) -> str:
    return " ".join(f"{k}{v:g}" for k, v in words.items() if k in letters)
