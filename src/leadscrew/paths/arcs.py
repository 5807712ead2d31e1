"""Segments of constant curvature, and what an affine map makes of them: line, circular arc, elliptic arc.

Lengths are in mm, angles of the fields in rad, counter-clockwise positive.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.kernel.errors import ValueRefused
from leadscrew.paths.curve import Array, Curve, Places, Table, affine, point

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
