"""A mass on a slide under generalised Maxwell-slip friction.

    m dv/dt = u - F        dx/dt = v        F: :mod:`leadscrew.friction.maxwell_slip`

Elements stick and slip, so the plant brings its own step. Over ``h``: elements that slip count as they are; the
new speed is implicit in the springs that stick (``K``, forces ``F_k``), in their damping ``c`` and in the viscous term,

    v' = (m v + h (u - sum F_k - sum F_slipped)) / (m + h (c + sigma_2) + h^2 K),        x' = x + h v'

then all elements move by ``h`` at ``v'``, exactly. Stable at any step; first order in ``h``: raise the loop's
``substeps`` until the result no longer changes (a step of 1 us to 10 us for the default numbers). For another number of
elements: :func:`with_elements`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.friction.maxwell_slip import (
    Elements,
    MaxwellSlip,
    checked,
    move_elements,
    speed_after,
    total_stiffness,
    unloaded,
)
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Gt, Unit

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block


class MassMaxwellSlipParams(NamedTuple):
    """Mass and friction."""

    mass: Annotated[float, Unit("kg"), Gt(0)] = 1.0
    friction: MaxwellSlip = MaxwellSlip()


class MassMaxwellSlipState(NamedTuple):
    """Motion, and the elements."""

    position: Annotated[float, Unit("m")] = 0.0
    speed: Annotated[float, Unit("m/s")] = 0.0
    elements: Elements = Elements(np.zeros(6), np.zeros(6))


def start(params: MassMaxwellSlipParams) -> MassMaxwellSlipState:
    """At rest at 0, elements without force."""
    return MassMaxwellSlipState(elements=unloaded(params.friction))


def sensible(params: MassMaxwellSlipParams, dt: float) -> MassMaxwellSlipParams:
    """The parameters, if their elements make sense; else ``ValueRefused``."""
    return params._replace(friction=checked(params.friction))


@plant(MassMaxwellSlipParams, MassMaxwellSlipState, initial=start, prepare=sensible, unit="m", drive="force")
def mass_maxwell_slip(p, s, u, dt):
    """A mass under generalised Maxwell-slip friction: state after ``dt`` under a force."""
    f = p.friction
    speed = speed_after(f, s.elements, total_stiffness(f), p.mass, s.speed, u, dt)
    return MassMaxwellSlipState(s.position + dt * speed, speed, move_elements(f, s.elements, speed, dt))


def with_elements(share: Any, stiffness: Any, **changes: Any) -> Block:
    """The plant with this many elements; ``changes`` are further parameters, such as ``mass`` or ``friction.coulomb``.

    Raises:
        ValueRefused: lists of different length, numbers that are not positive, shares that do not sum to 1.
        NameUnknown: a parameter that does not exist.
    """
    friction = MaxwellSlip(np.array(share, dtype=float), np.array(stiffness, dtype=float))
    params = MassMaxwellSlipParams(friction=checked(friction))
    return replace(mass_maxwell_slip, params=params, state=start(params)).using(**changes)
