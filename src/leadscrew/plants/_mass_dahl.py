"""A mass on a slide under Dahl friction.

    m dv/dt = u - F - sigma_2 v        dx/dt = v        dF/dt by :mod:`leadscrew.friction.dahl`

Stuck it is a spring: 316 rad/s with the default numbers (unit mass of Canudas de Wit et al. 1995). Sliding, the force
settles at the rate ``sigma |v| / F_C``, 1e4 1/s at 0.1 m/s: integrated by ``rodas`` unless a loop names a method.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.friction.dahl import Dahl, force_rate, force_slope, rate_by_force
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Gt, Unit


class MassDahlParams(NamedTuple):
    """Mass and friction."""

    mass: Annotated[float, Unit("kg"), Gt(0)] = 1.0
    friction: Dahl = Dahl()


class MassDahlState(NamedTuple):
    """Motion, and the force of the yielding spring."""

    position: Annotated[float, Unit("m")] = 0.0
    speed: Annotated[float, Unit("m/s")] = 0.0
    force: Annotated[float, Unit("N")] = 0.0


def mass_dahl_jacobian(p, s):
    """Rows of the Jacobian, in the order of the state; at rest the slope of the unloaded spring."""
    f = p.friction
    return (
        (0.0, 1.0, 0.0),
        (0.0, -f.viscous / p.mass, -1.0 / p.mass),
        (0.0, force_slope(f, s.speed, s.force), rate_by_force(f, s.speed, s.force)),
    )


@plant(MassDahlParams, MassDahlState, jacobian=mass_dahl_jacobian, stiff=True, unit="m", drive="force")
def mass_dahl(p, s, u):
    """A mass under Dahl friction: derivatives under a force."""
    pushed = u - s.force - p.friction.viscous * s.speed
    return MassDahlState(s.speed, pushed / p.mass, force_rate(p.friction, s.speed, s.force))
