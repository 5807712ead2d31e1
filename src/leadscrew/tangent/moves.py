"""From strokes to moves: lines stay lines, arcs stay arcs, other curves become chords; every move has its words.

A move from ``a`` to ``b`` (arc lengths) turns the axis linearly, as LinuxCNC does on lines and arcs alike. It is halved
until

- a chord of a curve is nowhere more than ``tolerance`` from it,
- the blade is nowhere more than ``angle_tolerance`` from ``phi(s) + d(s)``, heading and offset,

both looked at in seven places of each move. The heading is the tangent of the curve itself, never that of a chord.

**Feed limit.** A move whose axis would have to turn faster than ``swivel`` gets the feed ``swivel length / turn``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.paths.curve import Array
from leadscrew.paths.segments import Arc, Line
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke

LEAST_MM = 0.005
"""No move is made shorter than this."""
MOST_SWEEP = math.radians(120.0)
"""An arc that turns by more is cut in parts: close to a full turn its centre is badly told by its ends."""
LEAST_ARC_MM = 0.05
"""A shorter arc is written as a line: its centre would be lost in the decimals."""
MOST_RADIUS_MM = 1e4
"""An arc of a larger radius is written as chords."""
LOOKS = np.arange(1, 8) / 8.0
"""Where a move is looked at."""


class Move(NamedTuple):
    """One cutting move."""

    first: float
    """Arc length where it begins, mm."""
    last: float
    arc: Arc | None
    """The circle that it follows; None: a straight line."""
    x: float
    """Its end."""
    y: float
    angle: float
    """Of the blade at its end, deg: heading and offset."""
    offset: float
    """Of the axis at its end, deg."""
    length: float
    """In mm."""
    turn: float
    """Of the blade, deg."""
    feed: float
    """mm/min, lowered where the blade could not follow."""


def moves_of(stroke: Stroke, settings: Settings) -> list[Move]:
    """The cutting moves of a stroke, in order."""
    edges = stroke.edges
    kinds = _kinds(stroke, edges)
    low, high, kind = edges[:-1], edges[1:], kinds
    done: list[NDArray[np.float64]] = []
    while low.size:
        good = _good(stroke, settings, low, high, kind) | (high - low < 2.0 * LEAST_MM)
        done.append(np.column_stack((low, high, kind))[good])
        low, high, kind = low[~good], high[~good], kind[~good]
        middle = 0.5 * (low + high)
        low, high = np.concatenate((low, middle)), np.concatenate((middle, high))
        kind = np.concatenate((kind, kind))
    rows = np.concatenate(done)
    rows = rows[np.argsort(rows[:, 0])]
    ends = stroke.at(rows[:, 1])
    begins = stroke.at(rows[:1, 0])
    offsets = stroke.offset(rows[:, 1])
    angles = _left(stroke, rows[:, 1], ends.heading) + offsets
    before = float(begins.heading[0] + stroke.offset(rows[:1, 0])[0])
    found = []
    feeds = _feeds(stroke, settings, 0.5 * (rows[:, 0] + rows[:, 1]))
    for k, (a, b, index) in enumerate(rows):
        segment = stroke.path.segments[int(index)]
        arc = segment if isinstance(segment, Arc) and _as_arc(segment) and b - a >= LEAST_ARC_MM else None
        angle, length = float(angles[k]), float(b - a)
        turn = abs(angle - before)
        feed = min(feeds[k], 60.0 * settings.swivel * length / turn) if turn else feeds[k]
        found.append(
            Move(float(a), float(b), arc, float(ends.x[k]), float(ends.y[k]), angle, float(offsets[k]), length,
                 angle - before, float(feed))
        )  # fmt: skip
        before = angle
    return found


def _feeds(stroke: Stroke, settings: Settings, places: Array) -> Array:
    """Feeds as they are programmed, mm/min."""
    if stroke.feeds is None:
        return np.full(len(places), settings.feed)
    k = np.searchsorted(stroke.feeds.travel, places, side="right") - 1
    return stroke.feeds.value[np.clip(k, 0, len(stroke.feeds.value) - 1)]


def _as_arc(segment: Arc) -> bool:
    return segment.radius <= MOST_RADIUS_MM


def _kinds(stroke: Stroke, edges: Array) -> Array:
    """Index of the segment under the middle of each interval."""
    ends = np.cumsum([s.length for s in stroke.path.segments])
    middle = np.mod(0.5 * (edges[:-1] + edges[1:]), ends[-1])
    return np.minimum(np.searchsorted(ends, middle, side="right"), len(ends) - 1).astype(np.float64)


def _left(stroke: Stroke, s: Array, heading: Array) -> Array:
    """Heading at the end of a move: at a corner too small to be turned over a length, that of what comes before."""
    before = stroke.at(np.maximum(s - 1e-7, 0.0)).heading
    return np.where(np.abs(heading - before) > 1e-3, before, heading)


def _good(stroke: Stroke, settings: Settings, low: Array, high: Array, kind: Array) -> NDArray[np.bool_]:
    """Whether moves between these arc lengths are within the tolerances."""
    looks = low[:, None] + (high - low)[:, None] * LOOKS
    inside = stroke.at(looks)
    first, last = stroke.at(low), stroke.at(high)
    begin = first.heading + stroke.offset(low)
    end = _left(stroke, high, last.heading) + stroke.offset(high)
    asked = inside.heading + stroke.offset(looks)
    given = begin[:, None] + (end - begin)[:, None] * LOOKS
    good = (np.abs(asked - given) <= settings.angle_tolerance).all(axis=1)
    segments = stroke.path.segments
    straight = np.array([isinstance(segments[int(k)], Line) for k in kind])
    round_ = np.array([isinstance(s := segments[int(k)], Arc) and _as_arc(s) for k in kind])
    radius = np.array([s.radius if isinstance(s := segments[int(k)], Arc) else 1.0 for k in kind])
    good &= ~round_ | (high - low <= MOST_SWEEP * radius)
    chord = ~(straight | round_)
    if chord.any():
        dx, dy = last.x - first.x, last.y - first.y
        size = np.maximum(np.hypot(dx, dy), 1e-12)
        across = (inside.x - first.x[:, None]) * (-dy / size)[:, None] + (inside.y - first.y[:, None]) * (dx / size)[
            :, None
        ]
        good &= ~chord | (np.abs(across) <= settings.tolerance).all(axis=1)
    return good
