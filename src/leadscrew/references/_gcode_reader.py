"""The reader of G-code that all share: modal state, units, arcs; what is understood is the caller's :class:`Dialect`.

Source: LinuxCNC documentation, "G-Codes" (arc formats and their tolerances: 2 * 0.001 inch or 0.1 % of the radius).
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable
from typing import Any, NamedTuple

from leadscrew.util.errors import DataError

WORD = re.compile(r"([A-Z])([+-]?(?:\d+\.?\d*|\.\d+))")
MOTION = {0.0, 1.0, 2.0, 3.0}
SPLINE = 5.0
"""The cubic spline: ``I J`` from the start to the first control point, ``P Q`` from the end to the second."""
GROUPS = (MOTION, {4.0}, {17.0}, {20.0, 21.0}, {90.0, 91.0}, {61.0, 61.1}, {40.0}, {49.0}, {80.0}, {94.0})
"""G-codes understood; two of one group on a line contradict each other."""
ENDS = {2.0, 30.0}
MM_PER_INCH = 25.4
RADIUS_TOLERANCE_MM = 0.05
"""How far the two radii of an arc may differ, or 0.1 % of the radius: room for programs with few decimals."""
PASSIVE_G = {43.0, 54.0, 55.0, 56.0, 57.0, 58.0, 59.0, 64.0, 91.1}
PASSIVE_M = {0.0, 1.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0}

Triple = tuple[float, float, float]


class Dialect(NamedTuple):
    """What a caller understands beyond lines and arcs of X, Y, Z."""

    rotary: str = ""
    """Letters of rotary axes, of ``ABC``: their words are kept, in deg."""
    splines: bool = False
    """``G5``, and ``Q``."""
    passive: bool = False
    """What moves no axis (spindle, tool, coolant, offsets, ``G64``) is counted, not refused; a feed may be missing."""
    unit: float = 1.0
    """Size in mm of the unit before the first ``G20`` or ``G21``."""
    inverse_time: bool = False
    """``G93``: F is one by the minutes that a move takes, so it is no speed; each ``G1 G2 G3 G5`` needs one of its
    own."""


class Move(NamedTuple):
    """One move, or a dwell."""

    motion: float | None
    """0, 1, 2, 3, 5; none for a dwell."""
    start: Triple
    end: Triple
    feed: float = 0.0
    """mm/min; 0: at the rapid rate, or not said."""
    centre: tuple[float, float] | None = None
    """Of an arc."""
    controls: tuple[tuple[float, float], tuple[float, float]] | None = None
    """Of a spline."""
    turned_from: Triple = (0.0, 0.0, 0.0)
    """A, B, C before it, deg."""
    turned_to: Triple = (0.0, 0.0, 0.0)
    dwell: float = 0.0
    """Seconds."""
    line: int = 0
    per_minute: float = 0.0
    """``G93``: one by the minutes that the move takes; 0: the feed holds."""


def moves_from_gcode(
    program: str | Iterable[str],
    start: Triple = (0.0, 0.0, 0.0),
    name: str = "G-code",
    dialect: Dialect | None = None,
    passed: Counter[str] | None = None,
) -> list[Move]:
    """The moves of a program, in mm; ``passed`` counts the words that a passive dialect passes over.

    Raises:
        DataError: a line that is not understood: names line and word.
    """
    reader = _Reader(start, dialect or Dialect(), Counter() if passed is None else passed)
    for number, text in enumerate(program.splitlines() if isinstance(program, str) else program, start=1):
        reader.line = number
        try:
            reader.read(text)
        except RefusedError as refused:
            raise DataError(f"{name}, line {number}: {refused}") from None
        if reader.ended:
            break
    return reader.moves


class RefusedError(Exception):
    """Why a line is refused; the reader adds file and line."""


class _Reader:
    """The modal state of the interpreter and the moves so far."""

    def __init__(self, start: Triple, dialect: Dialect, passed: Counter[str]) -> None:
        self.dialect = dialect
        self.passed = passed
        self.place: Triple = (float(start[0]), float(start[1]), float(start[2]))
        self.turned: Triple = (0.0, 0.0, 0.0)
        self.leaving: tuple[float, float] | None = None
        self.line = 0
        self.motion: float | None = None
        self.unit = dialect.unit
        self.incremental = False
        self.feed = 0.0
        self.inverse = False
        self.per_minute = 0.0
        self.moves: list[Move] = []
        self.started = False
        self.ended = False

    def read(self, text: str) -> None:
        gs, ms, words = self._words(text)
        if text.strip() == "%":
            self.ended = self.started
            self.started = True
            return
        self.started = self.started or bool(gs or ms or words)
        if 20.0 in gs or 21.0 in gs:
            self.unit = MM_PER_INCH if 20.0 in gs else 1.0
        if 90.0 in gs or 91.0 in gs:
            self.incremental = 91.0 in gs
        if (93.0 in gs) != self.inverse and (93.0 in gs or 94.0 in gs):
            # An F of one kind is none of the other.
            self.inverse, self.feed = 93.0 in gs, 0.0
        self.per_minute = 0.0
        if "F" in words:
            if words["F"] <= 0.0:
                raise RefusedError(f"F{words['F']:g}: the feed must be positive")
            if self.inverse:
                self.per_minute = words.pop("F")
            else:
                self.feed = words.pop("F") * self.unit
        words.pop("N", None)
        for letter in "STH" if self.dialect.passive else "":
            if letter in words:
                self.passed[f"{letter}{words.pop(letter):g}"] += 1
        if 64.0 in gs:
            words.pop("P", None)
            words.pop("Q", None)
        moved = [g for g in gs if g in MOTION or g == SPLINE]
        if moved:
            self.motion = moved[0]
        elif 80.0 in gs:
            self.motion = None
        if 4.0 in gs:
            self._dwell(words)
        elif any(axis in words for axis in "XYZABC") or (self.motion in (2.0, 3.0) and ("I" in words or "J" in words)):
            self._move(words)
        for letter, value in words.items():
            raise RefusedError(f"{letter}{value:g} has no use on this line")
        self.ended = any(m in ENDS for m in ms)

    def _dwell(self, words: dict[str, float]) -> None:
        if words.get("P", -1.0) < 0.0:
            raise RefusedError("G4 needs P, the seconds to wait, not negative")
        self._append(Move(None, self.place, self.place, dwell=words.pop("P")), self.turned)

    def _move(self, words: dict[str, float]) -> None:
        if self.motion is None:
            raise RefusedError(f"{_show(words, 'XYZABCIJ')}: no G0, G1, G2 or G3 is in force")
        rapid = self.motion == 0.0
        if not rapid and self.inverse and self.per_minute == 0.0:
            raise RefusedError(f"G{self.motion:g} without F in inverse time (G93): each move needs one of its own")
        if not rapid and not self.inverse and self.feed == 0.0 and not self.dialect.passive:
            raise RefusedError(f"G{self.motion:g} without a feed: F is missing")
        here = self.place
        there = self._axes("XYZ", here, words, self.unit)
        turned = self._axes("ABC", self.turned, words, 1.0)
        feed = 0.0 if rapid else self.feed
        leaving, self.leaving = self.leaving, None
        centre = controls = None
        if self.motion == SPLINE:
            controls = self._controls(here, there, words, leaving)
        elif self.motion > 1.0 and (here != there or turned == self.turned or any(c in words for c in "IJR")):
            centre = self._centre(here, there, words, self.motion == 2.0)
        motion = 1.0 if self.motion in (2.0, 3.0) and centre is None else self.motion
        per_minute = 0.0 if rapid else self.per_minute
        self._append(Move(motion, here, there, feed, centre, controls, per_minute=per_minute), turned)

    def _append(self, move: Move, turned: Triple) -> None:
        self.moves.append(move._replace(turned_from=self.turned, turned_to=turned, line=self.line))
        self.place, self.turned = move.end, turned

    def _words(self, text: str) -> tuple[list[float], list[float], dict[str, float]]:
        """G numbers, M numbers and the other words of one line."""
        code = re.sub(r"\([^()]*\)", " ", text)
        code = re.sub(r"\s+", "", code.split(";", 1)[0]).upper()
        if "(" in code or ")" in code:
            raise RefusedError("a comment is not closed, or closed twice")
        if code == "%":
            return [], [], {}
        groups: tuple[set[float], ...] = (*GROUPS[1:], MOTION | {SPLINE}) if self.dialect.splines else GROUPS
        if self.dialect.inverse_time:
            groups = tuple({93.0, 94.0} if group == {94.0} else group for group in groups)
        letters = "XYZIJRFNP" + self.dialect.rotary + ("Q" if self.dialect.splines else "")
        letters += "STH" if self.dialect.passive else ""
        gs: list[float] = []
        ms: list[float] = []
        words: dict[str, float] = {}
        place = 0
        while place < len(code):
            found = WORD.match(code, place)
            if not found:
                raise RefusedError(f"cannot read {code[place : place + 12]!r}")
            letter, number = found[1], float(found[2])
            word = found[0]
            if not math.isfinite(number):
                raise RefusedError(f"{word[:12]}... is beyond any number")
            if self.dialect.passive and number in {"G": PASSIVE_G, "M": PASSIVE_M}.get(letter, set()):
                self.passed[f"{letter}{number:g}"] += 1
                if letter == "G":
                    gs.append(number)
            elif letter == "G":
                group = next((g for g in groups if number in g), None)
                if group is None:
                    raise RefusedError(f"{word} is not understood; known: {_known(groups)}")
                if any(g in group for g in gs):
                    raise RefusedError(f"{word} contradicts an earlier G word of this line")
                gs.append(number)
            elif letter == "M":
                if number not in ENDS:
                    raise RefusedError(f"{word} is not understood; known: M2, M30")
                ms.append(number)
            elif letter in letters:
                if letter in words:
                    raise RefusedError(f"{word}: a second {letter} on this line")
                words[letter] = number
            else:
                raise RefusedError(f"{word} is not understood")
            place = found.end()
        return gs, ms, words

    def _axes(self, letters: str, old: Triple, words: dict[str, float], unit: float) -> Triple:
        end = []
        for axis, was in zip(letters, old, strict=True):
            given = words.pop(axis, None)
            end.append(was if given is None else given * unit + (was if self.incremental else 0.0))
        return end[0], end[1], end[2]

    def _controls(
        self, here: Triple, there: Triple, words: dict[str, float], leaving: tuple[float, float] | None
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """The two control points of ``G5``; without ``I J`` it goes on as the ``G5`` before it ended."""
        if "P" not in words or "Q" not in words:
            raise RefusedError("G5 needs P and Q, from the end to the second control point")
        if there[2] != here[2]:
            raise RefusedError("G5 stays in XY: Z cannot move with it")
        if "I" in words or "J" in words:
            i, j = words.pop("I", 0.0) * self.unit, words.pop("J", 0.0) * self.unit
        elif leaving is not None:
            i, j = leaving
        else:
            raise RefusedError("the first G5 needs I and J, from the start to the first control point")
        p, q = words.pop("P") * self.unit, words.pop("Q") * self.unit
        self.leaving = (-p, -q)
        return (here[0] + i, here[1] + j), (there[0] + p, there[1] + q)

    def _centre(self, here: Any, there: Any, words: dict[str, float], clockwise: bool) -> tuple[float, float]:
        code = "G2" if clockwise else "G3"
        if "R" in words:
            if "I" in words or "J" in words:
                raise RefusedError(f"{code} with R and with {_show(words, 'IJ')}: give one of them")
            return centre_from_radius(here, there, words.pop("R") * self.unit, clockwise, code)
        if "I" not in words and "J" not in words:
            raise RefusedError(f"{code} needs the centre, I and J, or the radius, R")
        i, j = words.pop("I", 0.0) * self.unit, words.pop("J", 0.0) * self.unit
        centre = (here[0] + i, here[1] + j)
        first, last = math.dist(here[:2], centre), math.dist(there[:2], centre)
        if first == 0.0:
            raise RefusedError(f"{code}: the radius is zero")
        if abs(first - last) > max(RADIUS_TOLERANCE_MM, 1e-3 * first):
            raise RefusedError(
                f"{code}: the radius is {first:.6g} mm at the start of the arc and {last:.6g} mm at its end "
                f"(I{i:g} J{j:g} in mm)"
            )
        return centre


def centre_from_radius(here: Any, there: Any, r: float, clockwise: bool, code: str) -> tuple[float, float]:
    """The centre from ``R``: positive for an arc of at most half a turn, negative for more."""
    dx, dy = there[0] - here[0], there[1] - here[1]
    chord = math.hypot(dx, dy)
    if chord == 0.0:
        raise RefusedError(f"{code} with R: start and end are the same, so the centre is not defined; use I and J")
    if abs(r) < 0.5 * chord - RADIUS_TOLERANCE_MM:
        raise RefusedError(f"{code} R{r:g}: the radius is less than half the chord, {0.5 * chord:.6g} mm")
    height = math.sqrt(max(r * r - 0.25 * chord * chord, 0.0))
    # Seen along the chord, the centre of a short counter-clockwise arc lies to the left.
    side = height if (r > 0.0) != clockwise else -height
    return (here[0] + 0.5 * dx - side * dy / chord, here[1] + 0.5 * dy + side * dx / chord)


def _known(groups: Iterable[set[float]]) -> str:
    return ", ".join(f"G{g:g}" for group in groups for g in sorted(group))


def _show(words: dict[str, float], letters: str) -> str:
    return " ".join(f"{k}{v:g}" for k, v in words.items() if k in letters)
