"""Paths of a G-code program: what is cut between two rapids, or between lowering and lifting the tool.

Understood are ``G0 G1 G2 G3 G5``, ``G20 G21``, ``G90 G91``, ``G93 G94`` and the rest of
:mod:`leadscrew.references._gcode_reader`, words of the axes A, B and C. A path ends at a rapid that moves
X or Y, and at every move of Z alone. Where X and Y move at several heights, feeds that end in the upper half do not
cut. The words of the tangential axis are kept as programmed, for each block of a path:
:class:`~leadscrew.paths.drawing.Programmed`.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import Path as File

import numpy as np

from leadscrew.paths.curve import Curve
from leadscrew.paths.drawing import LARGEST_MM, UNITS_MM, Drawing, Programmed, left_out, nothing, unit_named
from leadscrew.paths.path import JOIN_MM, SHORTEST_MM, Path
from leadscrew.paths.segments import Arc, Bezier, Line
from leadscrew.references._gcode_reader import RADIUS_TOLERANCE_MM, Dialect, Move, moves_from_gcode
from leadscrew.util import reading
from leadscrew.util.errors import DataError, ValueRefused

ROTARY = "ABC"
SAME_MM = 1e-9


def read_gcode(file: File, unit: str | None = None, axis: str = "") -> Drawing:
    """The paths of a G-code file; see :func:`leadscrew.paths.read.read_drawing`."""
    return paths_of_gcode(reading.text(file, reading.PROGRAM, "programs"), unit, axis, str(file))


def paths_of_gcode(program: str, unit: str | None = None, axis: str = "", name: str = "G-code") -> Drawing:
    """The paths of a program's text.

    ``unit`` holds before the first ``G20`` or ``G21``; ``axis`` is the letter of the tangential axis (none: the one of
    A, B, C that the program moves).

    Raises:
        DataError: a line that is not understood (names line and word), nothing to cut, two rotary axes and none named.
        ValueRefused: an axis other than A, B, C; a unit not known.
    """
    if axis not in ("", *ROTARY):
        raise ValueRefused(f"axis = {axis!r}: expected A, B or C")
    reading.check_curves(name, program.count("\n"))
    passed: Counter[str] = Counter()
    unit = unit_named(unit)
    dialect = Dialect(ROTARY, splines=True, passive=True, unit=UNITS_MM[unit or "mm"], inverse_time=True)
    moves = moves_from_gcode(program, name=name, dialect=dialect, passed=passed)
    notes = left_out(passed, "without effect on the path")
    turning = [k for k in range(3) if any(m.turned_to[k] != m.turned_from[k] for m in moves)]
    if len(turning) > 1 and not axis:
        raise DataError(f"{name} turns {', '.join(ROTARY[k] for k in turning)}: say which one is the tangential axis")
    which = ROTARY.index(axis) if axis else (turning[0] if turning else None)
    runs = _cuts(moves)
    paths, words = [], []
    empty = 0
    for run in runs:
        curves, rows = [], []
        travel = 0.0
        for move in run:
            try:
                curve = curve_of(move)
            except ValueRefused as refused:
                raise DataError(f"{name}, line {move.line}: {refused}") from None
            if not curve.scale + math.hypot(*curve.start) < LARGEST_MM:
                raise DataError(
                    f"{name}, line {move.line}: a coordinate beyond {LARGEST_MM / 1e6:g} km: is the unit right?"
                )
            if curve.length <= SHORTEST_MM:
                empty += 1
                continue
            curves.append(curve)
            if which is not None:
                rows.append((travel, travel + curve.length, move.turned_from[which], move.turned_to[which]))
            travel += curve.length
        if not curves:
            continue
        closed = math.dist(curves[0].start, curves[-1].end) <= JOIN_MM < 0.5 * travel
        paths.append(Path(curves, closed, f"line {run[0].line}", max(JOIN_MM, 2.0 * RADIUS_TOLERANCE_MM)))
        found = np.array(rows)
        words.append(Programmed(found[:, :2], found[:, 2:]) if which in turning else None)
    if empty:
        notes.append(f"{empty} segment{'s' if empty > 1 else ''} of no length left out")
    if not paths:
        raise nothing(name, notes or ["no feed moves X or Y"])
    inches = re.search(r"G0*20(?![\d.])", re.sub(r"\([^()]*\)|;.*", "", program).upper())
    said = "in" if inches else "mm" if unit is None else unit
    return Drawing(tuple(paths), said, tuple(notes), programmed=tuple(words), name=name)


def curve_of(move: Move) -> Curve:
    """A move of X and Y as a curve; of an arc whose two radii differ by rounding, the end is missed by as much."""
    here, there = move.start[:2], move.end[:2]
    if move.controls is not None:
        return Bezier(np.array([here, *move.controls, there]))
    if move.centre is None:
        return Line(here, there)
    x, y = move.centre
    angle = math.atan2(here[1] - y, here[0] - x)
    sweep = math.atan2(there[1] - y, there[0] - x) - angle
    full = 2.0 * math.pi
    way = -1.0 if move.motion == 2.0 else 1.0
    sweep = full if math.dist(here, there) < SAME_MM else (way * sweep) % full or full
    return Arc(move.centre, math.dist(here, move.centre), angle, way * sweep)


def _cuts(moves: list[Move]) -> list[list[Move]]:
    """Runs of cutting moves."""
    across = [m for m in moves if m.motion is not None and (m.start[:2] != m.end[:2] or m.centre is not None)]
    heights = {m.end[2] for m in across}
    split = 0.5 * (min(heights) + max(heights)) if heights else 0.0
    several = len(heights) > 1
    runs: list[list[Move]] = [[]]
    for move in moves:
        flat = move.start[:2] == move.end[:2] and move.centre is None and move.controls is None
        if move.motion is None:
            continue
        if flat and move.start[2] == move.end[2]:
            # The tangential axis turns on the spot, or nothing moves.
            if move.turned_from == move.turned_to and move.motion != 0.0:
                runs[-1].append(move)
            continue
        if flat or move.motion == 0.0 or (several and move.end[2] > split):
            runs.append([])
            continue
        runs[-1].append(move)
    return [run for run in runs if run]
