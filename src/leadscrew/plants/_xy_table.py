"""Ball-screw axis of an XY table, identified as a voltage-to-position model of order two: equation (1).

    Y(s) / U(s) = gain / (s^2 + damping s + stiffness)        mm per V
                = 69380 / (s^2 + 144.8 s + 166.3)

Source: Abdullah et al., *Design and Analysis of Self-tuned Nonlinear PID Controller for XY Table Ballscrew Drive
System*, equation (1). Poles at -143.6 and -1.158 rad/s, dc gain 417.2 mm/V. The printed model has no dead time, but the
paper's stability plot needs 1.29 ms of it in continuous time, 0.775 ms in a loop sampled at 2 kHz with a backward
difference: give the loop a ``computation_delay``. A disturbance acts at the input, in volt.

The axis is linear, so it is stepped by its exact zero-order-hold solution: no integration error at any period.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._linear import hold_matrices


class XYTableParams(NamedTuple):
    """The coefficients of (1)."""

    gain: Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("numerator: acceleration at 1 V from rest, (1)")] = 69380.0
    damping: Annotated[float, Unit("1/s"), Ge(0), Doc("denominator, coefficient of s, (1)")] = 144.8
    stiffness: Annotated[float, Unit("1/s^2"), Ge(0), Doc("denominator, constant coefficient, (1)")] = 166.3


class XYTableState(NamedTuple):
    """Where the table is and how fast it moves."""

    position: Annotated[float, Unit("mm")] = 0.0
    velocity: Annotated[float, Unit("mm/s")] = 0.0


class XYTableHold(NamedTuple):
    """The exact step over one period; the drive's entries are for an acceleration of 1 mm/s^2."""

    gain: float
    position_from_position: float
    position_from_velocity: float
    velocity_from_position: float
    velocity_from_velocity: float
    position_from_drive: float
    velocity_from_drive: float


def xy_table_hold(params: XYTableParams, dt: float) -> XYTableHold:
    """The exact step; the gain stays outside the matrices, so that a sweep of it computes them once."""
    return XYTableHold(params.gain, *_hold(dt, params.damping, params.stiffness))


@lru_cache(maxsize=256)
def _hold(dt: float, damping: float, stiffness: float) -> tuple[float, ...]:
    a = np.array([[0.0, 1.0], [-stiffness, -damping]])
    transition, drive = hold_matrices(a, np.array([0.0, 1.0]), dt)
    return tuple(float(x) for x in (*transition.ravel(), *drive))


@plant(XYTableParams, XYTableState, output="position", prepare=xy_table_hold, unit="mm", drive="voltage")
def xy_table(p, s, u, dt):
    """Ball-screw axis of an XY table, equation (1): state one period later under the constant voltage ``u``."""
    drive = p.gain * u
    return XYTableState(
        p.position_from_position * s.position + p.position_from_velocity * s.velocity + p.position_from_drive * drive,
        p.velocity_from_position * s.position + p.velocity_from_velocity * s.velocity + p.velocity_from_drive * drive,
    )
