"""Modern backlash: drive and table are two masses with a dead band between them, and impacts that bounce.

With the twist ``d = x_m - x_t``, its rate ``d'`` and the dead band of :mod:`leadscrew.plants._backlash`:

    F+ = max(k+ (d - b+) + c+ d', 0)  where d > b+       F- = max(k- (-b- - d) - c- d', 0)  where d < -b-
    M_m dv_m/dt = u - sigma_m v_m - (F+ - F-)
    M_t dv_t/dt = (F+ - F-) + load - guide friction      guide: LuGre, :mod:`leadscrew.friction.asymmetric`

A flank pushes and never pulls. Damping is stated as the restitution ``e``: the speed with which two free masses part,
over the one with which they met. With ``c = 2 zeta sqrt(k m)``, ``m = M_m M_t / (M_m + M_t)``, and contact ending when
the force does (before the spring is back at its length),

    e = exp(-2 zeta phi / sqrt(1 - zeta^2)), phi = arccos zeta      for zeta > 1 with arcosh and sqrt(zeta^2 - 1)

which is solved for ``zeta`` when the loop starts. The usual ``zeta = -ln e / sqrt(pi^2 + ln^2 e)`` is for a flank that
also pulls: pushing only, its ``e = 0.05`` bounces with 0.21.

Source: Figure 2 of Shams and Safdari (2010) in words ("dead band and an almost elastic impact between rigid bodies");
dead band with contact damping: M. Nordin, P.-O. Gutman, *Controlling mechanical systems with backlash: a survey*,
Automatica 38 (2002) 1633. Masses: the paper's Table 1 through its screw, 2.12e-4 kg m^2 / (1.5923e-3 m)^2 and 62.4 kg.
Gap, stiffness, restitution and guide (20 N, 50 N s/m) are chosen; the paper gives none.

Stiff while the guide sticks: integrated by ``rodas`` unless a loop names a method (its error control finds impacts;
``atol`` 1e-12 m for nm). Or ``sdirk3`` with a step well below the contact time, ``pi sqrt(m / k)``, 1.9 ms with the
default numbers.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.asymmetric import LuGreSlide
from leadscrew.friction.lugre import bristle_rate, friction, rate_by_bristle, rate_by_speed
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._backlash import AxisPosition, DeadBand, backward_depth, forward_depth

GUIDE = LuGreSlide(
    stiffness=1e9, damping=2.0 * math.sqrt(1e9 * 62.4), viscous=50.0, coulomb=20.0, static=20.0, stribeck_speed=0.001
)
"""The table's guide: 20 N after 20 nm, so nearly Coulomb; critically damped while it sticks, 50 N s/m."""


class BacklashTwoMassParams(NamedTuple):
    """Two masses, what is between them, and what rubs."""

    motor_mass: Annotated[float, Unit("kg"), Gt(0), Doc("motor and screw as seen at the table, M_m")] = 83.6
    motor_viscous: Annotated[float, Unit("N s/m"), Ge(0), Doc("viscous friction of motor and screw, sigma_m")] = 200.0
    table_mass: Annotated[float, Unit("kg"), Gt(0), Doc("table and work, M_t")] = 62.4
    restitution: Annotated[float, Gt(0), Le(1), Doc("speed of parting over speed of meeting, e; 1 is elastic")] = 0.9
    joint: DeadBand = DeadBand()
    guide: LuGreSlide = GUIDE


class BacklashTwoMassState(NamedTuple):
    """Both bodies, as seen at the table, and the bristles of the guide."""

    motor: Annotated[float, Unit("m")] = 0.0
    motor_speed: Annotated[float, Unit("m/s")] = 0.0
    table: Annotated[float, Unit("m")] = 0.0
    table_speed: Annotated[float, Unit("m/s")] = 0.0
    bristle: Annotated[float, Unit("m"), Doc("mean deflection of the guide's bristles")] = 0.0


class BacklashTwoMassPlan(NamedTuple):
    """The parameters, and the damping of the flanks."""

    motor_mass: float
    motor_viscous: float
    table_mass: float
    joint: DeadBand
    guide: LuGreSlide
    forward_damping: float
    backward_damping: float


def restitution_of(zeta: float) -> float:
    """``e`` of a flank with this damping ratio that pushes only."""
    if zeta < 1.0:
        return math.exp(-2.0 * zeta * math.acos(zeta) / math.sqrt(1.0 - zeta * zeta))
    if zeta == 1.0:
        return math.exp(-2.0)
    return math.exp(-2.0 * zeta * math.acosh(zeta) / math.sqrt(zeta * zeta - 1.0))


def damping_ratio(restitution: float) -> float:
    """``zeta`` of a flank that pushes only and parts with this restitution; the inverse of ``restitution_of``."""
    low, high = 0.0, 1.0
    while restitution_of(high) > restitution:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if restitution_of(middle) > restitution else (low, middle)
    return 0.5 * (low + high) if restitution < 1.0 else 0.0


def flank_damping(joint: DeadBand, motor_mass: float, table_mass: float, restitution: float) -> tuple[float, float]:
    """Damping of the forward and of the backward flank, N s/m, from the restitution."""
    reduced = motor_mass * table_mass / (motor_mass + table_mass)
    twice = 2.0 * damping_ratio(restitution)
    stiffnesses = joint.forward_stiffness, joint.backward_stiffness
    return twice * math.sqrt(stiffnesses[0] * reduced), twice * math.sqrt(stiffnesses[1] * reduced)


def planned(params: BacklashTwoMassParams, dt: float) -> BacklashTwoMassPlan:
    """Damping of the flanks from the restitution."""
    forward, backward = flank_damping(params.joint, params.motor_mass, params.table_mass, params.restitution)
    given = {n: v for n, v in params._asdict().items() if n in BacklashTwoMassPlan._fields}
    return BacklashTwoMassPlan(**given, forward_damping=forward, backward_damping=backward)


def contact(p, twist, rate):
    """Force that the drive puts on the table."""
    ahead, behind = forward_depth(p.joint, twist), backward_depth(p.joint, twist)
    forward = max(p.joint.forward_stiffness * ahead + p.forward_damping * rate, 0.0) if ahead > 0.0 else 0.0
    backward = max(p.joint.backward_stiffness * behind - p.backward_damping * rate, 0.0) if behind > 0.0 else 0.0
    return forward - backward


def shown(p, s):
    """The table and the motor."""
    return AxisPosition(s.table, s.motor)


class Flank(NamedTuple):
    """Stiffness and damping of the contact at a twist; 0 in the gap and where a flank would have to pull."""

    stiffness: float
    damping: float


def flank(p, twist, rate):
    """Derivatives of :func:`contact` by the twist and by its rate."""
    pressed = contact(p, twist, rate)
    forward = 1.0 if pressed > 0.0 and forward_depth(p.joint, twist) > 0.0 else 0.0
    backward = 1.0 if pressed < 0.0 and backward_depth(p.joint, twist) > 0.0 else 0.0
    return Flank(
        forward * p.joint.forward_stiffness + backward * p.joint.backward_stiffness,
        forward * p.forward_damping + backward * p.backward_damping,
    )


def two_mass_jacobian(p, s):
    """Rows of the Jacobian, in the order of the state."""
    by = flank(p, s.motor - s.table, s.motor_speed - s.table_speed)
    k, c, a, m = by.stiffness, by.damping, p.motor_mass, p.table_mass
    by_speed = rate_by_speed(p.guide, s.table_speed, s.bristle)
    by_bristle = rate_by_bristle(p.guide, s.table_speed)
    rubs = p.guide.damping * by_speed + p.guide.viscous
    return (
        (0.0, 1.0, 0.0, 0.0, 0.0),
        (-k / a, -(p.motor_viscous + c) / a, k / a, c / a, 0.0),
        (0.0, 0.0, 0.0, 1.0, 0.0),
        (k / m, c / m, -k / m, -(c + rubs) / m, -(p.guide.stiffness + p.guide.damping * by_bristle) / m),
        (0.0, 0.0, 0.0, by_speed, by_bristle),
    )


@plant(
    BacklashTwoMassParams(),
    BacklashTwoMassState(),
    output=shown,
    prepare=planned,
    jacobian=two_mass_jacobian,
    stiff=True,
    unit="m",
)
def backlash_two_mass(p, s, u, load):
    """Drive and table with a dead band and impacts between them: derivatives under the drive's force and the load."""
    force = contact(p, s.motor - s.table, s.motor_speed - s.table_speed)
    rate = bristle_rate(p.guide, s.table_speed, s.bristle)
    rubbed = friction(p.guide, s.table_speed, s.bristle, rate)
    return BacklashTwoMassState(
        s.motor_speed,
        (u - p.motor_viscous * s.motor_speed - force) / p.motor_mass,
        s.table_speed,
        (force + load - rubbed) / p.table_mass,
        rate,
    )
