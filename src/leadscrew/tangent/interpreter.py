"""Reads a program for a tangential knife: its moves with the angles of the axis.

The reader is the one of all G-code here, :mod:`leadscrew.references._gcode_reader`: what it understands of a drawing is
understood of a program, in the same way. Besides, line by line:

- the comment ``(d 1.234)`` of a program of ours: the offset of the axis at the end of the move;
- what a program written anew would not have (spindle, coolant, tool, dwell, ``G61``): noted with its line.

A feed must be given, other than for a drawing: a cut takes time.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from leadscrew.paths.curve import Curve
from leadscrew.paths.gcode import curve_of
from leadscrew.references._gcode_reader import MM_PER_INCH, WORD, Dialect, Move, moves_from_gcode
from leadscrew.util.errors import DataError, ValueRefused

DIALECT = Dialect(rotary="ABC", splines=True, passive=True, inverse_time=True)
COMMENT = re.compile(r"\(([^()]*)\)")
OFFSET = re.compile(r"^d\s+([+-]?[\d.]+)$")
MOST_OFFSET_DEG = 45.0
"""No offset is larger."""
MOST_MM = 1e6
"""No place is further away."""
MOST_DEG = 1e7
"""No word is larger."""
KEPT = {"G54", "G64", "G91.1"}
"""What is passed over and not lost: the origin that holds anyway, and what is kept or has no effect."""


class Step(NamedTuple):
    """One move."""

    line: int
    code: int
    """0, 1, 2, 3, 5."""
    start: tuple[float, float, float]
    """X, Y, Z in mm."""
    end: tuple[float, float, float]
    curve: Curve | None
    """Its line in XY; None where neither moves."""
    words: tuple[float, float]
    """What the axis reads before and after, deg."""
    offset: float | None
    """What the line's comment says, deg."""
    feed: float
    """mm/min along the line; 0: rapid."""

    @property
    def flat(self) -> float:
        """Length in XY, mm."""
        return 0.0 if self.curve is None else self.curve.length


class Moves(NamedTuple):
    """A program, read."""

    steps: list[Step]
    axis: str
    """Of its tangential words: A, C, or empty where it has none."""
    inch: bool
    inverse_time: bool
    passed: list[str]
    """What was passed over, with its line."""
    rounding: list[float | None]
    """P of each ``G64``, mm; None: without P."""
    heights: bool
    """Whether there is a Z word at all."""


def read_moves(text: str, name: str, ours: bool = True) -> Moves:
    """The moves of a program; comments are offsets where it is ``ours``.

    Raises:
        DataError: what cannot be read, by line and word; words for both A and C; no move.
    """
    lines = _Lines(text, name, ours)
    moves = moves_from_gcode(lines, name=name, dialect=DIALECT, passed=lines.words)
    lines.note()
    turning = {"ABC"[k] for m in moves for k in range(3) if m.turned_to[k] != m.turned_from[k]}
    axes = sorted(turning or lines.axes)
    if len(axes) > 1:
        raise DataError(f"{name}: has words for {' and for '.join(axes)}; a tangential knife has one axis")
    if axes == ["B"]:
        raise DataError(f"{name}: its rotary axis is B; expected A or C")
    axis = axes[0] if axes else ""
    idle = sorted(lines.axes - set(axes))
    steps = []
    for move in moves:
        if move.motion is None:
            lines.passed.append((move.line, f"G4 P{move.dwell:g}"))
        else:
            steps.append(_step(move, "ABC".index(axis or "C"), lines, name))
    if not steps:
        raise DataError(f"{name}: the program does not move")
    passed = [f"line {n}: {word}" for n, word in sorted(lines.passed, key=lambda row: row[0])]
    passed += [f"words of {letter}" for letter in idle]
    return Moves(steps, axis, lines.inch, any(m.per_minute for m in moves), passed, lines.rounding, lines.heights)


class _Lines:
    """The lines of a program as the reader takes them, and what it does not tell of each."""

    def __init__(self, text: str, name: str, ours: bool) -> None:
        self.text, self.name, self.ours = text, name, ours
        self.words: Counter[str] = Counter()
        self.before: Counter[str] = Counter()
        self.passed: list[tuple[int, str]] = []
        self.rounding: list[float | None] = []
        self.axes: set[str] = set()
        self.offsets: dict[int, float] = {}
        self.line = 0
        self.inch = self.heights = False

    def __iter__(self) -> Iterator[str]:
        for number, line in enumerate(self.text.splitlines(), start=1):
            self.line = number
            self._read(line)
            yield line
            self.note()

    def note(self) -> None:
        """Notes the words that the reader has passed over in this line."""
        if self.words != self.before:
            self.passed += [(self.line, w) for w in (self.words - self.before).elements() if w not in KEPT]
            self.before = self.words.copy()

    def _read(self, line: str) -> None:
        if self.ours:
            self._comments(line)
        code = re.sub(r"\s+", "", COMMENT.sub(" ", line).split(";", 1)[0]).upper()
        words = [(letter, float(value)) for letter, value in WORD.findall(code)]
        gs = [value for letter, value in words if letter == "G"]
        if 20.0 in gs or 21.0 in gs:
            self.inch = 20.0 in gs
        self.axes |= {letter for letter, _ in words if letter in "ABC"}
        self.heights |= any(letter == "Z" for letter, _ in words)
        self.passed += [(self.line, f"G{g:g}") for g in gs if g in (61.0, 61.1)]
        if 64.0 in gs:
            size = MM_PER_INCH if self.inch else 1.0
            self.rounding.append(next((value * size for letter, value in words if letter == "P"), None))
            self.passed += [(self.line, f"G64 Q{value:g}") for letter, value in words if letter == "Q"]

    def _comments(self, line: str) -> None:
        for comment in COMMENT.findall(line):
            found = OFFSET.match(comment.strip())
            if not found:
                continue
            try:
                value = float(found[1])
            except ValueError:
                value = math.nan
            if not abs(value) <= MOST_OFFSET_DEG:
                raise DataError(
                    f"{self.name}, line {self.line}: its comment ({comment[:24]}) is no offset: expected a number "
                    f"from -{MOST_OFFSET_DEG:g} to {MOST_OFFSET_DEG:g} deg"
                )
            self.offsets[self.line] = value


def _step(move: Move, axis: int, lines: _Lines, name: str) -> Step:
    where = f"{name}, line {move.line}"
    for letter, value in zip("XYZ", move.end, strict=True):
        if not abs(value) <= MOST_MM:
            raise DataError(f"{where}: {letter} is {value:.4g} mm: expected up to {MOST_MM:g} mm")
    word = move.turned_to[axis]
    if not abs(word) <= MOST_DEG:
        raise DataError(f"{where}: {'ABC'[axis]} is {word:.4g} deg: expected up to {MOST_DEG:g} deg")
    still = move.start[:2] == move.end[:2] and move.centre is None and move.controls is None
    try:
        curve = None if still else curve_of(move)
    except ValueRefused as refused:
        raise DataError(f"{where}: {refused}") from None
    code = int(move.motion or 0.0)
    feed = move.feed
    if code and move.per_minute:
        way = math.hypot(0.0 if curve is None else curve.length, move.end[2] - move.start[2])
        feed = move.per_minute * (way or abs(word - move.turned_from[axis]))
    elif code and not feed:
        raise DataError(f"{where}: G{code} without a feed: F is missing")
    words = (move.turned_from[axis], word)
    return Step(move.line, code, move.start, move.end, curve, words, lines.offsets.get(move.line), feed)
