"""Parallel PID controller, two degrees of freedom.

    u = kp (b r - y) + ki sum (r - y) dt + kd D(c r - y)

``D`` is the backward difference over the period, behind a lag of ``filter_s`` (none by default). ``b = 1, c = 1``, no
filter and no limit, the defaults, make it the plain law

    u_k = kp e_k + ki sum_(j<=k) e_j dt + kd (e_k - e_(k-1)) / dt,      e = command - feedback,  e_(-1) = 0

``c = 0`` differentiates the measurement alone, ``b < 1`` softens steps of the command. The order of computation, the
limits and both anti-windup rules: :mod:`leadscrew.controllers._parallel`. A positive output moves the axis in the
positive direction. If the drive saturates, say so in ``lower`` and ``upper``: the controller does not see the actuator.

Units: those of the plant; the gains are outputs per unit of the error. The defaults pass the error on: ``kp = 1``.

Bumpless start: the integral is preset so that the next output is the last one. Without integral action (``ki = 0``)
the output starts from the proportional term; with very little, it takes as long as ``kp / ki`` to forget the preset.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import (
    AntiWindup,
    Filter,
    Lower,
    PIDState,
    Terms,
    Tracking,
    Upper,
    aligned,
    gains,
    ordered,
    parallel,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit


class PIDParams(NamedTuple):
    """Gains, weights of the command, filter and limits."""

    kp: Annotated[float, Ge(0), Doc("proportional gain, output per error")] = 1.0
    ki: Annotated[float, Unit("1/s"), Ge(0), Doc("integral gain, output per error and second")] = 0.0
    kd: Annotated[float, Unit("s"), Ge(0), Doc("derivative gain, output per change of the error in a second")] = 0.0
    b: Annotated[float, Ge(0), Le(2), Doc("weight of the command in the proportional term")] = 1.0
    c: Annotated[float, Ge(0), Le(2), Doc("weight of the command in the derivative; 0 for the measurement alone")] = 1.0
    filter_s: Filter = 0.0
    lower: Lower = -math.inf
    upper: Upper = math.inf
    anti_windup: AntiWindup = 1
    tracking_s: Tracking = 0.1


def terms(p, command, feedback):
    """What the three terms act on."""
    return Terms(p.b * command - feedback, command - feedback, p.c * command - feedback, 1.0)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    t = terms(params, command, feedback)
    return aligned(gains(params), t.proportional, t.differentiated, output)


@controller(PIDParams, PIDState, prepare=ordered, align=align)
def pid(p, s, command, feedback, dt):
    """Parallel PID with weights of the command, a filtered derivative, limits and anti-windup."""
    t = terms(p, command, feedback)
    return parallel(gains(p), s, t.proportional, t.integrated, t.differentiated, dt)
