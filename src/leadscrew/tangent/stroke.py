"""What a knife does from its plunge to its lift: a line, the heading that is programmed along it, and offsets.

**Corner rule.** Where the tangent of a path jumps by more than the corner angle the knife is lifted, turned and
plunged: a stroke ends and another begins; a rounding that is one to the tolerance counts as a corner
(:mod:`leadscrew.tangent.fillets`). A smaller jump is turned in the material: over the length ``blend``, half
of it on either side (less where the next corner or an end is near), the programmed heading goes linearly from the one
to the other. A closed path without a corner of the first kind is one closed stroke, and may be cut on beyond its start
(overcut) so that the ends meet; any other starts at such a corner.

Source of the rule: common practice of tangential cutters (tcnc, GRBL-Plotter: 15 to 30 deg).
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

from leadscrew.kernel.errors import DataError
from leadscrew.paths.curve import Array, Places
from leadscrew.paths.path import Path
from leadscrew.paths.segments import Line
from leadscrew.tangent.settings import Settings

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
    from leadscrew.tangent.fillets import sharpened

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
