"""Ball-screw stage: one inertia against LuGre friction, driven by a torque. Equations (1) to (5).

    d angle/dt = speed
    J d speed/dt = u + load - F                                    (5)
    dz/dt = speed - abs(speed) z / g(speed)                        (1)
    F by (2), g by (3):                                            :mod:`leadscrew.friction.lugre`
    shown = travel_per_rad angle

Source: Shams and Safdari (2010), *Fuzzy Sliding Mode Control of a Ball Screw Driven Stage*. ``J = J_rot + m l_p^2 =
2.12e-4 + 62.4 (1.5923e-3)^2 = 3.7021e-4 kg m^2`` with the largest table and work, from Table 1; friction: Table 2. The
stage shows the angle in rad; with ``travel_per_rad = 1.5923`` (Table 1) it shows the table's position in mm.

The friction torque (6.24 N m is 3.9 kN at the table) is far above what inertia asks for. The system is stiff (rates up
to 1e6 1/s while it sticks): integrated by ``rodas`` unless a loop names a method; explicit ones need steps below 3 us.
A run that starts in motion should start with its bristles bent: ``steady_bristle`` of
:mod:`leadscrew.friction.lugre`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.lugre import LuGre, friction
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Gt, Unit

INERTIA = 2.12e-4 + 62.4 * (1.5923e-3) ** 2
"""Table 1: rotating inertia, and the largest table and work seen through the screw, kg m^2."""

TRAVEL_MM_PER_RAD = 1.5923
"""Table 1: travel of the table per radian of the screw."""


GONE = 40.0
"""Exponent of (3) from which its term is left out: e^-40 of ``F_S - F_C`` is below the last digit of ``F_C``."""


class BallscrewStageParams(NamedTuple):
    """Inertia, what is shown, and friction."""

    inertia: Annotated[float, Unit("kg m^2"), Gt(0), Doc("inertia at the screw, (5); 2.12e-4 without a table")] = (
        INERTIA
    )
    travel_per_rad: Annotated[
        float, Unit("1/rad"), Gt(0), Doc("what is shown per radian: 1 for rad, 1.5923 for mm of the table")
    ] = 1.0
    friction: LuGre = LuGre()


class BallscrewStageState(NamedTuple):
    """Screw and bristles."""

    angle: Annotated[float, Unit("rad")] = 0.0
    speed: Annotated[float, Unit("rad/s")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("mean deflection of the bristles, z")] = 0.0


def shown(p, s):
    """The angle, or the table's position."""
    return p.travel_per_rad * s.angle


def stage_level(f, v):
    """``s0 g(v)``, (3), as :func:`leadscrew.friction.lugre.level`, without its exponential where that is nothing.

    A branch, and most of a run is on its short side: the adaptive integrator needs half the time for it.
    """
    ratio = v / f.stribeck_speed
    if ratio * ratio > GONE:
        return f.coulomb
    return f.coulomb + (f.static - f.coulomb) * math.exp(-(ratio * ratio))


def stage_jacobian(p, s):
    """Rows of the Jacobian, in the order of the state; at ``speed = 0``, a kink, the mean of both sides."""
    f = p.friction
    v = s.speed
    size = stage_level(f, v)
    slope = -2.0 * v / (f.stribeck_speed * f.stribeck_speed) * (size - f.coulomb)
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    by_speed = 1.0 - f.stiffness * s.bristle / size * (side - abs(v) * slope / size)
    by_bristle = -abs(v) * f.stiffness / size
    speed_by_speed = -(f.damping * by_speed + f.viscous) / p.inertia
    speed_by_bristle = -(f.stiffness + f.damping * by_bristle) / p.inertia
    return ((0.0, 1.0, 0.0), (0.0, speed_by_speed, speed_by_bristle), (0.0, by_speed, by_bristle))


@plant(BallscrewStageParams, BallscrewStageState, output=shown, jacobian=stage_jacobian, stiff=True, drive="torque")
def ballscrew_stage(p, s, u, load):
    """Ball-screw stage with LuGre friction: derivatives under the torque ``u`` and the load torque, in N m."""
    f = p.friction
    rate = s.speed - abs(s.speed) * s.bristle * f.stiffness / stage_level(f, s.speed)
    torque = u + load - friction(f, s.speed, s.bristle, rate)
    return BallscrewStageState(s.speed, torque / p.inertia, rate)
