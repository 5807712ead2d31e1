"""What happens at the reversals of the axes: quadrant glitches, measured point by point.

Each axis reverses twice a turn, at its + and its - end. From the radial deviation about the set-up centre around a
reversal, outwards positive, with ``psi`` the angle in the direction of travel:

- **smooth path**: ``a + b sin psi + c cos psi + d sin 2 psi + e cos 2 psi``, plus ``step cos psi`` behind the reversal
  (what centring, scale, squareness, servo mismatch and play draw there), fitted by least squares from 10 to 35 degrees
  on both sides of the reversal: the path without a glitch; cyclic error that the diagnosis found is taken off first;
- **step** (reversal step): of that fit; play, with its sign;
- **height**: the largest excursion from the smooth path behind the reversal, in abs(psi) up to ``ZONE``, with its sign;
- **duration**: from the reversal until the path comes back within 10 % of the height (or within three standard
  deviations of the fit, if that is more) and stays there to the end of the zone.

The peak lies between points: at 1,000 mm/min on a radius of 100 mm a point comes every 21 ms. Take more points a turn
for a glitch of a servo that recovers faster.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import TURN, CircularTest, Floats, Turn

ZONE = math.radians(10.0)
REACH = math.radians(35.0)
SEEN = 5.0
"""Standard deviations of the fit that a peak must have, and at least :data:`LEAST_UM`."""
LEAST_UM = 0.001
BACK = 0.1
"""Part of the height at which the glitch counts as over."""


class Reversal(NamedTuple):
    """One reversal of one axis in one direction of travel."""

    axis: str
    end: str
    """``+`` or ``-``: at which end of its travel the axis turns."""
    direction: str
    angle_deg: float
    height_um: float
    """Peak behind the reversal, outwards positive."""
    step_um: float
    """Radial step at the reversal, outwards positive."""
    duration_deg: float | None
    """None: no peak above the scatter, or not over within the zone."""
    duration_s: float | None
    scatter_um: float
    """Standard deviation of the smooth path's fit."""

    @property
    def seen(self) -> bool:
        """Whether the peak stands out of the scatter."""
        return abs(self.height_um) > max(SEEN * self.scatter_um, LEAST_UM)


def reversals(test: CircularTest, cyclic_um: Sequence[Floats] | None = None) -> list[Reversal]:
    """The four reversals of each direction, in the order of their angles; none where points are too far apart.

    ``cyclic_um``: what cyclic errors draw at the points of each turn, to be taken off.
    """
    found = []
    for i, turn in enumerate(test.turns):
        if turn.spacing > 0.2 * ZONE:
            continue
        deviation = turn.deviation_um(test.radius_mm) - (0.0 if cyclic_um is None else cyclic_um[i])
        for quarter in range(4):
            axis, end = test.axes[quarter % 2], "+" if quarter < 2 else "-"
            found.append(_one(turn, deviation, quarter, axis, end, test.degrees_per_second))
    return found


def _one(
    turn: Turn, deviation: Floats, quarter: int, axis: str, end: str, degrees_per_second: float | None
) -> Reversal:
    at = 0.5 * math.pi * quarter
    psi = turn.sign * (turn.angle - at)
    psi = np.mod(psi + 0.5 * TURN, TURN) - 0.5 * TURN
    order = np.argsort(psi, kind="stable")
    psi, r = psi[order], deviation[order]
    smooth = (np.abs(psi) > ZONE) & (np.abs(psi) < REACH)
    waves = (np.sin(psi), np.cos(psi), np.sin(2.0 * psi), np.cos(2.0 * psi))
    columns = np.column_stack((np.ones_like(psi), *waves, np.cos(psi) * (psi > 0.0)))
    fitted, *_ = np.linalg.lstsq(columns[smooth], r[smooth], rcond=None)
    left = r - columns @ fitted
    scatter = float(np.sqrt(np.mean(left[smooth] ** 2)))
    behind = (psi > 0.0) & (psi <= ZONE)
    peak = left[behind]
    worst = int(np.argmax(np.abs(peak)))
    height = float(peak[worst])
    over: float | None = None
    if abs(height) > max(SEEN * scatter, LEAST_UM):
        above = np.flatnonzero(np.abs(peak) > max(BACK * abs(height), 3.0 * scatter))
        last = int(above[-1])
        if last + 1 < peak.size:
            over = math.degrees(float(psi[behind][last + 1]))
    seconds = None if over is None or degrees_per_second is None else over / degrees_per_second
    return Reversal(axis, end, turn.direction, 90.0 * quarter, height, float(fitted[5]), over, seconds, scatter)
