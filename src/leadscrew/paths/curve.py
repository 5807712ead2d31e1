"""What all plane curves have in common: arc length and its inverse, tangent angle and curvature, to rounding.

A curve is ``p(u)``, ``u`` from 0 to 1, with its derivatives in closed form. Then

``heading = atan2(y', x')``,  ``curvature = (x' y'' - y' x'') / |p'|^3``,  ``travel(u) = int_0^u |p'| du``

The integral is taken by Gauss-Legendre quadrature of 16 points on intervals that are halved until the tangent turns by
less than 0.35 rad on each half and both halves agree with the whole; ``travel(u)`` is inverted by Newton's method
inside a bracket. Nothing is flattened to a polyline, and no difference of points stands for a derivative.

Where ``p' = 0`` (control points that coincide) the tangent is that of the first higher derivative that is not zero.
Where the tangent jumps inside a curve (a cusp, a knot of full multiplicity), :meth:`Curve.pieces` cuts it in two.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.util.errors import ValueRefused

Array = NDArray[np.float64]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
BEND = 0.35
"""Turn of the tangent, rad, on half an interval of the quadrature."""
HALVINGS = 36
"""After so many an interval that still turns is a cusp."""
NOTHING = 1e-12
"""A curve of this size, mm, is a point."""
MANY = 4096
"""So many intervals at once are enough."""
FLAT = 1e-12
"""A derivative smaller than this share of the largest is no direction."""
FLAT_END = 1e-9
"""The same at the ends of a curve, which a cut at a cusp meets to rounding."""
AGREE = 1e-13
"""Agreement of the quadrature of a whole interval and its halves, as a share of the curve's size."""
JUMP = 1e-4
"""Jump of the tangent, rad, that is a corner inside a curve."""
NEAR = 1e-14
"""How far beside a parameter the limit from that side is taken."""
SHARPEST = 1e3
"""Bound of the curvature shown, 1/mm: at the end of a curve whose control points coincide it may be infinite."""
NEWTON = 60


class Places(NamedTuple):
    """Points of a curve: arrays of one shape."""

    x: Array
    """In mm."""
    y: Array
    """In mm."""
    heading: Array
    """Angle of the tangent in deg, counter-clockwise from +x, unwrapped along the curve."""
    curvature: Array
    """In 1/mm, positive to the left."""


class Table(NamedTuple):
    """The intervals of the quadrature."""

    u: Array
    """Parameters at their edges."""
    travel: Array
    """Arc length at their edges, mm."""
    heading: Array
    """Unwrapped angle at the start of each, rad."""
    end: float
    """Unwrapped angle at the end of the last, rad."""
    corners: tuple[float, ...]
    """Parameters inside the curve where the tangent jumps."""


class Curve(ABC):
    """A plane curve ``p(u)``, ``u`` in [0, 1], in mm."""

    @abstractmethod
    def derivative(self, u: Array, order: int) -> Array:
        """The derivative of ``order`` (0: the point) at each ``u``: shape (n, 2)."""

    @abstractmethod
    def part(self, first: float, last: float) -> Self:
        """The same curve from ``u = first`` to ``last``."""

    @abstractmethod
    def reversed(self) -> Self:
        """The same points, run from the other end."""

    @abstractmethod
    def transformed(self, matrix: ArrayLike) -> Curve:
        """The curve under an affine map ``[[a, c, e], [b, d, f]]``: ``x' = a x + c y + e``, ``y' = b x + d y + f``."""

    @property
    def breaks(self) -> Array:
        """Parameters inside the curve where some derivative jumps."""
        return np.empty(0)

    @property
    def length(self) -> float:
        """Arc length in mm."""
        return float(self.table.travel[-1])

    @property
    def start(self) -> tuple[float, float]:
        """The first point."""
        x, y = self.derivative(np.zeros(1), 0)[0]
        return float(x), float(y)

    @property
    def end(self) -> tuple[float, float]:
        """The last point."""
        x, y = self.derivative(np.ones(1), 0)[0]
        return float(x), float(y)

    @property
    def headings(self) -> tuple[float, float]:
        """Angle of the tangent at start and end in deg, the turn between them unwrapped."""
        return math.degrees(self.table.heading[0]), math.degrees(self.table.end)

    def at(self, travel: ArrayLike) -> Places:
        """Point, tangent angle and curvature at the arc lengths ``travel`` (mm); outside, the end is held."""
        asked = np.asarray(travel, dtype=np.float64)
        s = np.clip(asked.ravel(), 0.0, self.length)
        u, interval = self._parameter(s)
        p = self.derivative(u, 0)
        angle = self._direction(u, np.where(u < 1.0, 1.0, -1.0), 0.0)
        base = self.table.heading[interval]
        heading = np.degrees(base + _wrapped(angle - base))
        shape = asked.shape
        return Places(
            p[:, 0].reshape(shape), p[:, 1].reshape(shape), heading.reshape(shape), self._curvature(u).reshape(shape)
        )

    def pieces(self) -> list[Curve]:
        """The curve cut where its tangent jumps; itself where it does not."""
        cuts = self.table.corners
        if not cuts:
            return [self]
        return [self.part(a, b) for a, b in pairwise((0.0, *cuts, 1.0))]

    @cached_property
    def table(self) -> Table:
        """The quadrature, made once."""
        edges = np.unique(np.concatenate(([0.0], self.breaks, [1.0])))
        if self.scale <= NOTHING:
            return Table(np.array([0.0, 1.0]), np.zeros(2), np.zeros(1), 0.0, ())
        low, high = edges[:-1], edges[1:]
        good_low: list[Array] = []
        good: list[Array] = []
        sharp: list[Array] = []
        limit = AGREE * max(self.scale, 1e-300)
        for level in range(HALVINGS + 1):
            middle = 0.5 * (low + high)
            # One call for all: a call costs more than its numbers.
            angles = self._direction(np.concatenate((low, middle, high)), np.repeat([1.0, 1.0, -1.0], low.size))
            first, half, last = angles.reshape(3, -1)
            bend = np.maximum(np.abs(_wrapped(half - first)), np.abs(_wrapped(last - half)))
            left, right, whole = self._lengths(
                np.concatenate((low, middle, low)), np.concatenate((middle, high, high))
            ).reshape(3, -1)
            fine = (bend < BEND) & (np.abs(whole - left - right) <= limit)
            if level == HALVINGS or low.size > MANY:
                sharp.append(np.column_stack((low, high))[bend >= BEND])
                fine[:] = True
            good_low.append(low[fine])
            good.append(np.column_stack((high, left + right, first, first + _wrapped(last - first)))[fine])
            low, middle, high = low[~fine], middle[~fine], high[~fine]
            if not low.size:
                break
            low, high = np.concatenate((low, middle)), np.concatenate((middle, high))
        starts = np.concatenate(good_low)
        order = np.argsort(starts)
        highs, lengths, first, last = np.concatenate(good)[order].T
        turn = last - first
        jumps = _wrapped(first[1:] - last[:-1])
        jumps[np.abs(jumps) < 1e-12] = 0.0
        heading = first[0] + np.concatenate(([0.0], np.cumsum(turn[:-1] + jumps)))
        inner = highs[:-1][np.abs(jumps) > JUMP]
        corners = np.unique(np.concatenate([inner, *(self._cusps(rows) for rows in sharp if len(rows))]))
        return Table(
            np.concatenate((starts[order][:1], highs)),
            np.concatenate(([0.0], np.cumsum(lengths))),
            heading,
            float(heading[-1] + turn[-1]),
            tuple(float(c) for c in corners),
        )

    @cached_property
    def scale(self) -> float:
        """The largest speed ``|p'|`` on a coarse grid, mm."""
        return float(np.hypot(*self.derivative(np.linspace(0.0, 1.0, 33), 1).T).max())

    def _cusps(self, sharp: Array) -> Array:
        """Where the speed is zero near each group of adjacent intervals: Newton on ``p' . p'' = 0``."""
        low, high = sharp[np.argsort(sharp[:, 0])].T
        groups = np.flatnonzero(low[1:] > high[:-1]) + 1
        u = np.array([0.5 * (a[0] + b[-1]) for a, b in zip(np.split(low, groups), np.split(high, groups), strict=True)])
        for _ in range(4):
            d1, d2, d3 = (self.derivative(u, k) for k in (1, 2, 3))
            slope = np.sum(d2 * d2 + d1 * d3, axis=1)
            u = np.clip(u - np.where(slope > 0.0, np.sum(d1 * d2, axis=1) / np.maximum(slope, 1e-300), 0.0), 0.0, 1.0)
        return u[(u > 0.0) & (u < 1.0)]

    def _direction(self, u: Array, side: Array, near: float = NEAR) -> Array:
        """Angle of the tangent, rad, as the limit from the right (side 1) or from the left (-1)."""
        found = self.derivative(np.clip(u + side * near, 0.0, 1.0), 1)
        ends = u == np.where(side > 0.0, 0.0, 1.0)
        least = np.where(ends, FLAT_END, FLAT) * self.scale
        for order, step in enumerate((1e-11, 1e-8, 1e-5), start=2):
            flat = np.hypot(*found.T) <= least
            if not flat.any():
                break
            # At an end the next derivative; inside the flat place is left to its side.
            higher = self.derivative(u, order) * side[:, None] ** (order - 1)
            beside = self.derivative(np.clip(u + side * step, 0.0, 1.0), 1)
            found = np.where(flat[:, None], np.where(ends[:, None], higher, beside), found)
        return np.arctan2(found[:, 1], found[:, 0])

    def _curvature(self, u: Array) -> Array:
        d1, d2 = self.derivative(u, 1), self.derivative(u, 2)
        speed = np.hypot(*d1.T)
        flat = speed <= FLAT * self.scale
        if flat.any():
            # The limit is taken a little inside.
            inside = np.where(u[flat] < 0.5, u[flat] + 1e-6, u[flat] - 1e-6)
            d1[flat], d2[flat] = self.derivative(inside, 1), self.derivative(inside, 2)
            speed = np.hypot(*d1.T)
        bends = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
        return np.clip(bends / np.maximum(speed**3, 1e-300), -SHARPEST, SHARPEST)

    def _lengths(self, low: Array, high: Array) -> Array:
        """Arc length between parameters, by 16 points."""
        half = 0.5 * (high - low)
        u = (low + half)[:, None] + half[:, None] * NODES
        speed = np.hypot(*self.derivative(u.ravel(), 1).T).reshape(u.shape)
        return half * (speed @ WEIGHTS)

    def _parameter(self, s: Array) -> tuple[Array, NDArray[np.int64]]:
        """The parameter at each arc length, and its interval."""
        table = self.table
        interval = np.clip(np.searchsorted(table.travel, s, side="right") - 1, 0, len(table.heading) - 1)
        low, high = table.u[interval], table.u[interval + 1]
        left, right = table.travel[interval], table.travel[interval + 1]
        from_low, share = low.copy(), s - left
        with np.errstate(invalid="ignore", divide="ignore"):
            u = low + (high - low) * np.where(right > left, share / (right - left), 0.0)
        tolerance = 1e-13 * max(self.length, 1e-300)
        busy = np.flatnonzero((u > low) & (u < high))
        for _ in range(NEWTON):
            if not busy.size:
                break
            miss = self._lengths(from_low[busy], u[busy]) - share[busy]
            far = np.abs(miss) > tolerance
            busy, miss = busy[far], miss[far]
            if not busy.size:
                break
            high[busy] = np.where(miss > 0.0, u[busy], high[busy])
            low[busy] = np.where(miss < 0.0, u[busy], low[busy])
            speed = np.hypot(*self.derivative(u[busy], 1).T)
            with np.errstate(invalid="ignore", divide="ignore"):
                step = u[busy] - miss / speed
            inside = (step > low[busy]) & (step < high[busy])
            u[busy] = np.where(inside, step, 0.5 * (low[busy] + high[busy]))
        return u, interval


def _wrapped(angle: Array) -> Array:
    """In (-pi, pi]."""
    return -((-angle + math.pi) % (2.0 * math.pi) - math.pi)


def affine(matrix: ArrayLike) -> tuple[Array, Array]:
    """The linear part (2, 2) and the shift (2,) of an affine map given as 2 x 3 or 3 x 3."""
    whole = np.asarray(matrix, dtype=np.float64)
    if whole.shape not in ((2, 3), (3, 3)) or not np.isfinite(whole).all():
        raise ValueRefused(f"matrix of shape {whole.shape}: expected 2 x 3 or 3 x 3 finite numbers")
    return whole[:2, :2], whole[:2, 2]


def point(p: ArrayLike, what: str) -> tuple[float, float]:
    """A pair of finite numbers."""
    x, y = (float(v) for v in np.asarray(p, dtype=np.float64))
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueRefused(f"{what} = ({x:g}, {y:g}): expected finite coordinates in mm")
    return x, y
