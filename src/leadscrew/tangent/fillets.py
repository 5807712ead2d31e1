"""Corners in disguise: a rounding so small that a sharp corner in its place is the same line, to the tolerance.

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

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from leadscrew.paths.curve import Array, Curve
from leadscrew.paths.path import Path, wrapped
from leadscrew.paths.segments import Line
from leadscrew.tangent.settings import Settings

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
