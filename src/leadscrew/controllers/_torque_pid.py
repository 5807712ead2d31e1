"""Parallel PID of a torque drive on a motion command; it knows nothing of friction or inertia.

    T = kp e + ki sum e dt + kd D e,      e = (y_r - y) / travel_per_rad

``D`` is the backward difference behind a lag of ``filter_s``. The command is a
:class:`~leadscrew.references.Motion`, of which it takes the position. The order of computation, the limits and
their anti-windup (clamping): :mod:`leadscrew.controllers._parallel`. A positive torque moves the stage in the positive
direction.

The yardstick of every controller with a friction model.

Bumpless start: the integral is preset so that the next output is the last one.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import Gains, Lower, PIDState, Upper, aligned, ordered, parallel
from leadscrew.controllers._sliding.fields import Travel
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Unit


class TorquePidParams(NamedTuple):
    """Gains, filter and limits."""

    kp: Annotated[float, Unit("N m/rad"), Ge(0), Doc("torque per error")] = 1.0
    ki: Annotated[float, Unit("N m/(rad s)"), Ge(0), Doc("torque per integral of the error")] = 0.0
    kd: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("torque per rate of the error")] = 0.0
    filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the rate, by backward Euler; 0 for none")] = 0.0
    travel_per_rad: Travel = 1.0
    lower: Lower = -math.inf
    upper: Upper = math.inf


def gains(p):
    """The gains as the parallel law takes them; clamping at the limit."""
    return Gains(p.kp, p.ki, p.kd, p.filter_s, p.lower, p.upper, 1, 0.0)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    e = (command.position - feedback) / params.travel_per_rad
    return aligned(gains(params), e, e, output)


@controller(TorquePidParams, PIDState, prepare=ordered, align=align, unit="N m", drive="torque")
def torque_pid(p, s, command, feedback, dt):
    """Parallel PID on a motion command, without a model of friction; a torque."""
    e = (command.position - feedback) / p.travel_per_rad
    return parallel(gains(p), s, e, e, e, dt)
