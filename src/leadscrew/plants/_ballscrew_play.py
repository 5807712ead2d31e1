"""Ball-screw stage with play between screw and table, classic: the table follows a flank or stands.

::

    screw:  J d speed/dt = u + load - F,  F LuGre
    nut:    x = lead angle,  v = lead speed
    table:  dy/dt = m+ v H+  where v > 0,  m- v H-  where v < 0
            H+ = 1 + (m+ (x - b+) - y) / flank,  H- = 1 + (y - m- (x + b-)) / flank,  each inside [0, 2]

The screw is that of :obj:`leadscrew.plants.ballscrew_stage`, the play that of :mod:`leadscrew.plants._backlash`.

A flank takes hold over the last ``flank`` of its gap, 1 nm by default, and brings the table to where the exact play has
it; so the play is a differential equation, integrated with the friction, and no event is missed between two samples.
The table has no mass of its own in the gap (its share is in ``J``) and stops at once when a flank leaves it: "all
impacts are fully plastic".

Source: section 2.1 of Shams and Safdari (2010) for the play; Tables 1 and 2 for the stage; 1 um to each side is chosen.
Shown are the table, as a linear scale sees it, and the screw, as an encoder on the motor does: a loop is closed on
either by :obj:`leadscrew.sensors.axis_encoder`. Stiff; give ``atol`` 1e-12 or less. With impacts:
:obj:`leadscrew.plants.ballscrew_backlash`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.lugre import LuGre, bristle_rate, friction, rate_by_bristle, rate_by_speed, steady_bristle
from leadscrew.kernel.block import Block, plant
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._backlash import AxisPosition, Play
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD

Lead = Annotated[float, Unit("m/rad"), Gt(0), Doc("travel of the nut per radian, Table 1: l_p")]
Shown = Annotated[float, Unit("1/rad"), Gt(0), Doc("what is shown per radian: 1 for rad, 1.5923 for mm of the table")]
LEAD = 1e-3 * TRAVEL_MM_PER_RAD


class BallscrewPlayParams(NamedTuple):
    """Inertia, what is shown, friction of the screw, and the play."""

    inertia: Annotated[float, Unit("kg m^2"), Gt(0), Doc("screw and table at the screw, (5)")] = INERTIA
    lead_per_rad: Lead = LEAD
    travel_per_rad: Shown = 1.0
    flank: Annotated[float, Unit("m"), Gt(0), Doc("last part of a gap, over which a flank takes hold")] = 1e-9
    friction: LuGre = LuGre()
    play: Play = Play()


class BallscrewPlayState(NamedTuple):
    """Screw, bristles, and the table."""

    angle: Annotated[float, Unit("rad")] = 0.0
    speed: Annotated[float, Unit("rad/s")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("mean deflection of the bristles, z")] = 0.0
    table: Annotated[float, Unit("m")] = 0.0


class Hold(NamedTuple):
    """How far the flank that is moved towards holds the table, 0 to 2, and whether that depends on the places."""

    share: float
    slope: float
    inside: float


def hold(p, s):
    """The flank ahead of the motion."""
    x = p.lead_per_rad * s.angle
    ahead = s.speed > 0.0
    missing = (
        p.play.forward_slope * (x - p.play.forward_gap) - s.table
        if ahead
        else s.table - p.play.backward_slope * (x + p.play.backward_gap)
    )
    raw = 1.0 + missing / p.flank
    share = min(max(raw, 0.0), 2.0)
    return Hold(share, p.play.forward_slope if ahead else p.play.backward_slope, 1.0 if raw == share else 0.0)


def shown(p, s):
    """The table and the screw."""
    return AxisPosition(p.travel_per_rad * s.table / p.lead_per_rad, p.travel_per_rad * s.angle)


def play_jacobian(p, s):
    """Rows of the Jacobian, in the order of the state."""
    f = p.friction
    by_speed = rate_by_speed(f, s.speed, s.bristle)
    by_bristle = rate_by_bristle(f, s.speed)
    speed_by_speed = -(f.damping * by_speed + f.viscous) / p.inertia
    speed_by_bristle = -(f.stiffness + f.damping * by_bristle) / p.inertia
    now = hold(p, s)
    size = now.inside * now.slope * p.lead_per_rad * abs(s.speed) / p.flank
    return (
        (0.0, 1.0, 0.0, 0.0),
        (0.0, speed_by_speed, speed_by_bristle, 0.0),
        (0.0, by_speed, by_bristle, 0.0),
        (size * now.slope * p.lead_per_rad, now.share * now.slope * p.lead_per_rad, 0.0, -size),
    )


@plant(BallscrewPlayParams, BallscrewPlayState, output=shown, jacobian=play_jacobian, stiff=True, drive="torque")
def ballscrew_play(p, s, u, load):
    """Ball-screw stage with LuGre friction and play to the table: derivatives under the torques, in N m."""
    rate = bristle_rate(p.friction, s.speed, s.bristle)
    torque = u + load - friction(p.friction, s.speed, s.bristle, rate)
    now = hold(p, s)
    return BallscrewPlayState(s.speed, torque / p.inertia, rate, now.slope * now.share * p.lead_per_rad * s.speed)


def play_in_motion(block: Block, speed: float) -> Block:
    """The plant in steady sliding at this speed, rad/s, the table at 0 behind the flank that pushes it."""
    p = block.params
    gap = p.play.forward_gap if speed > 0.0 else -p.play.backward_gap if speed < 0.0 else 0.0
    return block.starting(
        speed=speed, bristle=steady_bristle(p.friction, speed), angle=math.copysign(abs(gap), gap) / p.lead_per_rad
    )
