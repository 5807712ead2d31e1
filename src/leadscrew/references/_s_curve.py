"""Point to point with limited velocity, acceleration and jerk: seven segments, fewer where the way is short.

With ``v, a, j`` the limits and ``d = |distance|`` (Biagiotti and Melchiorri 2008, section 3.4, for rest to rest):

- acceleration reached (``v j >= a^2``): ``jerk_time = a/j``, ``hold_time = v/a - a/j``; else ``sqrt(v/j)`` and 0;
- velocity reached (``d >= v (2 jerk_time + hold_time)``): ``cruise_time = d/v - 2 jerk_time - hold_time``;
- else, where ``d >= 2 a^3/j^2``, the peak velocity solves ``d = v (v/a + a/j)``; where it is not, neither limit is
  reached and ``jerk_time = (d / (2 j))^(1/3)``.

See :mod:`leadscrew.references._motion` for the polynomials.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._motion import Move, move_at, shortest_profile


class SCurveParams(NamedTuple):
    """One move, in mm or in any other unit of length or angle used throughout."""

    start: Annotated[float, Unit("mm"), Doc("position before the move")] = 0.0
    distance: Annotated[float, Unit("mm"), Doc("how far to go, either sign")] = 100.0
    max_velocity: Annotated[float, Unit("mm/s"), Gt(0), Doc("limit of the speed")] = 100.0
    max_acceleration: Annotated[float, Unit("mm/s^2"), Gt(0), Doc("limit of the acceleration")] = 1000.0
    max_jerk: Annotated[float, Unit("mm/s^3"), Gt(0), Doc("limit of the jerk")] = 20000.0
    start_time: Annotated[float, Unit("s"), Ge(0), Doc("when the move starts")] = 0.0


def plan_s_curve(params: SCurveParams, dt: float) -> Move:
    """The durations of the seven segments, worked out once."""
    profile = shortest_profile(abs(params.distance), params.max_velocity, params.max_acceleration, params.max_jerk)
    return Move(params.start, -1.0 if params.distance < 0.0 else 1.0, params.start_time, profile)


@reference(SCurveParams, prepare=plan_s_curve, unit="mm")
def s_curve(p, t):
    """Position, velocity and acceleration of the move as a :class:`~leadscrew.references.Motion`."""
    return move_at(p, t)
