"""A torque drive: the command inside the motor's limit, behind the lag of the current loop.

    w       = min(max(output, -max_torque), max_torque)
    tau dT/dt = w - T

over a period in which ``w`` is held, so that with ``k = exp(-dt / tau)``

    T_next  = w + k (T - w)
    applied = w + (tau / dt) (1 - k) (T - w)          the mean of T over the period

The plant gets the mean, which gives the right change of momentum over every period; inside a period the torque is a
step in place of an exponential. ``tau = 0`` is a drive without lag.

An actuator sees the command alone. Torque ripple follows the angle of the motor, so it is a property of the plant:
:obj:`leadscrew.plants.ballscrew_axial`; a delay of whole periods is the loop's ``computation_delay``. Current loops of
servo drives have bandwidths of 0.5 to 2 kHz, a lag of 0.1 to 0.3 ms; 0.2 ms and 30 N m are chosen.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit

TINY = 1e-30
"""Below this a torque that dies away is 0: its tail would end in denormal numbers, which are slow."""


class TorqueDriveParams(NamedTuple):
    """Limit and lag."""

    max_torque: Annotated[float, Unit("N m"), Gt(0), Doc("largest torque, both ways; chosen")] = 30.0
    lag_s: Annotated[float, Unit("s"), Ge(0), Doc("time constant of the current loop, tau; 0 for none")] = 0.0002


class TorqueDriveState(NamedTuple):
    """What the motor gives now."""

    torque: Annotated[float, Unit("N m"), Doc("torque at the end of the last period, T")] = 0.0


class TorqueDrivePlan(NamedTuple):
    """What the step needs."""

    max_torque: float
    kept: float
    """``k``: what is left of a difference after a period."""
    mean_kept: float
    """``(tau / dt) (1 - k)``: what is left of it in the mean of a period."""


def plan_torque_drive(params: TorqueDriveParams, dt: float) -> TorqueDrivePlan:
    """What one period leaves of the last torque."""
    if params.lag_s <= 0.0:
        return TorqueDrivePlan(params.max_torque, 0.0, 0.0)
    gone = -math.expm1(-dt / params.lag_s)
    return TorqueDrivePlan(params.max_torque, 1.0 - gone, gone * params.lag_s / dt)


@actuator(TorqueDriveParams, TorqueDriveState, prepare=plan_torque_drive, unit="N m")
def torque_drive(p, s, output):
    """Mean torque of the coming period."""
    wanted = min(max(output, -p.max_torque), p.max_torque)
    left = s.torque - wanted
    after = wanted + p.kept * left
    return TorqueDriveState(after if abs(after) > TINY else 0.0), wanted + p.mean_kept * left
