"""Reads a program for a tangential knife: its moves with the angles of the axis.

Understood: ``G0 G1 G2 G3`` in XY (arcs with ``I J`` or ``R``), ``X Y Z A C F N``, ``G17 G20 G21 G40 G49 G54 G61 G64 G80
G90 G91.1 G93 G94``, ``M2 M30 %``, comments. A drive or a spindle is none of our business: ``M3 M4 M5 M7 M8 M9 S T G4``
are noted and passed over. Everything else is refused by line and word, because what is skipped unknown is another cut.

An arc is read as LinuxCNC reads it (see :mod:`leadscrew.references.gcode_reader`): the two radii agree to 0.05 mm or
0.1 %.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from leadscrew.kernel.errors import DataError
from leadscrew.references.gcode_reader import MM_PER_INCH, RADIUS_TOLERANCE_MM, WORD

COMMENT = re.compile(r"\(([^()]*)\)")
OFFSET = re.compile(r"^d ([+-]?[0-9.]+)$")
STILL = {17.0, 40.0, 49.0, 54.0, 61.0, 64.0, 80.0, 90.0, 91.1}
"""G-codes that change nothing here."""
PASSED = {3.0, 4.0, 5.0, 7.0, 8.0, 9.0}
"""M-codes that are passed over."""
ENDS = {2.0, 30.0}


class Step(NamedTuple):
    """One move."""

    line: int
    code: int
    """0 to 3."""
    start: tuple[float, float, float]
    """X, Y, Z in mm."""
    end: tuple[float, float, float]
    centre: tuple[float, float] | None
    words: tuple[float, float]
    """What the axis reads before and after, deg."""
    offset: float | None
    """What the line's comment says, deg."""
    feed: float
    """mm/min along the line; 0: rapid."""

    @property
    def flat(self) -> float:
        """Length in XY, mm."""
        if self.centre is None:
            return math.dist(self.start[:2], self.end[:2])
        return math.dist(self.start[:2], self.centre) * abs(self.sweep)

    @property
    def sweep(self) -> float:
        """Of an arc, rad, counter-clockwise positive."""
        assert self.centre is not None
        (cx, cy), (x, y), (u, v) = self.centre, self.start[:2], self.end[:2]
        turn = math.atan2(v - cy, u - cx) - math.atan2(y - cy, x - cx)
        if math.dist(self.start[:2], self.end[:2]) < 1e-9:
            turn = 0.0
        around = turn % (2.0 * math.pi)
        if self.code == 3:
            return around or 2.0 * math.pi
        return (around or 2.0 * math.pi) - 2.0 * math.pi if around else -2.0 * math.pi


class Moves(NamedTuple):
    """A program, read."""

    steps: list[Step]
    axis: str
    """Of its tangential words: A, C, or empty where it has none."""
    inch: bool
    inverse_time: bool
    passed: list[str]
    """What was passed over, with its line."""


def read_moves(text: str, name: str) -> Moves:
    """The moves of a program.

    Raises:
        DataError: what cannot be read, by line and word; words for both A and C; no move.
    """
    reader = _Reader()
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            reader.read(number, line)
        except _RefusedError as refused:
            raise DataError(f"{name}, line {number}: {refused}") from None
        if reader.ended:
            break
    if len(reader.axes) > 1:
        raise DataError(f"{name}: has words for A and for C; a tangential knife has one axis")
    if not reader.steps:
        raise DataError(f"{name}: the program does not move")
    return Moves(reader.steps, "".join(reader.axes), reader.inch, reader.inverse, reader.passed)


class _RefusedError(Exception):
    """Why a line is refused."""


class _Reader:
    """What is in force, and the moves so far."""

    def __init__(self) -> None:
        self.place = (0.0, 0.0, 0.0)
        self.known = [False, False, False]
        self.word = 0.0
        self.axes: set[str] = set()
        self.motion: int | None = None
        self.unit = 1.0
        self.inch = False
        self.feed = 0.0
        self.minutes = False
        self.inverse = False
        self.steps: list[Step] = []
        self.passed: list[str] = []
        self.ended = False

    def read(self, number: int, text: str) -> None:
        offsets = [m[1] for c in COMMENT.findall(text) if (m := OFFSET.match(c.strip()))]
        code = re.sub(r"\s+", "", COMMENT.sub(" ", text).split(";", 1)[0]).upper()
        if "(" in code or ")" in code:
            raise _RefusedError("a comment is not closed, or closed twice")
        if code in ("", "%"):
            return
        words: dict[str, float] = {}
        place = 0
        dwell = still = False
        while place < len(code):
            found = WORD.match(code, place)
            if not found:
                raise _RefusedError(f"cannot read {code[place : place + 12]!r}")
            place = found.end()
            letter, value = found[1], float(found[2])
            if letter == "G":
                dwell |= value == 4.0
                still |= value == 64.0
                self._g(found[0], value)
            elif letter == "M":
                if value in ENDS:
                    self.ended = True
                elif value in PASSED:
                    self.passed.append(f"line {number}: {found[0]}")
                else:
                    raise _RefusedError(f"{found[0]} is not understood")
            elif letter in words:
                raise _RefusedError(f"{found[0]}: a second {letter} on this line")
            elif letter in "XYZACIJRFNPQST":
                words[letter] = value
            else:
                raise _RefusedError(f"{found[0]} is not understood")
        words.pop("N", None)
        for letter in "ST":
            if letter in words:
                self.passed.append(f"line {number}: {letter}{words.pop(letter):g}")
        if dwell:
            self.passed.append(f"line {number}: G4 P{words.pop('P', 0.0):g}")
        if still:
            words.pop("P", None)
            words.pop("Q", None)
        self._move(number, words, float(offsets[0]) if offsets else None)
        for letter, value in words.items():
            raise _RefusedError(f"{letter}{value:g} has no use on this line")

    def _g(self, word: str, value: float) -> None:
        if value in (0.0, 1.0, 2.0, 3.0):
            self.motion = int(value)
        elif value in (20.0, 21.0):
            self.inch = value == 20.0
            self.unit = MM_PER_INCH if self.inch else 1.0
        elif value in (93.0, 94.0):
            self.minutes = value == 93.0
            self.inverse |= self.minutes
            self.feed = 0.0
        elif value not in STILL and value != 4.0:
            raise _RefusedError(f"{word} is not understood here")

    def _move(self, number: int, words: dict[str, float], offset: float | None) -> None:
        given = words.pop("F", None)
        if given is not None:
            if not given > 0.0:
                raise _RefusedError(f"F{given:g}: the feed must be positive")
            self.feed = given if self.minutes else given * self.unit
        round_ = self.motion in (2, 3) and ("I" in words or "J" in words)
        if not round_ and not any(a in words for a in "XYZAC"):
            return
        if self.motion is None:
            raise _RefusedError("no G0, G1, G2 or G3 is in force")
        here, before = self.place, self.word
        there = tuple(words.pop(a) * self.unit if a in words else h for a, h in zip("XYZ", here, strict=True))
        for axis in "AC":
            if axis in words:
                self.axes.add(axis)
                self.word = words.pop(axis)
        end = (there[0], there[1], there[2])
        centre = self._centre(here, end, words) if self.motion >= 2 else None
        if self.motion and self.feed == 0.0:
            raise _RefusedError(f"G{self.motion} without a feed: F is missing")
        step = Step(number, self.motion, here, end, centre, (before, self.word), offset, 0.0)
        if self.motion:
            way = math.hypot(step.flat, end[2] - here[2]) or abs(self.word - before)
            step = step._replace(feed=self.feed * way if self.minutes else self.feed)
            if self.minutes and given is None:
                raise _RefusedError("a move without F, in inverse time (G93)")
        self.steps.append(step)
        self.place = end

    def _centre(
        self, here: tuple[float, ...], there: tuple[float, ...], words: dict[str, float]
    ) -> tuple[float, float]:
        code = f"G{self.motion}"
        if "R" in words:
            from leadscrew.references.gcode_reader import _centre_from_radius
            from leadscrew.references.gcode_reader import _RefusedError as refusal

            try:
                return _centre_from_radius(here, there, words.pop("R") * self.unit, self.motion == 2, code)
            except refusal as why:
                raise _RefusedError(str(why)) from None
        if "I" not in words and "J" not in words:
            raise _RefusedError(f"{code} needs the centre, I and J, or the radius, R")
        centre = (here[0] + words.pop("I", 0.0) * self.unit, here[1] + words.pop("J", 0.0) * self.unit)
        first, last = math.dist(here[:2], centre), math.dist(there[:2], centre)
        if first == 0.0:
            raise _RefusedError(f"{code}: the radius is zero")
        if abs(first - last) > max(RADIUS_TOLERANCE_MM, 1e-3 * first):
            raise _RefusedError(f"{code}: the radius is {first:.6g} mm at the start and {last:.6g} mm at the end")
        return centre
