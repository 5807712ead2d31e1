"""A circular arc in place of a piece of a curve: through both of its ends, turning by as much as the curve does.

Between ``a`` and ``b`` with tangent angles ``phi_a`` and ``phi_b`` and a chord of length ``c`` in direction ``beta``

    sweep = phi_b - phi_a,    radius = c / (2 sin(sweep / 2)),    centre = middle + normal c / (2 tan(sweep / 2))

Its tangent at the arc length ``s`` from ``a`` is ``beta + sweep (s / l - 1/2)``. A knife whose axis turns evenly from
``phi_a`` to ``phi_b`` is therefore off the tangent of its own move by ``(phi_a + phi_b) / 2 - beta`` everywhere: some
``k' c^2 / 12`` for a curvature that changes by ``k'``, while on the chord it would be off by up to half the sweep.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.paths.arcs import Arc
from leadscrew.paths.curve import Array, Places

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
