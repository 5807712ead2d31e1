"""The three paths of the study ``sofnn_tangent``: the paper gives no path data, these are reconstructed.

They stand for its Fig. 5 (a wave that stays inside +-90 deg) and for what its method must also cut: a closed path with
inflections, and one whose curvature jumps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.paths.curve import Array, Curve, affine
from leadscrew.paths.path import Path
from leadscrew.paths.segments import Arc, Line, Spline
from leadscrew.util.errors import ValueRefused

WAVE = (
    *((0, 0), (25, 55), (60, 60), (80, 10), (105, -35), (150, -30), (160, 20)),
    *((175, 65), (225, 60), (240, 15), (270, -5), (310, 0)),
)
"""Control polygon of the wave, mm."""


@dataclass(frozen=True, eq=False)
class Rosette(Curve):
    """The polar curve ``r = radius + amplitude cos(lobes a)``, ``a`` from ``angle`` by ``sweep``, affinely mapped."""

    radius: float
    amplitude: float
    lobes: int
    angle: float = 0.0
    sweep: float = 2.0 * math.pi
    matrix: NDArray[np.float64] = field(default_factory=lambda: np.eye(2, 3))

    @property
    def breaks(self) -> Array:
        """Quarters of the lobes."""
        count = max(math.ceil(abs(self.sweep) * max(abs(self.lobes), 1) / (0.5 * math.pi)), 1)
        return np.arange(1, count) / count

    def derivative(self, u: Array, order: int) -> Array:
        """See :meth:`Curve.derivative`: ``r e^(ia)`` is a sum of exponentials."""
        a = self.angle + self.sweep * u
        total = np.zeros(u.size, dtype=np.complex128)
        half = 0.5 * self.amplitude
        for size, rate in ((self.radius, 1), (half, 1 + self.lobes), (half, 1 - self.lobes)):
            total += size * (1j * rate * self.sweep) ** order * np.exp(1j * rate * a)
        flat = np.column_stack((total.real, total.imag)) @ self.matrix[:, :2].T
        return flat + self.matrix[:, 2] if order == 0 else flat

    def part(self, first: float, last: float) -> Rosette:
        """See :meth:`Curve.part`."""
        return replace(self, angle=self.angle + self.sweep * first, sweep=self.sweep * (last - first))

    def reversed(self) -> Rosette:
        """See :meth:`Curve.reversed`."""
        return replace(self, angle=self.angle + self.sweep, sweep=-self.sweep)

    def transformed(self, matrix: ArrayLike) -> Rosette:
        """See :meth:`Curve.transformed`."""
        linear, shift = affine(matrix)
        old = self.matrix
        return replace(self, matrix=np.column_stack((linear @ old[:, :2], linear @ old[:, 2] + shift)))


def wave() -> Path:
    """An open wave of 461 mm: a clamped uniform cubic B-spline; smallest radius 16.5 mm, tangent -65 to 76 deg."""
    return Path([clamped_spline(np.array(WAVE, dtype=np.float64))], name="wave")


def clamped_spline(points: NDArray[np.float64], degree: int = 3) -> Spline:
    """The uniform B-spline that starts at the first control point and ends at the last."""
    inner = np.arange(1, len(points) - degree, dtype=np.float64)
    last = float(len(points) - degree)
    return Spline(points, np.concatenate((np.zeros(degree + 1), inner, np.full(degree + 1, last))), degree)


def flower(radius: float = 50.0, amplitude: float = 11.0, lobes: int = 5) -> Path:
    """The closed path ``r = radius + amplitude cos(lobes a)`` mm, counter-clockwise from the tip of a lobe."""
    if not 0.0 <= amplitude < radius:
        raise ValueRefused(f"amplitude = {amplitude:g}: expected from 0 to less than the radius, {radius:g} mm")
    return Path([Rosette(radius, amplitude, lobes)], closed=True, name="flower")


def rounded_rectangle(width: float = 100.0, height: float = 60.0, radius: float = 10.0) -> Path:
    """A closed rectangle with filleted corners, counter-clockwise from the start of its lower side, at (radius, 0)."""
    if not 0.0 < 2.0 * radius <= min(width, height):
        raise ValueRefused(
            f"radius = {radius:g}: expected above 0 and at most half of {min(width, height):g} mm, the shorter side"
        )
    r, w, h = radius, width, height
    lines = [((r, 0.0), (w - r, 0.0)), ((w, r), (w, h - r)), ((w - r, h), (r, h)), ((0.0, h - r), (0.0, r))]
    centres = [(w - r, r), (w - r, h - r), (r, h - r), (r, r)]
    segments: list[Curve] = []
    for k, ((a, b), centre) in enumerate(zip(lines, centres, strict=True)):
        segments += [Line(a, b), Arc(centre, r, (k - 1) * 0.5 * math.pi, 0.5 * math.pi)]
    return Path(segments, closed=True, name="rounded rectangle")
