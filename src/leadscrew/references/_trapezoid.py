"""Point to point with limited velocity and acceleration: a trapezoid of speed, a triangle where the way is short.

``v = min(max_velocity, sqrt(max_acceleration |distance|))``, accelerate for ``v/a``, cruise for ``|distance|/v - v/a``,
decelerate for ``v/a``. See :mod:`leadscrew.references._motion`.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._motion import Move, move_at, shortest_profile


class TrapezoidParams(NamedTuple):
    """One move, in mm or in any other unit of length or angle used throughout."""

    start: Annotated[float, Unit("mm"), Doc("position before the move")] = 0.0
    distance: Annotated[float, Unit("mm"), Doc("how far to go, either sign")] = 100.0
    max_velocity: Annotated[float, Unit("mm/s"), Gt(0), Doc("limit of the speed")] = 100.0
    max_acceleration: Annotated[float, Unit("mm/s^2"), Gt(0), Doc("limit of the acceleration")] = 1000.0
    start_time: Annotated[float, Unit("s"), Ge(0), Doc("when the move starts")] = 0.0


def plan_trapezoid(params: TrapezoidParams, dt: float) -> Move:
    """The durations of the three parts, worked out once."""
    profile = shortest_profile(abs(params.distance), params.max_velocity, params.max_acceleration)
    return Move(params.start, -1.0 if params.distance < 0.0 else 1.0, params.start_time, profile)


@reference(TrapezoidParams, prepare=plan_trapezoid, unit="mm")
def trapezoid(p, t):
    """Position, velocity and acceleration of the move as a :class:`~leadscrew.references.Motion`."""
    return move_at(p, t)
