"""The segments of a path: line, circular arc, elliptic arc, Bezier curve, B-spline (NURBS).

Each has exact derivatives; length, its inverse, tangent and curvature follow in :mod:`leadscrew.paths.curve`, for line
and arc in closed form.

Segments of constant curvature, and what an affine map makes of them: line, circular arc, elliptic arc.

Lengths are in mm, angles of the fields in rad, counter-clockwise positive.

Segments from control points: Bezier curve and B-spline (with weights a NURBS).

Their derivatives are exact: of a Bezier curve by Bernstein polynomials, of a B-spline by SciPy's ``BSpline``, of a
NURBS by the rule for quotients on top of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.paths.curve import Array, Curve, Places, Table, affine, point
from leadscrew.util.errors import ValueRefused

SIMILAR = 1e-12
"""How far an affine map may be from a similarity for an arc to stay a circular arc."""


class _Uniform(Curve):
    """A curve of constant speed and constant curvature: line and arc."""

    def _ends(self) -> tuple[float, float, float]:
        """Length, first and last heading in rad."""
        raise NotImplementedError

    @cached_property
    def table(self) -> Table:
        """One interval; exact."""
        length, first, last = self._ends()
        return Table(np.array([0.0, 1.0]), np.array([0.0, length]), np.array([first]), last, ())

    def _parameter(self, s: Array) -> tuple[Array, NDArray[np.int64]]:
        whole = self.length
        return (s / whole if whole > 0.0 else np.zeros_like(s)), np.zeros(s.shape, dtype=np.int64)

    def at(self, travel: ArrayLike) -> Places:
        """As :meth:`leadscrew.paths.curve.Curve.at`."""
        length, first, last = self._ends()
        asked = np.asarray(travel, dtype=np.float64)
        u = np.clip(asked.ravel(), 0.0, length) / length if length > 0.0 else np.zeros(asked.size)
        p = self.derivative(u, 0)
        bend = (last - first) / length if length > 0.0 else 0.0
        return Places(
            p[:, 0].reshape(asked.shape),
            p[:, 1].reshape(asked.shape),
            np.degrees(first + (last - first) * u).reshape(asked.shape),
            np.full(asked.shape, bend),
        )


@dataclass(frozen=True, eq=False)
class Line(_Uniform):
    """A straight line from ``first`` to ``last``."""

    first: tuple[float, float]
    last: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "first", point(self.first, "first point of a line"))
        object.__setattr__(self, "last", point(self.last, "last point of a line"))

    def _ends(self) -> tuple[float, float, float]:
        dx, dy = self.last[0] - self.first[0], self.last[1] - self.first[1]
        angle = math.atan2(dy, dx)
        return math.hypot(dx, dy), angle, angle

    def derivative(self, u: Array, order: int) -> Array:
        """See :meth:`Curve.derivative`."""
        a, b = np.array(self.first), np.array(self.last)
        if order == 0:
            # The two ends come out exactly.
            return a * (1.0 - u[:, None]) + b * u[:, None]
        return np.broadcast_to(b - a if order == 1 else np.zeros(2), (u.size, 2)).copy()

    def part(self, first: float, last: float) -> Line:
        """See :meth:`Curve.part`."""
        a, b = self.derivative(np.array([first, last]), 0)
        return Line((a[0], a[1]), (b[0], b[1]))

    def reversed(self) -> Line:
        """See :meth:`Curve.reversed`."""
        return Line(self.last, self.first)

    def transformed(self, matrix: ArrayLike) -> Line:
        """See :meth:`Curve.transformed`."""
        linear, shift = affine(matrix)
        a, b = linear @ self.first + shift, linear @ self.last + shift
        return Line((a[0], a[1]), (b[0], b[1]))


@dataclass(frozen=True, eq=False)
class Arc(_Uniform):
    """A circular arc ``centre + radius (cos a, sin a)``, ``a`` from ``angle`` by ``sweep`` (negative: clockwise)."""

    centre: tuple[float, float]
    radius: float
    angle: float
    sweep: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", point(self.centre, "centre of an arc"))
        if not (self.radius > 0.0 and math.isfinite(self.radius + self.angle + self.sweep)):
            raise ValueRefused(
                f"arc of radius {self.radius:g} mm, angle {self.angle:g}, sweep {self.sweep:g} rad: expected a radius "
                "above 0 and finite angles"
            )

    def _ends(self) -> tuple[float, float, float]:
        first = self.angle + math.copysign(0.5 * math.pi, self.sweep)
        return self.radius * abs(self.sweep), first, first + self.sweep

    def derivative(self, u: Array, order: int) -> Array:
        """See :meth:`Curve.derivative`."""
        a = self.angle + self.sweep * u + 0.5 * math.pi * order
        around = self.radius * self.sweep**order * np.column_stack((np.cos(a), np.sin(a)))
        return around + self.centre if order == 0 else around

    def part(self, first: float, last: float) -> Arc:
        """See :meth:`Curve.part`."""
        return Arc(self.centre, self.radius, self.angle + self.sweep * first, self.sweep * (last - first))

    def reversed(self) -> Arc:
        """See :meth:`Curve.reversed`."""
        return Arc(self.centre, self.radius, self.angle + self.sweep, -self.sweep)

    def transformed(self, matrix: ArrayLike) -> Arc | EllipseArc:
        """An arc under a similarity (mirrored too), else the arc of an ellipse; see :meth:`Curve.transformed`."""
        linear, shift = affine(matrix)
        (a, c), (b, d) = linear
        size = math.hypot(a, b)
        mirror = -1.0 if a * d - b * c < 0.0 else 1.0
        if math.hypot(c + mirror * b, d - mirror * a) > SIMILAR * size or size == 0.0:
            return self._ellipse().transformed(matrix)
        x, y = linear @ self.centre + shift
        turn = math.atan2(b, a)
        return Arc((x, y), self.radius * size, turn + mirror * self.angle, mirror * self.sweep)

    def _ellipse(self) -> EllipseArc:
        return EllipseArc(self.centre, (self.radius, 0.0), (0.0, self.radius), self.angle, self.sweep)


@dataclass(frozen=True, eq=False)
class EllipseArc(Curve):
    """The arc of an ellipse ``centre + first cos a + second sin a``, ``a`` from ``angle`` on by ``sweep`` (rad).

    ``first`` and ``second`` are conjugate half diameters: they need not stand at right angles, so an affine map of the
    arc maps just them.
    """

    centre: tuple[float, float]
    first: tuple[float, float]
    second: tuple[float, float]
    angle: float
    sweep: float

    def __post_init__(self) -> None:
        for name in ("centre", "first", "second"):
            object.__setattr__(self, name, point(getattr(self, name), f"{name} of an elliptic arc"))
        if not math.isfinite(self.angle + self.sweep):
            raise ValueRefused(f"elliptic arc from {self.angle:g} by {self.sweep:g} rad: expected finite angles")

    @property
    def breaks(self) -> Array:
        """Quarters of the ellipse: the quadrature starts from these."""
        count = max(math.ceil(abs(self.sweep) / (0.5 * math.pi)), 1)
        return np.arange(1, count) / count

    def derivative(self, u: Array, order: int) -> Array:
        """See :meth:`Curve.derivative`."""
        a = (self.angle + self.sweep * u + 0.5 * math.pi * order)[:, None]
        around = self.sweep**order * (np.cos(a) * self.first + np.sin(a) * self.second)
        return around + self.centre if order == 0 else around

    def part(self, first: float, last: float) -> EllipseArc:
        """See :meth:`Curve.part`."""
        return replace(self, angle=self.angle + self.sweep * first, sweep=self.sweep * (last - first))

    def reversed(self) -> EllipseArc:
        """See :meth:`Curve.reversed`."""
        return replace(self, angle=self.angle + self.sweep, sweep=-self.sweep)

    def transformed(self, matrix: ArrayLike) -> EllipseArc:
        """See :meth:`Curve.transformed`."""
        linear, shift = affine(matrix)
        return EllipseArc(
            point(linear @ self.centre + shift, "centre"),
            point(linear @ self.first, "half diameter"),
            point(linear @ self.second, "half diameter"),
            self.angle,
            self.sweep,
        )


def circular(arc: EllipseArc) -> Arc | EllipseArc:
    """The circular arc that an elliptic one is, where its half diameters are equal and at right angles; else itself."""
    (a, b), (c, d) = arc.first, arc.second
    size = math.hypot(a, b)
    way = 1.0 if a * d - b * c > 0.0 else -1.0
    if size == 0.0 or math.hypot(c + way * b, d - way * a) > SIMILAR * size:
        return arc
    return Arc(arc.centre, size, math.atan2(b, a) + way * arc.angle, way * arc.sweep)


@dataclass(frozen=True, eq=False)
class Bezier(Curve):
    """A Bezier curve of any degree from its control points (n, 2)."""

    points: NDArray[np.float64]
    _hodographs: list[Array] = field(default_factory=list, init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _control(self.points, 2, "a Bezier curve"))

    @classmethod
    def quadratic(cls, first: ArrayLike, control: ArrayLike, last: ArrayLike) -> Bezier:
        """The quadratic curve, as the cubic that is the same curve."""
        a, b, c = (np.asarray(p, dtype=np.float64) for p in (first, control, last))
        return cls(np.array([a, a + (b - a) * (2.0 / 3.0), c + (b - c) * (2.0 / 3.0), c]))

    def derivative(self, u: Array, order: int) -> Array:
        """See :meth:`Curve.derivative`; by Bernstein polynomials."""
        points = self._hodograph(order)
        degree = len(points) - 1
        if degree < 0:
            return np.zeros((u.size, 2))
        v = 1.0 - u
        rows = [math.comb(degree, k) * v ** (degree - k) * u**k for k in range(degree + 1)]
        found: Array = np.array(rows).T @ points
        return found

    def _hodograph(self, order: int) -> Array:
        """Control points of the derivative of some order."""
        while len(self._hodographs) <= order:
            last = self._hodographs[-1] if self._hodographs else None
            self._hodographs.append(self.points if last is None else (len(last) - 1) * np.diff(last, axis=0))
        return self._hodographs[order]

    def part(self, first: float, last: float) -> Bezier:
        """See :meth:`Curve.part`; exact, by the polar form."""
        degree = len(self.points) - 1
        return Bezier(np.array([_blossom(self.points, [first] * (degree - k) + [last] * k) for k in range(degree + 1)]))

    def reversed(self) -> Bezier:
        """See :meth:`Curve.reversed`."""
        return Bezier(self.points[::-1])

    def transformed(self, matrix: ArrayLike) -> Bezier:
        """See :meth:`Curve.transformed`."""
        linear, shift = affine(matrix)
        return Bezier(self.points @ linear.T + shift)


@dataclass(frozen=True, eq=False)
class Spline(Curve):
    """A B-spline from its control points (n, 2), knots (n + degree + 1) and degree; with weights a NURBS."""

    points: NDArray[np.float64]
    knots: NDArray[np.float64]
    degree: int = 3
    weights: NDArray[np.float64] | None = None
    _splines: dict[int, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        points = _control(self.points, self.degree + 1, f"a spline of degree {self.degree}")
        knots = np.array(self.knots, dtype=np.float64)
        count = len(points) + self.degree + 1
        if knots.shape != (count,) or not np.isfinite(knots).all() or (np.diff(knots) < 0.0).any():
            raise ValueRefused(
                f"a spline of degree {self.degree} with {len(points)} control points: expected {count} finite knots "
                f"in rising order, got {knots.size}"
            )
        if not knots[self.degree] < knots[len(points)]:
            raise ValueRefused("a spline whose knots are all equal has no length")
        if self.weights is not None:
            weights = np.array(self.weights, dtype=np.float64)
            if weights.shape != (len(points),) or not (np.isfinite(weights).all() and (weights > 0.0).all()):
                raise ValueRefused(f"a spline of {len(points)} control points: expected as many weights above 0")
            object.__setattr__(self, "weights", None if np.ptp(weights) == 0.0 else weights)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "knots", knots)

    @property
    def _range(self) -> tuple[float, float]:
        """First and last parameter in knot units."""
        return float(self.knots[self.degree]), float(self.knots[len(self.points)])

    @property
    def breaks(self) -> Array:
        """The knots inside."""
        low, high = self._range
        u = (np.unique(self.knots) - low) / (high - low)
        return u[(u > 1e-12) & (u < 1.0 - 1e-12)]

    def _homogeneous(self, order: int) -> Any:
        """The spline of ``w x, w y, w`` (without weights ``x, y``), or its derivative."""
        if order not in self._splines:
            from scipy.interpolate import BSpline

            if order == 0:
                w = self.weights
                rows = self.points if w is None else np.column_stack((self.points * w[:, None], w))
                self._splines[0] = BSpline(self.knots, rows, self.degree)
            else:
                self._splines[order] = self._homogeneous(0).derivative(order)
        return self._splines[order]

    def derivative(self, u: Array, order: int) -> Array:
        """See :meth:`Curve.derivative`."""
        low, high = self._range
        v = np.clip(low + (high - low) * u, low, high)
        if self.weights is None:
            if order > self.degree:
                return np.zeros((u.size, 2))
            return np.asarray(self._homogeneous(order)(v)) * (high - low) ** order
        rows = [
            np.asarray(self._homogeneous(k)(v)) if k <= self.degree else np.zeros((u.size, 3)) for k in range(order + 1)
        ]
        found: list[Array] = []
        for k in range(order + 1):
            top = rows[k][:, :2].copy()
            for i in range(1, k + 1):
                top -= math.comb(k, i) * rows[i][:, 2:] * found[k - i]
            found.append(top / rows[0][:, 2:])
        return found[order] * (high - low) ** order

    def part(self, first: float, last: float) -> Spline:
        """See :meth:`Curve.part`; by knot insertion."""
        low, high = self._range
        whole = self._homogeneous(0)
        edges = []
        for u in (first, last):
            knot = low + (high - low) * u
            near = whole.t[np.argmin(np.abs(whole.t - knot))]
            knot = float(near) if abs(near - knot) <= 1e-12 * (high - low) else knot
            missing = self.degree - int(np.count_nonzero(whole.t == knot))
            if missing > 0:
                whole = whole.insert_knot(knot, missing)
            edges.append(knot)
        start = int(np.searchsorted(whole.t, edges[0], side="right")) - 1 - self.degree
        stop = int(np.searchsorted(whole.t, edges[1], side="left"))
        inner = whole.t[(whole.t > edges[0]) & (whole.t < edges[1])]
        knots = np.concatenate(([edges[0]] * (self.degree + 1), inner, [edges[1]] * (self.degree + 1)))
        rows = whole.c[start:stop]
        if self.weights is None:
            return Spline(rows, knots, self.degree)
        return Spline(rows[:, :2] / rows[:, 2:], knots, self.degree, rows[:, 2])

    def reversed(self) -> Spline:
        """See :meth:`Curve.reversed`; control points and knots are mirrored."""
        weights = None if self.weights is None else self.weights[::-1]
        return Spline(self.points[::-1], (self.knots[0] + self.knots[-1] - self.knots)[::-1], self.degree, weights)

    def transformed(self, matrix: ArrayLike) -> Spline:
        """See :meth:`Curve.transformed`."""
        linear, shift = affine(matrix)
        return replace(self, points=self.points @ linear.T + shift)


def _control(points: ArrayLike, least: int, what: str) -> Array:
    found = np.array(points, dtype=np.float64)
    if found.ndim != 2 or found.shape[1] != 2 or len(found) < least or not np.isfinite(found).all():
        raise ValueRefused(f"control points of {what}: expected {least} or more pairs of finite numbers in mm")
    return found


def _blossom(points: Array, at: list[float]) -> Array:
    """The polar form of a Bezier curve."""
    rows = points
    for u in at:
        rows = rows[:-1] * (1.0 - u) + rows[1:] * u
    found: Array = rows[0]
    return found
