"""Ball-screw stage with the first axial mode of the screw: two inertias, a spring and a damper between them.

Everything as seen at the screw, in rad and N m; ``phi`` is the table's position over the lead per radian, ``l``:

    J_s d speed/dt     = r(angle) u - (1 - share) F(speed, z) - M
    J_t d phi'/dt      = M + load - share F(phi', z_t)          J_t = m l^2
    M                  = K (angle - phi) + C (speed - phi')     K = k l^2,  C = 2 zeta sqrt(K J_s J_t / (J_s + J_t))
    r(angle)           = 1 + a_1 sin(n_1 angle) + a_2 sin(n_2 angle)
    shown              = travel_per_rad phi, or angle in place of phi where at_table = False

``F`` is LuGre friction (:mod:`leadscrew.friction.lugre`), with bristles of its own where the screw and its nut rub and
where the guide does; ``share`` is the part of the friction at the guide. As ``k`` grows it becomes the rigid
:obj:`leadscrew.plants.ballscrew_stage` whatever the share, for the parts add up to its friction.

With a scale at the table the spring lies between motor and scale, with an encoder on the motor it lies outside the
loop. The modes, with the frequencies of the defaults: table against a held screw, ``sqrt(k / m)``, 201 Hz; free,
``sqrt(k / m (1 + J_t / J_s))``, 266 Hz. While friction holds the screw, only ``C`` damps the table.

Source: stage and numbers of Shams and Safdari (2010), Table 1; the mode is ours, the paper's screw is rigid. Axial
stiffness of screw, nut and bearings in series, 1e8 N/m, and 3 % of damping are chosen. All friction at the screw, the
default, is the paper's reading (a friction torque); 3.9 kN, its size at the table, would bend the screw by 39 um each
way. Ripple is off; 1 % at 6 and at 24 a turn is usual for a servo motor (chosen).

The methods and the start in motion are those of the rigid stage. ``stiffness = 1e12`` with ``damping_ratio = 1`` is
rigid to a tenth of a nanometre.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.lugre import LuGre, bristle_rate, friction, rate_by_bristle, rate_by_speed
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD

LEAD_M_PER_RAD = 1e-3 * TRAVEL_MM_PER_RAD
"""Table 1: travel of the table per radian of the screw, l."""


class Ripple(NamedTuple):
    """Torque that the motor adds to what it should give, as a sine of its angle."""

    share: Annotated[float, Ge(0), Le(1), Doc("amplitude over the torque, a")] = 0.0
    per_turn: Annotated[float, Ge(0), Le(1000), Doc("periods in a turn, n")] = 6.0


class BallscrewAxialParams(NamedTuple):
    """Two inertias, what joins them, friction, ripple, and what is shown."""

    screw_inertia: Annotated[float, Unit("kg m^2"), Gt(0), Doc("motor and screw, J_s; Table 1")] = 2.12e-4
    table_mass: Annotated[float, Unit("kg"), Gt(0), Doc("table and work, m; 62.4 is the most in Table 1")] = 62.4
    stiffness: Annotated[float, Unit("N/m"), Gt(0), Doc("axial stiffness of screw, nut and bearings, k; chosen")] = 1e8
    damping_ratio: Annotated[float, Ge(0), Le(10), Doc("damping of the free mode over critical, zeta; chosen")] = 0.03
    guide_share: Annotated[float, Ge(0), Le(1), Doc("part of the friction that acts on the table")] = 0.0
    friction: LuGre = LuGre()
    ripple_low: Ripple = Ripple()
    ripple_high: Ripple = Ripple(per_turn=24.0)
    at_table: Annotated[bool, Doc("show the table, by a scale; otherwise the motor, by an encoder")] = True
    travel_per_rad: Annotated[
        float, Unit("1/rad"), Gt(0), Doc("what is shown per radian: 1 for rad, 1.5923 for mm of the table")
    ] = 1.0


class BallscrewAxialState(NamedTuple):
    """Screw, table, and the bristles of both."""

    angle: Annotated[float, Unit("rad"), Doc("motor and screw")] = 0.0
    speed: Annotated[float, Unit("rad/s")] = 0.0
    table: Annotated[float, Unit("rad"), Doc("the table's position over the lead per radian, phi")] = 0.0
    table_speed: Annotated[float, Unit("rad/s")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("bristles of screw and nut, z")] = 0.0
    guide_bristle: Annotated[float, Unit("rad"), Doc("bristles of the guide, z_t")] = 0.0


class BallscrewAxialPlan(NamedTuple):
    """The parameters as the step reads them."""

    screw_inertia: float
    table_inertia: float
    stiffness: float
    """K, N m/rad."""
    damping: float
    """C, N m s/rad."""
    guide_share: float
    friction: LuGre
    ripple_low: Ripple
    ripple_high: Ripple
    at_table: bool
    travel_per_rad: float


def plan_ballscrew_axial(params: BallscrewAxialParams, dt: float) -> BallscrewAxialPlan:
    """Stiffness, damping and the table's inertia as seen at the screw."""
    squared = LEAD_M_PER_RAD * LEAD_M_PER_RAD
    table_inertia = params.table_mass * squared
    stiffness = params.stiffness * squared
    reduced = params.screw_inertia * table_inertia / (params.screw_inertia + table_inertia)
    return BallscrewAxialPlan(
        params.screw_inertia,
        table_inertia,
        stiffness,
        2.0 * params.damping_ratio * math.sqrt(stiffness * reduced),
        params.guide_share,
        params.friction,
        params.ripple_low,
        params.ripple_high,
        params.at_table,
        params.travel_per_rad,
    )


def ripple(p, angle):
    """Torque over what the drive asks for, r."""
    low, high = p.ripple_low, p.ripple_high
    return 1.0 + low.share * math.sin(low.per_turn * angle) + high.share * math.sin(high.per_turn * angle)


def ripple_slope(p, angle):
    """Derivative of :func:`ripple` by the angle."""
    low, high = p.ripple_low, p.ripple_high
    first = low.share * low.per_turn * math.cos(low.per_turn * angle)
    return first + high.share * high.per_turn * math.cos(high.per_turn * angle)


def shown(p, s):
    """The table's position, or the motor's."""
    return p.travel_per_rad * (s.table if p.at_table else s.angle)


def axial_jacobian(p, s, u, load, t):
    """Rows of the Jacobian, in the order of the state."""
    f, js, jt = p.friction, p.screw_inertia, p.table_inertia
    mine = 1.0 - p.guide_share
    by_speed, by_bristle = rate_by_speed(f, s.speed, s.bristle), rate_by_bristle(f, s.speed)
    guide_by_speed = rate_by_speed(f, s.table_speed, s.guide_bristle)
    guide_by_bristle = rate_by_bristle(f, s.table_speed)
    k, c = p.stiffness, p.damping
    return (
        (0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        (
            (u * ripple_slope(p, s.angle) - k) / js,
            -(mine * (f.damping * by_speed + f.viscous) + c) / js,
            k / js,
            c / js,
            -mine * (f.stiffness + f.damping * by_bristle) / js,
            0.0,
        ),
        (0.0, 0.0, 0.0, 1.0, 0.0, 0.0),
        (
            k / jt,
            c / jt,
            -k / jt,
            -(p.guide_share * (f.damping * guide_by_speed + f.viscous) + c) / jt,
            0.0,
            -p.guide_share * (f.stiffness + f.damping * guide_by_bristle) / jt,
        ),
        (0.0, by_speed, 0.0, 0.0, by_bristle, 0.0),
        (0.0, 0.0, 0.0, guide_by_speed, 0.0, guide_by_bristle),
    )


@plant(
    BallscrewAxialParams(),
    BallscrewAxialState(),
    output=shown,
    jacobian=axial_jacobian,
    prepare=plan_ballscrew_axial,
    stiff=True,
    drive="torque",
)
def ballscrew_axial(p, s, u, load):
    """Ball-screw stage with one axial mode: derivatives under the torque ``u`` and a load at the table, in N m."""
    rate = bristle_rate(p.friction, s.speed, s.bristle)
    guide_rate = bristle_rate(p.friction, s.table_speed, s.guide_bristle)
    screwed = (1.0 - p.guide_share) * friction(p.friction, s.speed, s.bristle, rate)
    guided = p.guide_share * friction(p.friction, s.table_speed, s.guide_bristle, guide_rate)
    passed = p.stiffness * (s.angle - s.table) + p.damping * (s.speed - s.table_speed)
    return BallscrewAxialState(
        s.speed,
        (u * ripple(p, s.angle) - screwed - passed) / p.screw_inertia,
        s.table_speed,
        (passed + load - guided) / p.table_inertia,
        rate,
        guide_rate,
    )
