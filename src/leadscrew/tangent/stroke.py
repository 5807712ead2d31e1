"""What a knife does from its plunge to its lift: a line, the heading that is programmed along it, and offsets.

**Corner rule.** Where the tangent of a path jumps by more than the corner angle the knife is lifted, turned and
plunged: a stroke ends and another begins; a rounding that is one to the tolerance counts as a corner
(below). A smaller jump is turned in the material: over the length ``blend``, half
of it on either side (less where the next corner or an end is near), the programmed heading goes linearly from the one
to the other. A closed path without a corner of the first kind is one closed stroke, and may be cut on beyond its start
(overcut) so that the ends meet; any other starts at such a corner.

Source of the rule: common practice of tangential cutters (tcnc, GRBL-Plotter: 15 to 30 deg).

Corners in disguise: a rounding so small that a sharp corner in its place is the same line, to the tolerance.

Drawing programs round corners by micrometres. Taken as drawn, the knife would turn by 90 deg at depth over such a
rounding. Segments become a corner, the place where the tangents before and after them meet, if

- they turn by more than the corner angle, within less than ``blend``,
- the line beside them turns less than a quarter of that over the same length: it is a rounding, not a part of a curve,
- line and corner are nowhere more than ``tolerance`` apart.

**What remains.** A larger rounding is cut as drawn, the blade turning in the material:
:func:`leadscrew.tangent.moves.tight_turns` finds these. At 90 deg and the default tolerance that is a radius above
0.024 mm.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from leadscrew.paths.curve import Array, Curve, Places
from leadscrew.paths.path import Path, wrapped
from leadscrew.paths.segments import Line
from leadscrew.tangent.settings import Settings
from leadscrew.util.errors import DataError

LEAST_MM = 1e-3
"""A stroke shorter than this is a point: it is left out."""


class Bend(NamedTuple):
    """A corner that is turned in the material."""

    first: float
    """Travel where the turn begins, mm."""
    last: float
    """And where it ends."""
    start: float
    """Heading there, deg."""
    end: float


class Words(NamedTuple):
    """What a program gives along a stroke, at ascending arc lengths (mm)."""

    travel: Array
    value: Array
    """Headings, deg, between places the straight line; or feeds, mm/min, each from its place on."""


class Table(NamedTuple):
    """Offsets of the tangential axis at ascending places; between them the straight line."""

    travel: Array
    """In mm."""
    offset: Array
    """In deg, counter-clockwise."""


NO_OFFSETS = Table(np.zeros(1), np.zeros(1))


@dataclass(frozen=True, eq=False)
class Stroke:
    """One cut of the knife, from plunge to lift."""

    path: Path
    length: float
    """Of the cut, mm: more than the path's where it is closed and overcut."""
    bends: tuple[Bend, ...] = ()
    words: Words | None = None
    """Where a program says the headings itself."""
    table: Table = field(default=NO_OFFSETS)
    line: int = 0
    """Of the program that it was read from, where the cut begins; else 0."""
    depth: float | None = None
    """Z of the cutting knife, mm; None: that of the settings."""
    feeds: Words | None = None
    """Feeds as a program gives them: from each arc length on, mm/min; None: that of the settings."""

    def at(self, travel: ArrayLike) -> Places:
        """Point, programmed heading (deg, unwrapped) and the curvature that goes with it (1/mm)."""
        s = np.asarray(travel, dtype=np.float64)
        if self.words is not None and self._corners is not None and self.length <= self.path.length:
            x, y = (np.interp(s, self._corners[0], v) for v in self._corners[1:])
        else:
            x, y, heading, curvature = self.path.at(s if self.path.closed else np.clip(s, 0.0, self.path.length))
        if self.words is not None:
            knots, angles = self.words
            slope = np.radians(np.diff(angles) / np.diff(knots))
            k = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(slope) - 1)
            return Places(x, y, np.interp(s, knots, angles), slope[k])
        if self.bends:
            first, last, start, end = np.array(self.bends).T
            k = np.clip(np.searchsorted(first, s, side="right") - 1, 0, len(first) - 1)
            inside = (s >= first[k]) & (s <= last[k])
            slope = (end - start) / (last - first)
            heading = np.where(inside, start[k] + slope[k] * (s - first[k]), heading)
            curvature = np.where(inside, np.radians(slope[k]), curvature)
        return Places(x, y, heading, curvature)

    @cached_property
    def _corners(self) -> tuple[Array, Array, Array] | None:
        """Arc length and place of the corners of a line of chords; None of any other."""
        if not all(isinstance(s, Line) for s in self.path.segments):
            return None
        points = np.array([self.path.segments[0].start, *(s.end for s in self.path.segments)])
        travel = np.concatenate(([0.0], np.cumsum([s.length for s in self.path.segments])))
        return travel, points[:, 0], points[:, 1]

    def offset(self, travel: ArrayLike) -> Array:
        """Offset of the axis at arc lengths, deg."""
        return np.interp(np.asarray(travel, dtype=np.float64), *self.table)

    def grid(self, step: float) -> Array:
        """Arc lengths from 0 to the length, not more than ``step`` apart.

        Raises:
            DataError: more than ten million.
        """
        if self.length > 1e7 * step:
            raise DataError(f"a stroke of {self.length:g} mm has too many places {step:g} mm apart: is the unit right?")
        return np.linspace(0.0, self.length, max(math.ceil(self.length / step - 1e-9), 1) + 1)

    @property
    def edges(self) -> Array:
        """Arc lengths where a segment or a bend begins or ends; of all laps of a closed path."""
        once = np.concatenate(([0.0], np.cumsum([s.length for s in self.path.segments])))
        laps = math.ceil(self.length / self.path.length - 1e-12)
        marks = [once + k * self.path.length for k in range(max(laps, 1))]
        found = np.concatenate([*marks, np.ravel([(b.first, b.last) for b in self.bends]), [self.length]])
        found = np.sort(found[(found >= 0.0) & (found <= self.length)])
        return np.concatenate((found[:1], found[1:][np.diff(found) > 1e-9]))


def strokes_of(paths: Sequence[Path], settings: Settings) -> list[Stroke]:
    """The strokes of a drawing, in its order.

    Raises:
        DataError: nothing is left to cut.
    """
    found = [s for path in paths for s in _of_path(sharpened(path, settings), settings)]
    kept = [s for s in found if s.length >= LEAST_MM]
    if not kept:
        raise DataError("the drawing has no line to cut")
    return kept


def _of_path(path: Path, settings: Settings) -> list[Stroke]:
    sharp = [c.travel for c in path.corners if settings.lifts(c.turn_deg)]
    if not sharp:
        length = path.length + (settings.overcut if path.closed else 0.0)
        return [Stroke(path, length, _bends(path, length, settings))]
    ends = np.concatenate(([0.0], np.cumsum([s.length for s in path.segments])))
    cuts = [int(np.argmin(np.abs(ends[1:] - t))) + 1 for t in sharp]
    count = len(path.segments)
    if path.closed:
        runs = [
            [path.segments[k % count] for k in range(a, b if b > a else b + count)]
            for a, b in zip(cuts, [*cuts[1:], cuts[0]], strict=True)
        ]
        if cuts[-1] == count:
            # The path as drawn begins at such a corner.
            runs = [runs[-1], *runs[:-1]]
    else:
        edges = [0, *cuts, count]
        runs = [list(path.segments[a:b]) for a, b in itertools.pairwise(edges)]
    parts = [Path(run, False, path.name, path.join) for run in runs]
    return [Stroke(part, part.length, _bends(part, part.length, settings)) for part in parts]


def _bends(path: Path, length: float, settings: Settings) -> tuple[Bend, ...]:
    places = [c.travel for c in path.corners]
    if path.closed:
        places = [t + k * path.length for k in range(math.ceil(length / path.length)) for t in places]
    places = sorted(t for t in places if 1e-9 < t < length - 1e-9)
    found = []
    for k, t in enumerate(places):
        before = t - (places[k - 1] if k else 0.0)
        after = (places[k + 1] if k + 1 < len(places) else length) - t
        # Two corners share what lies between them; an end need not be shared.
        half = 0.5 * settings.blend
        half = min(half, before * (0.5 if k else 1.0), after * (0.5 if k + 1 < len(places) else 1.0))
        if half < 1e-6:
            continue
        start, end = (float(v) for v in path.at(np.array([t - half, t + half])).heading)
        found.append(Bend(t - half, t + half, start, end))
    return tuple(found)


MOST_SEGMENTS = 64
"""A rounding has at most so many."""
LONGEST = 50.0
"""And is at most so many tolerances long: above 20 deg, a longer one is further than that from its corner."""
LOOKS = 9
"""Places on each segment that are compared."""


def sharpened(path: Path, settings: Settings) -> Path:
    """The path with such roundings as corners; itself where it has none."""
    most = min(settings.blend, LONGEST * settings.tolerance)
    lengths = np.array([s.length for s in path.segments])
    if len(lengths) < 3 or not (lengths < most).any():
        return path
    whole, count = path, len(lengths)
    if path.closed:
        # A rounding may lie where the path begins: it is begun elsewhere.
        first = int(np.argmax(lengths))
        path = Path([*path.segments[first:], *path.segments[:first]], True, path.name, path.join)
        lengths = np.roll(lengths, -first)
    parts = [*path.segments, *path.segments[: path.closed]]
    along = _turns(path)
    made: list[Curve] = []
    k = 0
    edge = None
    while k < count:
        found = None
        if 0 < k < len(parts) - 1 and lengths[k] < most:
            found = _rounding(parts, k, most, settings, along)
        if found is None:
            segment = parts[k]
            if edge is not None:
                made.append(Line(edge, segment.start))
                edge = None
            made.append(segment)
            k += 1
            continue
        edge, k = found
        last = made[-1]
        made.append(Line(last.end, edge))
    if edge is not None:
        made.append(Line(edge, parts[-1].start))
    if len(made) == count and all(a is b for a, b in zip(made, path.segments, strict=True)):
        return whole
    return Path(_lines_joined(made), path.closed, path.name, path.join)


class _Turns(NamedTuple):
    """How a path turns."""

    starts: Array
    """Arc length where each segment begins, mm; the last: where the last one ends."""
    turns: Array
    """Of each segment and the joint behind it, deg."""
    joints: Array
    """Behind each segment, deg."""
    places: Array
    """Arc lengths of the ends of each segment, and of the lap before and behind where the path is closed."""
    headings: Array
    """Unwrapped, deg, there."""


def _turns(path: Path) -> _Turns:
    heads = np.array([s.headings for s in path.segments])
    starts = np.concatenate(([0.0], np.cumsum([s.length for s in path.segments])))
    joints = np.array([wrapped(b[0] - a[1]) for a, b in zip(heads, np.roll(heads, -1, axis=0), strict=True)])
    inner = heads[:, 1] - heads[:, 0]
    turns = inner + joints
    begin = np.concatenate(([0.0], np.cumsum(turns)[:-1]))
    places = np.column_stack((starts[:-1], starts[1:])).ravel()
    headings = np.column_stack((begin, begin + inner)).ravel()
    if path.closed:
        laps = np.arange(-1, 2)[:, None]
        places, headings = (places + laps * starts[-1]).ravel(), (headings + laps * turns.sum()).ravel()
    return _Turns(starts, turns, joints, places, headings)


def _rounding(
    parts: Sequence[Curve], k: int, most: float, settings: Settings, along: _Turns
) -> tuple[tuple[float, float], int] | None:
    """The corner for the longest rounding that begins with segment ``k``, and the segment behind it."""
    end = min(int(np.searchsorted(along.starts, along.starts[k] + most)), k + MOST_SEGMENTS, len(parts) - 1)
    if end <= k or np.abs(along.turns[k - 1 : end]).sum() <= settings.corner_angle:
        return None
    joints = np.abs(along.joints[k - 1 : end])
    turn = along.joints[k - 1] + np.cumsum(along.turns[k:end])
    size = along.starts[k + 1 : end + 1] - along.starts[k]
    # A hair off the ends: before and behind the joints there.
    here = along.starts[k]
    edges = (here - size, here - 1e-9, here + size + 1e-9, here + 2.0 * size)
    a, b, c, d = (np.interp(s, along.places, along.headings) for s in edges)
    sides = np.abs(b - a) + np.abs(d - c)
    good = (np.abs(turn) > settings.corner_angle) & (size < most) & (sides <= 0.25 * np.abs(turn))
    good &= np.maximum.accumulate(joints)[1:] <= settings.corner_angle
    for n in np.flatnonzero(good)[::-1]:
        stop = k + 1 + int(n)
        corner = _meet(parts[k - 1], parts[stop])
        if corner is not None and _apart(parts[k:stop], corner) <= settings.tolerance:
            return corner, stop
    return None


def _meet(before: Curve, after: Curve) -> tuple[float, float] | None:
    """Where the tangents of two segments meet, ahead of the one and behind the other."""
    (x, y), (u, v) = before.end, after.start
    a, b = math.radians(before.headings[1]), math.radians(after.headings[0])
    cross = math.sin(b - a)
    if abs(cross) < 1e-3:
        return None
    ahead = ((u - x) * math.sin(b) - (v - y) * math.cos(b)) / cross
    behind = ((u - x) * math.sin(a) - (v - y) * math.cos(a)) / cross
    if ahead < -1e-9 or behind > 1e-9:
        return None
    return x + ahead * math.cos(a), y + ahead * math.sin(a)


def _apart(run: Sequence[Curve], corner: tuple[float, float]) -> float:
    """How far a rounding and its corner are from each other, mm."""
    places = [s.at(np.linspace(0.0, s.length, LOOKS)) for s in run]
    points = np.concatenate([np.column_stack((p.x, p.y)) for p in places])
    away = np.full(len(points), np.inf)
    for end in (points[0], points[-1]):
        leg = np.array(corner) - end
        share = np.clip((points - end) @ leg / max(float(leg @ leg), 1e-300), 0.0, 1.0)
        away = np.minimum(away, np.hypot(*(points - end - share[:, None] * leg).T))
    return max(float(away.max()), float(np.hypot(*(points - corner).T).min()))


def _lines_joined(made: Sequence[Curve]) -> list[Curve]:
    """A line that goes on straight is one line."""
    found: list[Curve] = []
    for segment in made:
        last = found[-1] if found else None
        short = isinstance(segment, Line) and isinstance(last, Line)
        if short and abs(wrapped(segment.headings[0] - last.headings[1])) < 1e-4:  # type: ignore[union-attr]
            found[-1] = Line(last.start, segment.end)  # type: ignore[union-attr]
        else:
            found.append(segment)
    return found
