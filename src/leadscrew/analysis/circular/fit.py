"""The least-squares circle through points: the sum of squared distances to the circle is least.

    minimise  sum (d_i - r)^2,   d_i = sqrt((x_i - x_c)^2 + (y_i - y_c)^2)

Start: the algebraic circle of Kasa, linear in ``x_c``, ``y_c`` and ``r^2 - x_c^2 - y_c^2``; then Gauss-Newton with the
exact Jacobian ``(-(x - x_c)/d, -(y - y_c)/d, -1)``. Near the solution it converges in 2 to 4 steps, because the
residuals of a circular test are parts per million of the radius.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.errors import DataError

Floats = NDArray[np.float64]
MOST_STEPS = 50


class Circle(NamedTuple):
    """A circle in the unit of its points."""

    x: float
    y: float
    radius: float

    def distances(self, x: Floats, y: Floats) -> Floats:
        """How far points lie from the centre."""
        return np.hypot(x - self.x, y - self.y)


def least_squares_circle(x: Any, y: Any) -> Circle:
    """The circle with the least sum of squared distances to the points.

    Raises:
        DataError: fewer than three points, points on a line, or values that are not finite.
    """
    px, py = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if px.ndim != 1 or px.shape != py.shape:
        raise DataError(f"x and y of the points have the shapes {px.shape} and {py.shape}; expected two equal columns")
    if px.size < 3:
        raise DataError(f"{px.size} points make no circle; expected at least 3")
    if not (np.isfinite(px).all() and np.isfinite(py).all()):
        raise DataError("a point of the circle is not finite")
    # About their mean and in their own size, so that neither place nor unit costs digits.
    mean_x, mean_y = float(px.mean()), float(py.mean())
    size = float(np.max(np.hypot(px - mean_x, py - mean_y)))
    if size == 0.0:
        raise DataError("all points of the circle are the same")
    u, v = (px - mean_x) / size, (py - mean_y) / size
    design = np.column_stack((2.0 * u, 2.0 * v, np.ones_like(u)))
    found, _, rank, _ = np.linalg.lstsq(design, u * u + v * v, rcond=1e-12)
    if rank < 3:
        raise DataError("the points lie on a line and make no circle")
    cx, cy = float(found[0]), float(found[1])
    radius = float(np.sqrt(found[2] + cx * cx + cy * cy))
    for _ in range(MOST_STEPS):
        du, dv = u - cx, v - cy
        distance = np.hypot(du, dv)
        if not distance.all():
            raise DataError("a point lies on the centre of the circle")
        jacobian = np.column_stack((-du / distance, -dv / distance, -np.ones_like(u)))
        step = np.linalg.lstsq(jacobian, radius - distance, rcond=None)[0]
        cx, cy, radius = cx + float(step[0]), cy + float(step[1]), radius + float(step[2])
        if float(np.abs(step).max()) < 1e-15:
            break
    return Circle(mean_x + size * cx, mean_y + size * cy, size * radius)
