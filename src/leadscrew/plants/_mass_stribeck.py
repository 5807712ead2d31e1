"""A mass on a slide under static friction: Coulomb, viscous, Stribeck; it truly sticks.

    m dv/dt = u - F(v)        dx/dt = v        F: :mod:`leadscrew.friction.static_map`

At rest it stays at rest while the push is no larger than the static friction of its direction. The step is implicit in
the friction's sign, so that sticking is exact and nothing rattles: no smoothed sign function, no speed below which the
mass counts as stopped. First order in the integration step where the level of friction changes with speed: raise the
loop's ``substeps`` until the result no longer changes. Without Stribeck and viscous terms the motion between stops is
exact.

Numbers: unit mass of Canudas de Wit et al. (1995), Table I.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.friction.static_map import TwoSided, speed_after
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Gt, Unit


class MassStribeckParams(NamedTuple):
    """Mass and friction."""

    mass: Annotated[float, Unit("kg"), Gt(0)] = 1.0
    friction: TwoSided = TwoSided()


class MassStribeckState(NamedTuple):
    """Where it is and how fast it moves; a speed of 0 means that it sticks."""

    position: Annotated[float, Unit("m")] = 0.0
    speed: Annotated[float, Unit("m/s")] = 0.0


@plant(MassStribeckParams, MassStribeckState, unit="m", drive="force")
def mass_stribeck(p, s, u, dt):
    """A mass that sticks and slides under Coulomb, viscous and Stribeck friction: state after ``dt`` under a force."""
    speed = speed_after(p.friction, s.speed, u, p.mass, dt)
    return MassStribeckState(s.position + 0.5 * dt * (s.speed + speed), speed)
