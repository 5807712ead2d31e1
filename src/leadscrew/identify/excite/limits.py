"""What a test move may do: travel, speed, acceleration, jerk, duration, in SI units."""

from __future__ import annotations

import math
from typing import NamedTuple

from leadscrew.kernel.errors import ValueRefused

SHARE = 0.98
"""Of speed, acceleration and jerk that a move uses at most: the rest is for the loop that follows it."""
ENDS = 0.02
"""Of the travel that a move keeps away from each end, for the same reason."""


class Limits(NamedTuple):
    """Allowed values; ``jerk`` 0: not limited. m, m/s, m/s^2, m/s^3 (rad likewise), s."""

    low: float
    high: float
    speed: float
    acceleration: float
    jerk: float = 0.0
    duration: float = 60.0

    @property
    def middle(self) -> float:
        """Where the move starts and ends."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest position of a move."""
        margin = ENDS * (self.high - self.low)
        return self.low + margin, self.high - margin


def checked(limits: Limits, per_si: float = 1.0, unit: str = "m") -> Limits:
    """The limits, where a move can be made of them.

    Raises:
        ValueRefused: a value that is none, or out of its range, said in the user's unit.
    """
    low, high = per_si * limits.low, per_si * limits.high
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueRefused(f"travel {low:g} to {high:g} {unit}: expected two numbers, the lower one first")
    for name, value, of in (
        ("top speed", limits.speed, f"{unit}/s"), ("top acceleration", limits.acceleration, f"{unit}/s^2"),
    ):  # fmt: skip
        if not 0.0 < value < math.inf:
            raise ValueRefused(f"{name} = {per_si * value:g} {of}: allowed range is (0, inf)")
    if not 0.0 <= limits.jerk < math.inf:
        raise ValueRefused(f"jerk = {per_si * limits.jerk:g} {unit}/s^3: allowed range is [0, inf); 0 is no limit")
    if not 1.0 <= limits.duration <= 3600.0:
        raise ValueRefused(f"duration = {limits.duration:g} s: allowed range is [1, 3600]")
    return limits
