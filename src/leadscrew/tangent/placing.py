"""Where a scanned piece lay: the turn and shift that bring its points back to the programmed line.

Least squares over pairs of points (Kabsch), without scale: a piece does not grow, and a wrong unit is to be seen.

What a scan cannot tell. A cut whose tangent is off by the same angle everywhere is the right piece, turned. Laid on the
programmed line by its own shape (``shape``), that angle is gone and is not compensated. Two marks on the sheet, pricked
by the machine at known places (``marks``), tell where the sheet lay, and so keep it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.errors import ValueRefused
from leadscrew.paths.curve import Array

LEAST_MM = 20.0
"""Two marks stand at least so far apart."""
MOST_MISS_MM = 1.0
"""Distances between marks agree to this."""


class Placing(NamedTuple):
    """A turn about the origin, then a shift: from scanned to programmed coordinates."""

    turn_deg: float
    dx: float
    dy: float

    def of(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Points in programmed coordinates, mm."""
        c, s = math.cos(math.radians(self.turn_deg)), math.sin(math.radians(self.turn_deg))
        return c * x - s * y + self.dx, s * x + c * y + self.dy


AS_IT_IS = Placing(0.0, 0.0, 0.0)


def fitted(scanned: Array, programmed: Array) -> Placing:
    """The placing that brings points (n, 2) closest to others."""
    a, b = scanned.mean(axis=0), programmed.mean(axis=0)
    p, q = scanned - a, programmed - b
    turn = math.atan2(float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()), float((p * q).sum()))
    c, s = math.cos(turn), math.sin(turn)
    return Placing(math.degrees(turn), float(b[0] - c * a[0] + s * a[1]), float(b[1] - s * a[0] - c * a[1]))


def by_marks(pairs: Sequence[tuple[float, float, float, float]]) -> Placing:
    """The placing by marks: programmed X, Y and scanned X, Y of each, mm.

    Raises:
        ValueRefused: fewer than two, too close together, or distances that do not agree.
    """
    rows = np.array(pairs, dtype=np.float64).reshape(-1, 4)
    if len(rows) < 2:
        raise ValueRefused(f"{len(rows)} mark: a turn takes two or more")
    programmed, scanned = rows[:, :2], rows[:, 2:]
    spread = max(math.dist(a, b) for a in programmed for b in programmed)
    if spread < LEAST_MM:
        raise ValueRefused(f"the marks are {spread:.3g} mm apart: expected {LEAST_MM:g} mm or more, to tell a turn")
    placing = fitted(scanned, programmed)
    x, y = placing.of(scanned[:, 0], scanned[:, 1])
    miss = float(np.hypot(x - programmed[:, 0], y - programmed[:, 1]).max())
    if miss > MOST_MISS_MM:
        raise ValueRefused(
            f"the scanned marks do not lie to each other as the programmed ones do: {miss:.3g} mm are left over; "
            "expected the same order, and the scan's true scale"
        )
    return placing
