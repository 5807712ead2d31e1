"""Ball-screw axis of the XY table, equation (1), with LuGre friction at its input, in volt.

    y'' = gain (u - F) - damping y' - stiffness y                                    equation (1), mm and V
    F   = F_C z / z_s                                  z_s: deflection at which F reaches F_C (``presliding_um``)
    z'  = v - abs(v) z / (z_s r(v))                    v = y'
    r   = 1 + (F_S / F_C - 1) exp(-(v / v_s)^2)        ``static_ratio`` = F_S / F_C, ``stribeck_mm_s`` = v_s

This is ``z' = v - sigma_0 abs(v) z / g(v)``, ``F = sigma_0 z`` of Canudas de Wit et al. (1995) with
``sigma_0 = F_C / z_s`` and ``g = F_C r``; its viscous part is the ``damping`` of (1), its ``sigma_1`` is 0.

Source: the axis is equation (1) of Abdullah et al. (XY table, NPID). The paper measures no friction: the levels
(2.6 mV, 2 um), (20 mV, 5 um) and (150 mV, 10 um), :data:`LEVELS`, and ``F_S = 1.2 F_C``, ``v_s = 1 mm/s`` are chosen.

Computation, in steps of ``h`` = period / substeps: ``v`` at full steps, ``z`` half a step later (leapfrog, order two):

    x       = h abs(v) / (z_s r(v))
    z+      = (z + h v (1 + x / 2)) / (1 + x + x^2 / 2)           implicit, L-stable: |F| never exceeds F_S
    (y, v)+ = exact solution of (1) over h under the constant input u - F(z+)

At 25 us within 2 nm of the exact solution at all levels below. (The simpler ``z+ = (z + h v) / (1 + x)`` is of order
one: 11 to 111 nm.) The bristles and the table are an oscillator of ``w = sqrt(gain F_C / z_s)``; the leapfrog needs
``w h < 2``, and ``w h <= 1`` is asked for. Take steps of 25 us: ``Loop(period=0.5e-3, substeps=20)``. Pure Coulomb
friction is the limit of ``static_ratio = 1`` and a small ``presliding_um``: ``coulomb``.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import Block, plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._xy_table import XYTableParams, xy_table_hold
from leadscrew.util.errors import ValueRefused

TINY = 1e-30
"""A speed below this is 0: at rest it would end in denormal numbers, which are slow."""
FAR = 700.0
"""The exponent of the Stribeck curve is cut here."""


class XYTableLuGreParams(NamedTuple):
    """The coefficients of (1), and friction as a voltage at the input."""

    gain: Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("numerator: acceleration at 1 V from rest, (1)")] = 69380.0
    damping: Annotated[float, Unit("1/s"), Ge(0), Doc("denominator, coefficient of s, (1)")] = 144.8
    stiffness: Annotated[float, Unit("1/s^2"), Ge(0), Doc("denominator, constant coefficient, (1)")] = 166.3
    friction_mv: Annotated[float, Unit("mV"), Ge(0), Doc("friction in fast sliding, F_C; chosen")] = 20.0
    presliding_um: Annotated[
        float, Unit("um"), Gt(0), Doc("deflection of the bristles at which friction reaches F_C, z_s; chosen")
    ] = 5.0
    static_ratio: Annotated[float, Ge(1), Doc("largest friction at rest over F_C, F_S / F_C; chosen")] = 1.2
    stribeck_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the fall to F_C, v_s; chosen")] = 1.0


class XYTableLuGreState(NamedTuple):
    """Motion and bristles."""

    position: Annotated[float, Unit("mm")] = 0.0
    velocity: Annotated[float, Unit("mm/s")] = 0.0
    bristle: Annotated[float, Unit("um"), Doc("deflection of the bristles, z, half a step ahead")] = 0.0


class XYTableLuGreHold(NamedTuple):
    """The exact step of (1) for an acceleration of 1 mm/s^2, and friction in its own units."""

    gain: float
    position_from_position: float
    position_from_velocity: float
    velocity_from_position: float
    velocity_from_velocity: float
    position_from_drive: float
    velocity_from_drive: float
    friction: float
    """Volt per um of bristle."""
    moved: float
    """Travel in um per mm/s over the step."""
    presliding: float
    excess: float
    stribeck: float


def xy_table_lugre_hold(params: XYTableLuGreParams, dt: float) -> XYTableLuGreHold:
    """The exact step of (1).

    Raises:
        ValueRefused: bristles too stiff for the step.
    """
    stiffest = params.gain * 1e-3 * params.friction_mv / (1e-3 * params.presliding_um) * dt * dt
    if stiffest > 1.0:
        least = params.gain * params.friction_mv * dt * dt
        raise ValueRefused(
            f"presliding_um = {params.presliding_um:g} (xy_table_lugre) with friction_mv = {params.friction_mv:g}: "
            f"expected {least:.3g} or more at an integration step of {1e6 * dt:g} us, or more substeps"
        )
    table = xy_table_hold(XYTableParams(params.gain, params.damping, params.stiffness), dt)
    return XYTableLuGreHold(
        *table,
        1e-3 * params.friction_mv / params.presliding_um,
        1e3 * dt,
        params.presliding_um,
        params.static_ratio - 1.0,
        params.stribeck_mm_s,
    )


def bristle_after(p, z, v):
    """The bristles a step later at the speed ``v``, implicit: at most ``z_s r(v)`` in size once they slip."""
    ratio = v / p.stribeck
    most = p.presliding * (1.0 + p.excess * math.exp(-min(ratio * ratio, FAR)))
    moved = p.moved * v
    x = abs(moved) / most
    return (z + moved * (1.0 + 0.5 * x)) / (1.0 + x + 0.5 * x * x)


@plant(
    XYTableLuGreParams, XYTableLuGreState, output="position", prepare=xy_table_lugre_hold, unit="mm", drive="voltage"
)
def xy_table_lugre(p, s, u, dt):
    """Ball-screw axis of an XY table, equation (1), with LuGre friction in volt at its input; wants steps of 25 us."""
    z = bristle_after(p, s.bristle, s.velocity)
    drive = p.gain * (u - p.friction * z)
    v = p.velocity_from_position * s.position + p.velocity_from_velocity * s.velocity + p.velocity_from_drive * drive
    return XYTableLuGreState(
        p.position_from_position * s.position + p.position_from_velocity * s.velocity + p.position_from_drive * drive,
        v if abs(v) > TINY else 0.0,
        z,
    )


LEVELS: dict[str, Block] = {
    "low": xy_table_lugre(friction_mv=2.6, presliding_um=2.0),
    "medium": xy_table_lugre,
    "high": xy_table_lugre(friction_mv=150.0, presliding_um=10.0),
    "coulomb": xy_table_lugre(friction_mv=2.6, presliding_um=0.01, static_ratio=1.0),
}
"""Three levels: about what Table II's amplitudes need, a smooth guide, a usual guide; and the first one without
presliding: Coulomb friction on 10 nm of bristle."""
