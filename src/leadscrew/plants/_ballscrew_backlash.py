"""Ball-screw stage of two masses: motor and screw, a dead band with almost elastic impacts, and the table.

::

    J d speed/dt = u - F - lead Fc             F: LuGre of the screw
    M_t dv_t/dt  = Fc + load - guide           guide: LuGre of the slide
    Fc of the twist lead angle - x_t and its rate, pushing only, damping from the restitution

Friction: :mod:`leadscrew.friction.lugre`, :mod:`leadscrew.friction.asymmetric`; the joint:
:obj:`leadscrew.plants.backlash_two_mass`.

Source: section 2.1 of Shams and Safdari (2010) for "modern" backlash; inertia ``2.12e-4 kg m^2``, mass 62.4 kg and
lead: Table 1; friction of the screw: Table 2, all of it on the motor's side. Gap (1 um to each side), stiffness of the
joint (1e8 N/m), restitution (0.9) and guide (20 N, 50 N s/m) are chosen; the paper gives none.

Pressed together the two bodies swing against each other at ``sqrt(k / m) = 1673 1/s``, 266 Hz, with the motor held by
friction at ``sqrt(k / M_t)``, 201 Hz: a loop closed on the table has to leave that alone. Shown are the table, as a
linear scale sees it, and the screw, as an encoder on the motor does (:obj:`leadscrew.sensors.axis_encoder`). ``u`` in
N m, ``load`` in N at the table. Stiff; give ``atol`` 1e-12 or less. Without impacts: ``ballscrew_play``.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.friction.asymmetric import LuGreSlide
from leadscrew.friction.lugre import (
    LuGre,
    bristle_rate,
    friction,
    rate_by_bristle,
    rate_by_speed,
    steady_bristle,
    steady_friction,
)
from leadscrew.kernel.block import Block, plant
from leadscrew.kernel.parameters import Doc, Gt, Le, Unit
from leadscrew.plants._backlash import AxisPosition, DeadBand
from leadscrew.plants._backlash_two_mass import GUIDE, contact, flank, flank_damping
from leadscrew.plants._ballscrew_play import LEAD, Lead, Shown


class BallscrewBacklashParams(NamedTuple):
    """Two bodies, what is between them, and what rubs."""

    inertia: Annotated[float, Unit("kg m^2"), Gt(0), Doc("motor and screw, Table 1")] = 2.12e-4
    table_mass: Annotated[float, Unit("kg"), Gt(0), Doc("table and work, Table 1")] = 62.4
    lead_per_rad: Lead = LEAD
    travel_per_rad: Shown = 1.0
    restitution: Annotated[float, Gt(0), Le(1), Doc("speed of parting over speed of meeting, e; 1 is elastic")] = 0.9
    joint: DeadBand = DeadBand()
    friction: LuGre = LuGre()
    guide: LuGreSlide = GUIDE


class BallscrewBacklashPlan(NamedTuple):
    """The parameters, and the damping of the flanks."""

    inertia: float
    table_mass: float
    lead_per_rad: float
    travel_per_rad: float
    joint: DeadBand
    friction: LuGre
    guide: LuGreSlide
    forward_damping: float
    backward_damping: float


class BallscrewBacklashState(NamedTuple):
    """Screw and its bristles, table and the bristles of its guide."""

    angle: Annotated[float, Unit("rad")] = 0.0
    speed: Annotated[float, Unit("rad/s")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("mean deflection of the screw's bristles")] = 0.0
    table: Annotated[float, Unit("m")] = 0.0
    table_speed: Annotated[float, Unit("m/s")] = 0.0
    guide_bristle: Annotated[float, Unit("m"), Doc("mean deflection of the guide's bristles")] = 0.0


def planned(params: BallscrewBacklashParams, dt: float) -> BallscrewBacklashPlan:
    """Damping of the flanks from the restitution."""
    motor_mass = params.inertia / params.lead_per_rad**2
    forward, backward = flank_damping(params.joint, motor_mass, params.table_mass, params.restitution)
    given = {n: v for n, v in params._asdict().items() if n in BallscrewBacklashPlan._fields}
    return BallscrewBacklashPlan(**given, forward_damping=forward, backward_damping=backward)


def shown(p, s):
    """The table and the screw."""
    return AxisPosition(p.travel_per_rad * s.table / p.lead_per_rad, p.travel_per_rad * s.angle)


def backlash_jacobian(p, s):
    """Rows of the Jacobian, in the order of the state."""
    f, g, m, lead = p.friction, p.guide, p.table_mass, p.lead_per_rad
    by = flank(p, lead * s.angle - s.table, lead * s.speed - s.table_speed)
    k, c = by.stiffness, by.damping
    by_speed = rate_by_speed(f, s.speed, s.bristle)
    by_bristle = rate_by_bristle(f, s.speed)
    slide_by_speed = rate_by_speed(g, s.table_speed, s.guide_bristle)
    slide_by_bristle = rate_by_bristle(g, s.table_speed)
    j = p.inertia
    return (
        (0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        (
            -lead * lead * k / j,
            -(f.damping * by_speed + f.viscous + lead * lead * c) / j,
            -(f.stiffness + f.damping * by_bristle) / j,
            lead * k / j,
            lead * c / j,
            0.0,
        ),
        (0.0, by_speed, by_bristle, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
        (
            lead * k / m,
            lead * c / m,
            0.0,
            -k / m,
            -(c + g.damping * slide_by_speed + g.viscous) / m,
            -(g.stiffness + g.damping * slide_by_bristle) / m,
        ),
        (0.0, 0.0, 0.0, 0.0, slide_by_speed, slide_by_bristle),
    )


@plant(
    BallscrewBacklashParams(),
    BallscrewBacklashState(),
    output=shown,
    prepare=planned,
    jacobian=backlash_jacobian,
    stiff=True,
    drive="torque",
)
def ballscrew_backlash(p, s, u, load):
    """Screw and table with a dead band and impacts between them: derivatives under torque and force on the table."""
    force = contact(p, p.lead_per_rad * s.angle - s.table, p.lead_per_rad * s.speed - s.table_speed)
    rate = bristle_rate(p.friction, s.speed, s.bristle)
    rubbed = friction(p.friction, s.speed, s.bristle, rate)
    slide = bristle_rate(p.guide, s.table_speed, s.guide_bristle)
    held = friction(p.guide, s.table_speed, s.guide_bristle, slide)
    return BallscrewBacklashState(
        s.speed,
        (u - rubbed - p.lead_per_rad * force) / p.inertia,
        rate,
        s.table_speed,
        (force + load - held) / p.table_mass,
        slide,
    )


def backlash_in_motion(block: Block, speed: float) -> Block:
    """The plant in steady sliding at this speed, rad/s: the table at 0, pressed by its guide against the flank."""
    p = block.params
    v = p.lead_per_rad * speed
    joint, held = p.joint, steady_friction(p.guide, v)
    ahead = joint.forward_gap + held / joint.forward_stiffness
    behind = joint.backward_gap + held / joint.backward_stiffness
    twist = ahead if speed > 0.0 else -behind if speed < 0.0 else 0.0
    return block.starting(
        angle=twist / p.lead_per_rad,
        speed=speed,
        bristle=steady_bristle(p.friction, speed),
        table_speed=v,
        guide_bristle=steady_bristle(p.guide, v),
    )
