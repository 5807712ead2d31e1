"""Jumps in a measured circle: an encoder that lost counts, a bar that was touched."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from leadscrew.analysis.circular.paths import Floats, Turn
from leadscrew.kernel.errors import DataError

USUAL = 30.0
"""Scaled median absolute deviations that a change between neighbours may have."""
LEAST_UM = 1.0
NEAR, AT = math.radians(15.0), math.radians(3.0)
FACTOR = 10.0
"""How much more a change of the radius may be near a reversal."""
WIDEST_GAP = math.radians(2.0)


def refuse_jumps(path: Path, turn: Turn, rows: Sequence[int]) -> None:
    """Nothing, where the turn has no jump.

    Raises:
        DataError: it has; names the row, the size and the angle.
    """
    angle = turn.angle
    step = turn.sign * np.diff(angle)
    usual = turn.spacing
    where = np.degrees(np.mod(angle[1:], 2.0 * math.pi))
    gaps = np.flatnonzero(step > max(5.0 * usual, WIDEST_GAP))
    if gaps.size:
        at = int(gaps[0])
        raise DataError(
            f"{path}, row {rows[at + 1]}: {math.degrees(float(step[at])):.3g} degrees without a point before "
            f"{where[at]:.1f} degrees; {math.degrees(usual):.3g} degrees are usual here"
        )
    change = 1000.0 * np.diff(np.hypot(turn.x_mm, turn.y_mm))
    change -= np.median(change)
    limit = max(USUAL * _scatter(change), LEAST_UM)
    middle = 0.5 * (angle[:-1] + angle[1:])
    from_reversal = np.abs(np.mod(middle + 0.25 * math.pi, 0.5 * math.pi) - 0.25 * math.pi)
    at_reversal = from_reversal < max(AT, 2.0 * usual)
    limits = np.where(at_reversal, np.inf, np.where(from_reversal < NEAR, FACTOR * limit, limit))
    _refuse(path, rows, where, change, limits, "the radius jumps")
    # Along the path: points may be missing or measured twice, but steps are multiples of the usual one.
    missing = step - np.maximum(np.round(step / usual), 0.0) * usual
    size = float(np.mean(np.hypot(turn.x_mm, turn.y_mm)))
    along = 1000.0 * size * missing
    limits = np.full(along.size, max(USUAL * _scatter(along), LEAST_UM, 10.0 * size * usual))
    _refuse(path, rows, where, along, limits, "the path jumps along itself")


def gap_um(turn: Turn) -> float:
    """By how much the radius of the last point differs from the first; 0 where that is no more than between neighbours.

    Where a turn starts at a reversal, play makes a step of it: ten times as much is then allowed.
    """
    radii = 1000.0 * np.hypot(turn.x_mm, turn.y_mm)
    change = np.diff(radii)
    limit = max(USUAL * _scatter(change), LEAST_UM)
    start = abs(math.remainder(float(turn.angle[0]), 0.5 * math.pi))
    gap = abs(float(radii[-1] - radii[0]))
    return gap if gap > (FACTOR * limit if start < NEAR else limit) else 0.0


def _refuse(path: Path, rows: Sequence[int], where: Floats, change: Floats, limits: Floats, what: str) -> None:
    beyond = np.flatnonzero(np.abs(change) > limits)
    if beyond.size:
        at = int(beyond[0])
        raise DataError(
            f"{path}, row {rows[at + 1]}: {what} by {change[at]:.1f} um at {where[at]:.1f} degrees, where neighbours "
            f"differ by {float(np.median(np.abs(change))):.2g} um: an encoder jump? measure the turn again"
        )


def _scatter(values: Floats) -> float:
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))
