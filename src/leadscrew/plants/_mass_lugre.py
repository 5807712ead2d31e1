"""A mass on a slide under LuGre friction, each direction with values of its own.

    m dv/dt = u - F        dx/dt = v        dz/dt = v - abs(v) z / g(v)        F = s0 z + s1 dz/dt + s2 v

Friction: :mod:`leadscrew.friction.asymmetric`. Numbers: Canudas de Wit et al. (1995), Table I; with them it shows what
that paper shows: break-away that falls with the rate of the force, stick-slip, hunting under integral control. Stiff
(``|v| s0 / F_C`` is 1e4 1/s at 0.1 m/s): integrated by ``rodas`` unless a loop names a method. Start a run in motion
with the bristles bent: ``steady_bristle`` of :mod:`leadscrew.friction.lugre`. The ball-screw stage in N m is
``ballscrew_stage``.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.friction.asymmetric import TwoSidedLuGre, one_way_lugre
from leadscrew.friction.lugre import bristle_rate, friction, rate_by_bristle, rate_by_speed
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Gt, Unit


class MassLuGreParams(NamedTuple):
    """Mass and friction."""

    mass: Annotated[float, Unit("kg"), Gt(0)] = 1.0
    friction: TwoSidedLuGre = TwoSidedLuGre()


class MassLuGreState(NamedTuple):
    """Motion and bristles."""

    position: Annotated[float, Unit("m")] = 0.0
    speed: Annotated[float, Unit("m/s")] = 0.0
    bristle: Annotated[float, Unit("m"), Doc("mean deflection of the bristles, z")] = 0.0


def mass_lugre_jacobian(p, s):
    """Rows of the Jacobian, in the order of the state."""
    f = one_way_lugre(p.friction, s.speed)
    by_speed = rate_by_speed(f, s.speed, s.bristle)
    by_bristle = rate_by_bristle(f, s.speed)
    speed_by_speed = -(f.damping * by_speed + f.viscous) / p.mass
    speed_by_bristle = -(f.stiffness + f.damping * by_bristle) / p.mass
    return ((0.0, 1.0, 0.0), (0.0, speed_by_speed, speed_by_bristle), (0.0, by_speed, by_bristle))


@plant(MassLuGreParams, MassLuGreState, jacobian=mass_lugre_jacobian, stiff=True, unit="m", drive="force")
def mass_lugre(p, s, u):
    """A mass under LuGre friction with values for each direction: derivatives under a force."""
    f = one_way_lugre(p.friction, s.speed)
    rate = bristle_rate(f, s.speed, s.bristle)
    return MassLuGreState(s.speed, (u - friction(f, s.speed, s.bristle, rate)) / p.mass, rate)
