"""A path: segments one after the other, with the tangent angle unwrapped along all of them.

The heading is continuous where segments join smoothly; where the tangent jumps there is a :class:`Corner`, and the
heading goes on by the jump's shorter way round (half a turn counts as +180 deg). At a corner a place belongs to the
segment that follows. On a closed path the travel may run over several laps: each adds ``turn`` to the heading.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.paths.curve import Array, Curve, Places
from leadscrew.util.errors import ValueRefused

CORNER_DEG = 0.01
"""A jump of the tangent below this is rounding of coordinates, not a corner."""
JOIN_MM = 0.01
"""Gap between two segments that still counts as joined; the travel does not count it."""

SHORTEST_MM = 1e-9
"""What is shorter is a point: it has no tangent worth the name."""


class Corner(NamedTuple):
    """A place where the tangent jumps."""

    travel: float
    """Arc length of the place, mm."""
    turn_deg: float
    """Jump of the heading, deg, in (-180, 180]."""
    x: float
    y: float


class Sampled(NamedTuple):
    """Places at equal distances along a path, for a simulation or a controller."""

    travel: Array
    """Arc length of each, mm."""
    x: Array
    y: Array
    heading: Array
    """Deg, unwrapped."""
    curvature: Array
    """1/mm."""
    closed: bool
    turn: float
    """Deg that a lap adds to the heading; 0 on an open path."""


@dataclass(frozen=True, eq=False)
class Path:
    """Segments in the order in which they are cut.

    Segments are cut where their tangent jumps inside, and left out where they have no length.

    Raises:
        ValueRefused: no segment with a length, or a gap between two of them.
    """

    segments: Sequence[Curve]
    closed: bool = False
    name: str = ""
    join: float = JOIN_MM
    """Largest gap between segments, mm."""

    def __post_init__(self) -> None:
        pieces = tuple(p for s in self.segments for p in s.pieces() if p.length > SHORTEST_MM)
        if not pieces:
            raise ValueRefused(f"path {self.name!r}: expected one segment or more with a length above 0")
        object.__setattr__(self, "segments", pieces)
        ends = [s.end for s in pieces]
        followers = [s.start for s in pieces[1:]] + ([pieces[0].start] if self.closed else [])
        for k, (end, start) in enumerate(zip(ends, followers, strict=False)):
            gap = math.dist(end, start)
            if gap > self.join:
                raise ValueRefused(
                    f"path {self.name!r}: a gap of {gap:.6g} mm after segment {k + 1}, at ({end[0]:.6g}, "
                    f"{end[1]:.6g}); at most {self.join:g} mm counts as joined"
                )

    @cached_property
    def _starts(self) -> Array:
        return np.concatenate(([0.0], np.cumsum([s.length for s in self.segments])))

    @cached_property
    def _jumps(self) -> Array:
        """Jump of the tangent after each segment, deg; after the last, that to the first (0 on an open path)."""
        heads = [s.headings for s in self.segments]
        following = [*heads[1:], heads[0]]
        jumps = np.array([wrapped(b[0] - a[1]) for a, b in zip(heads, following, strict=True)])
        if not self.closed:
            jumps[-1] = 0.0
        return jumps

    @cached_property
    def _bases(self) -> Array:
        """What is added to the headings of each segment, deg; the last entry is the turn of the whole."""
        heads = np.array([s.headings for s in self.segments])
        starts = np.concatenate(([0.0], np.cumsum(heads[:, 1] - heads[:, 0] + self._jumps))) + wrapped(heads[0, 0])
        return np.append(starts[:-1] - heads[:, 0], starts[-1] - starts[0])

    @property
    def length(self) -> float:
        """Arc length, mm; of a closed path, of one lap."""
        return float(self._starts[-1])

    @property
    def turn(self) -> float:
        """Deg that a lap adds to the heading; 0 on an open path."""
        return float(self._bases[-1]) if self.closed else 0.0

    @property
    def corners(self) -> list[Corner]:
        """Where the tangent jumps by more than ``CORNER_DEG``; of a closed path the one at its start comes last."""
        found = []
        for segment, travel, turn in zip(self.segments, self._starts[1:], self._jumps, strict=True):
            if abs(turn) > CORNER_DEG:
                found.append(Corner(float(travel), float(turn), *segment.end))
        return found

    def at(self, travel: ArrayLike) -> Places:
        """Point, heading and curvature at arc lengths in mm.

        Raises:
            ValueRefused: a travel outside an open path, negative, or not finite.
        """
        asked = np.asarray(travel, dtype=np.float64)
        s = asked.ravel()
        rounding = 1e-9 * max(self.length, 1.0)
        if s.size and not (np.isfinite(s).all() and s.min() >= -rounding):
            raise ValueRefused(f"travel {s.min():g} mm on path {self.name!r}: expected finite numbers from 0 on")
        if not self.closed and s.size and s.max() > self.length + rounding:
            raise ValueRefused(
                f"travel {s.max():g} mm on path {self.name!r}: expected at most its length, {self.length:.6g} mm"
            )
        lap = np.floor(s / self.length) if self.closed else np.zeros(s.size)
        within = s - lap * self.length
        index = np.clip(np.searchsorted(self._starts, within, side="right") - 1, 0, len(self.segments) - 1)
        rows = np.empty((4, s.size))
        order = np.argsort(index, kind="stable")
        present, first = np.unique(index[order], return_index=True)
        for k, chosen in zip(present, np.split(order, first[1:]), strict=True):
            rows[:, chosen] = self.segments[k].at(within[chosen] - self._starts[k])
            rows[2, chosen] += self._bases[k]
        rows[2] += lap * self.turn
        x, y, heading, curvature = (r.reshape(asked.shape) for r in rows)
        return Places(x, y, heading, curvature)

    def reversed(self) -> Path:
        """The path run from its other end."""
        return Path([s.reversed() for s in reversed(self.segments)], self.closed, self.name, self.join)

    def transformed(self, matrix: ArrayLike) -> Path:
        """The path under an affine map, ``[[a, c, e], [b, d, f]]`` or 3 x 3."""
        linear = np.asarray(matrix, dtype=np.float64)[:2, :2]
        join = self.join * max(float(np.linalg.norm(linear, 2)), 1e-12)
        return Path([s.transformed(matrix) for s in self.segments], self.closed, self.name, join)


def sampled(path: Path, step_mm: float, laps: float = 1.0, whole: bool = False) -> Sampled:
    """Places each ``step_mm`` along a path, one at the start of each whole step: ``floor(laps * length / step_mm)``.

    ``laps`` (closed paths) may be a fraction. With ``whole`` the step is made a little shorter or longer so that a
    whole number of steps is one lap: such an array may be run round and round.

    Raises:
        ValueRefused: a step that is not positive or longer than the path, laps other than 1 on an open path.
    """
    if not (step_mm > 0.0 and math.isfinite(step_mm)) or step_mm > path.length:
        raise ValueRefused(f"step_mm = {step_mm:g}: expected above 0 and at most the path's length, {path.length:.6g}")
    if not (laps > 0.0 and math.isfinite(laps)) or (not path.closed and (laps != 1.0 or whole)):
        raise ValueRefused(f"laps = {laps:g}: expected a number above 0, and 1 on an open path")
    if whole:
        per_lap = max(round(path.length / step_mm), 1)
        travel: Array = np.arange(round(laps * per_lap), dtype=np.float64) * (path.length / per_lap)
    else:
        travel = np.arange(math.floor(laps * path.length / step_mm + 1e-9), dtype=np.float64) * step_mm
    return Sampled(travel, *path.at(travel), path.closed, path.turn)


def wrapped(degrees: float) -> float:
    """An angle in (-180, 180] deg; what is within rounding of -180 is 180."""
    found = -((-degrees + 180.0) % 360.0 - 180.0)
    return found + 360.0 if found < -180.0 + 1e-9 else found


def polyline(points: NDArray[np.float64], closed: bool = False, name: str = "") -> Path:
    """Straight lines through points (n, 2) in mm; a closed one ends where it began."""
    from leadscrew.paths.segments import Line

    rows = [(float(x), float(y)) for x, y in points]
    if closed:
        rows.append(rows[0])
    return Path([Line(a, b) for a, b in pairwise(rows)], closed, name)
