"""From strokes to moves: lines stay lines, arcs stay arcs, other curves become arcs; every move has its words.

A move from ``a`` to ``b`` (arc lengths) turns the axis linearly, as LinuxCNC does on lines and arcs alike. It is halved
until

- the arc in place of a curve (below) is nowhere more than ``tolerance`` from it,
- its tangent is nowhere more than ``angle_tolerance`` from the curve's,
- the blade is nowhere more than ``angle_tolerance`` from ``phi(s) + d(s)``, heading and offset, and half of that from
  ``d(s)`` alone: it is what a program is read back with,

looked at in seven places of each move, the tangent at its ends too. The heading is the tangent of the curve itself.

**What remains.** A move shorter than ``LEAST_ARC_MM`` is a line, since four decimals do not tell its centre: the blade
is off such a line by up to half of what the curve turns there. Tangents are not asked for below twice that length.

**Feed limit.** A move whose axis would have to turn faster than ``swivel`` gets the feed ``swivel length / turn``, with
length and turn as they are written: rounded.

A circular arc in place of a piece of a curve: through both of its ends, turning by as much as the curve does.

Between ``a`` and ``b`` with tangent angles ``phi_a`` and ``phi_b`` and a chord of length ``c`` in direction ``beta``

    sweep = phi_b - phi_a,    radius = c / (2 sin(sweep / 2)),    centre = middle + normal c / (2 tan(sweep / 2))

Its tangent at the arc length ``s`` from ``a`` is ``beta + sweep (s / l - 1/2)``. A knife whose axis turns evenly from
``phi_a`` to ``phi_b`` is therefore off the tangent of its own move by ``(phi_a + phi_b) / 2 - beta`` everywhere: some
``k' c^2 / 12`` for a curvature that changes by ``k'``, while on the chord it would be off by up to half the sweep.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.paths.curve import Array, Places
from leadscrew.paths.segments import Arc, Line
from leadscrew.tangent.settings import ANGLE_DIGITS, Settings
from leadscrew.tangent.stroke import Stroke

MOST_RADIUS_MM = 1e4
"""An arc of a larger radius is written as a line."""
LEAST_ARC_MM = 0.05
"""A shorter arc is written as a line: its centre would be lost in the decimals."""
MOST_SWEEP_DEG = 120.0
"""No arc turns by more: close to a full turn its centre is badly told by its ends."""


class Fits(NamedTuple):
    """Arcs, or lines, through pairs of points: arrays of one length."""

    x: Array
    """Centre, mm; of a line any number."""
    y: Array
    radius: Array
    """In mm; 0: a line."""
    chord: Array
    """Direction from end to end, rad."""
    sweep: Array
    """In rad, counter-clockwise positive; 0: a line."""

    def across(self, at: Places, first: Places) -> Array:
        """Distance of points, mm: rows of places of one fit each; ``first``: where each begins."""
        line = (at.y - first.y[:, None]) * np.cos(self.chord)[:, None] - (at.x - first.x[:, None]) * np.sin(self.chord)[
            :, None
        ]
        away = np.hypot(at.x - self.x[:, None], at.y - self.y[:, None]) - self.radius[:, None]
        return np.abs(np.where(self.radius[:, None] > 0.0, away, line))

    def tangent(self, shares: Array) -> Array:
        """Its tangent angle, deg, at shares of its length: rows as in :meth:`across`."""
        return np.degrees(self.chord[:, None] + self.sweep[:, None] * (shares - 0.5))

    def arc(self, k: int, x: float, y: float) -> Arc | None:
        """One of them, that begins at a point; None: a line."""
        if self.radius[k] == 0.0:
            return None
        cx, cy = float(self.x[k]), float(self.y[k])
        return Arc((cx, cy), float(self.radius[k]), float(np.arctan2(y - cy, x - cx)), float(self.sweep[k]))


def fitted(first: Places, last: Places) -> Fits:
    """The arc of each pair of ends; a line where it would be too flat, too short, or turn too far."""
    dx, dy = last.x - first.x, last.y - first.y
    size = np.hypot(dx, dy)
    sweep = np.radians(last.heading - first.heading)
    half = 0.5 * np.clip(np.abs(sweep), 1e-12, np.radians(MOST_SWEEP_DEG))
    radius = 0.5 * size / np.sin(half)
    round_ = (radius <= MOST_RADIUS_MM) & (size >= LEAST_ARC_MM) & (np.abs(sweep) <= np.radians(MOST_SWEEP_DEG))
    away = np.sign(sweep) * 0.5 / np.tan(half)
    x, y = 0.5 * (first.x + last.x) - away * dy, 0.5 * (first.y + last.y) + away * dx
    return Fits(x, y, np.where(round_, radius, 0.0), np.arctan2(dy, dx), np.where(round_, sweep, 0.0))


LEAST_MM = 0.005
"""No move is made shorter than this."""
LOOKS = np.arange(1, 8) / 8.0
"""Where a move is looked at."""
SHARES = np.arange(9) / 8.0
"""The same, and its ends."""


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
    """In mm, as written: along the line or the arc through rounded ends."""
    turn: float
    """Of the blade, deg, as written."""
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
    fits = _fits(stroke, rows[:, 0], rows[:, 1])
    here, before = (float(begins.x[0]), float(begins.y[0])), round(before, ANGLE_DIGITS)
    for k, (a, b, index) in enumerate(rows):
        segment = stroke.path.segments[int(index)]
        arc = None
        if isinstance(segment, Arc) and _as_arc(segment):
            arc = segment if b - a >= LEAST_ARC_MM else None
        elif not isinstance(segment, Line):
            arc = fits.arc(k, *here)
        there = (float(ends.x[k]), float(ends.y[k]))
        length = _written(here, there, arc, settings)
        angle = float(angles[k])
        turn = round(angle, ANGLE_DIGITS) - before
        feed = min(feeds[k], 60.0 * settings.swivel * length / abs(turn)) if turn else feeds[k]
        found.append(Move(float(a), float(b), arc, *there, angle, float(offsets[k]), length, turn, float(feed)))
        here, before = there, round(angle, ANGLE_DIGITS)
    return found


def _written(here: tuple[float, float], there: tuple[float, float], arc: Arc | None, settings: Settings) -> float:
    """Length of a move between the places that the program says, mm."""
    (x, y), (u, v) = ([settings.rounded(q) for q in p] for p in (here, there))
    chord = math.hypot(u - x, v - y)
    if arc is None:
        return chord
    i, j = (settings.rounded(c - q) for c, q in zip(arc.centre, (x, y), strict=True))
    radius = math.hypot(i, j)
    turn = math.atan2(v - y - j, u - x - i) - math.atan2(-j, -i)
    return radius * (turn * math.copysign(1.0, arc.sweep) % (2.0 * math.pi))


def _fits(stroke: Stroke, low: Array, high: Array) -> Fits:
    """The arcs of moves, by the tangents of the path itself: a bend turns the blade, not the line."""
    first = _on_path(stroke, low)
    last = _on_path(stroke, high)
    # At a corner, the tangent of what comes before.
    before = _on_path(stroke, np.maximum(high - 1e-7, 0.0)).heading
    return fitted(first, last._replace(heading=np.where(np.abs(last.heading - before) > 1e-3, before, last.heading)))


def _on_path(stroke: Stroke, s: Array) -> Places:
    return stroke.path.at(s if stroke.path.closed else np.clip(s, 0.0, stroke.path.length))


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
    shift, slope = stroke.offset(low)[:, None], (stroke.offset(high) - stroke.offset(low))[:, None]
    good &= (np.abs(stroke.offset(looks) - shift - slope * LOOKS) <= 0.5 * settings.angle_tolerance).all(axis=1)
    segments = stroke.path.segments
    straight = np.array([isinstance(segments[int(k)], Line) for k in kind])
    round_ = np.array([isinstance(s := segments[int(k)], Arc) and _as_arc(s) for k in kind])
    radius = np.array([s.radius if isinstance(s := segments[int(k)], Arc) else 1.0 for k in kind])
    good &= ~round_ | (high - low <= math.radians(MOST_SWEEP_DEG) * radius)
    curved = np.flatnonzero(~(straight | round_))
    if curved.size:
        a, b = low[curved], high[curved]
        fits = _fits(stroke, a, b)
        at = _on_path(stroke, a[:, None] + (b - a)[:, None] * SHARES)
        near = (fits.across(at, Places(*(v[:, 0] for v in at))) <= settings.tolerance).all(axis=1)
        # The last tangent of a curve may be that of the segment behind its corner.
        off = np.abs((fits.tangent(SHARES) - at.heading + 180.0) % 360.0 - 180.0)[:, :-1]
        close = (off <= settings.angle_tolerance).all(axis=1) | (b - a < 2.0 * LEAST_ARC_MM)
        wide = np.abs(at.heading[:, -2] - at.heading[:, 0]) > MOST_SWEEP_DEG
        good[curved] &= near & close & ~wide
    return good


class Tight(NamedTuple):
    """A turn of the blade at depth, sharper than the corner rule has in mind."""

    x: float
    """Where it ends, mm."""
    y: float
    turn: float
    """deg."""
    length: float
    """mm."""


def tight_turns(moves: Sequence[Move], settings: Settings) -> list[Tight]:
    """Where a stroke turns by more than the corner angle within less than ``blend``, and more slowly on either side."""
    rate = settings.corner_angle / settings.blend
    found, turn, length = [], 0.0, 0.0
    for k, move in enumerate(moves):
        if abs(move.turn) > rate * move.length:
            turn, length = turn + move.turn, length + move.length
        last = k + 1 == len(moves) or not abs(moves[k + 1].turn) > rate * moves[k + 1].length
        if last:
            if settings.lifts(turn) and length < settings.blend:
                found.append(Tight(move.x, move.y, turn, length))
            turn = length = 0.0
    return found
