"""Segments from control points: Bezier curve and B-spline (with weights a NURBS).

Their derivatives are exact: of a Bezier curve by Bernstein polynomials, of a B-spline by SciPy's ``BSpline``, of a
NURBS by the rule for quotients on top of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.kernel.errors import ValueRefused
from leadscrew.paths.curve import Array, Curve, affine


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
