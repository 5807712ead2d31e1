"""Parallel PID controller of a voltage drive, two degrees of freedom.

    u = kp (b r - y) + ki sum (r - y) dt + kd D(c r - y)

``D`` is the backward difference over the period, behind a lag of ``filter_s`` (none by default). ``b = 1, c = 1``, no
filter and no limit, the defaults, make it the plain law

    u_k = kp e_k + ki sum_(j<=k) e_j dt + kd (e_k - e_(k-1)) / dt,      e = command - feedback,  e_(-1) = 0

``c = 0`` differentiates the measurement alone, ``b < 1`` softens steps of the command. The order of computation, the
limit and both anti-windup rules: :mod:`leadscrew.controllers._parallel`. A positive output moves the axis in the
positive direction. If the drive saturates, say so in ``lower`` and ``upper``: the controller does not see the actuator.

Gains: Table I of Abdullah et al. (XY table, NPID), with Ki / Kp = 1/1600 s: nearly a PD. Better ones: :data:`TUNINGS`.

Bumpless start: the integral is preset so that the next output is the last one. Without integral action (``ki = 0``)
the output starts from the proportional term; with very little, it takes as long as ``kp / ki`` to forget the preset.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import (
    AntiWindup,
    Filter,
    Kd,
    Ki,
    Kp,
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
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.parameters import Doc, Ge, Le


class PIDParams(NamedTuple):
    """Gains, weights of the command, filter and limit."""

    kp: Kp = 1.32
    ki: Ki = 0.000825
    kd: Kd = 0.006805
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


@controller(PIDParams, PIDState, prepare=ordered, align=align, unit="V", drive="voltage", full_scale=10.0)
def pid(p, s, command, feedback, dt):
    """Parallel PID with weights of the command, a filtered derivative, a limit and anti-windup; a voltage."""
    t = terms(p, command, feedback)
    return parallel(gains(p), s, t.proportional, t.integrated, t.differentiated, dt)


TUNINGS: dict[str, Block] = {
    "paper.pid": pid,
    "ours.pid_ms_159": pid(kp=1.17, ki=175.5, kd=0.00433),
    "ours.pid_ms_185": pid(kp=1.6533, ki=248.0, kd=0.00533),
}
"""For the XY table at 2 kHz with 0.775 ms of delay: Table I, and two of ours by their peak of sensitivity."""
