"""Cascade of a servo drive: proportional position loop around a PI of speed, with feed-forward.

    w  = kpos (r - y) + velocity_share D r - D y            error of the speed; D is the backward difference
    u  = kvp w + kvi sum w dt + acceleration_v r''

The command is a :class:`~leadscrew.references.Motion`, ``r`` its position. The commanded speed is differenced as
the measured one is, so both are late by the same half period.

**With unit velocity feed-forward it is the PID** of :obj:`leadscrew.controllers.pid`, term by term, because
``sum D e dt = e``:

    Kd = kvp,      Kp = kvp kpos + kvi,      Ki = kvi kpos

:func:`as_pid` and :func:`of_pid` turn one into the other; two of the pairs ``(kvi, kpos)`` belong to one PID, as the
roots of ``kvp kpos^2 - Kp kpos + Ki = 0``, and the one with the fast position loop is taken. A PID with complex zeros
is no cascade. Without velocity feed-forward (``velocity_share = 0``) a ramp of speed ``v`` lags by ``v / kpos``,
whatever the integral does; stability and what the loop does to a disturbance stay the same.

At ``lower`` and ``upper`` the integral waits (clamping). As in the PID, command and feedback count as zero before the
first period. Bumpless start: the integral is preset.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import Lower, Upper, ordered
from leadscrew.controllers._pid import PIDParams, pid
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit
from leadscrew.util.errors import ValueRefused


class CascadeParams(NamedTuple):
    """Gains of both loops, feed-forward and limits."""

    kpos: Annotated[float, Unit("1/s"), Ge(0), Doc("speed per position error")] = 1.0
    kvp: Annotated[float, Unit("s"), Ge(0), Doc("output per speed error")] = 1.0
    kvi: Annotated[float, Ge(0), Doc("output per integral of the speed error")] = 0.0
    velocity_share: Annotated[float, Ge(0), Le(2), Doc("share of the commanded speed; 1 makes it a PID")] = 1.0
    acceleration_v: Annotated[float, Unit("s^2"), Ge(0), Doc("output per commanded acceleration")] = 0.0
    lower: Lower = -math.inf
    upper: Upper = math.inf


class CascadeState(NamedTuple):
    """What the cascade remembers."""

    integral: Annotated[float, Doc("integral of the speed error")] = 0.0
    command: Annotated[float, Doc("commanded position of the last period")] = 0.0
    feedback: Annotated[float, Doc("measured position of the last period")] = 0.0
    aligned: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; without ``kvi`` the one of a controller at rest."""
    known = params.kvp * params.kpos * (command.position - feedback) + params.acceleration_v * command.acceleration
    integral = (output - known) / params.kvi if params.kvi > 0.0 else 0.0
    return CascadeState(integral, command.position, feedback, 1.0)


@controller(CascadeParams, CascadeState, prepare=ordered, align=align)
def cascade_ppi(p, s, command, feedback, dt):
    """Position loop P around a speed loop PI, with feed-forward of speed and acceleration."""
    position = p.kpos * (command.position - feedback)
    moved = p.velocity_share * (command.position - s.command) - (feedback - s.feedback)
    integral = s.integral + (1.0 - s.aligned) * (position * dt + moved)
    raw = p.kvp * (position + moved / dt) + p.kvi * integral + p.acceleration_v * command.acceleration
    output = min(max(raw, p.lower), p.upper)
    outwards = (raw - output) * (position * dt + moved) > 0.0
    return CascadeState(s.integral if outwards else integral, command.position, feedback, 0.0), output


def as_pid(cascade: Block) -> Block:
    """The PID that gives the same output as this cascade with unit velocity feed-forward.

    Raises:
        ValueRefused: a cascade with another share of velocity feed-forward, or with feed-forward of the acceleration.
    """
    p = cascade.params
    if p.velocity_share != 1.0 or p.acceleration_v != 0.0:
        raise ValueRefused(
            f"velocity_share = {p.velocity_share!r}, acceleration_v = {p.acceleration_v!r} (cascade_ppi): it is a PID "
            "with 1 and 0 only"
        )
    return pid(kp=p.kvp * p.kpos + p.kvi, ki=p.kvi * p.kpos, kd=p.kvp, lower=p.lower, upper=p.upper)


def of_pid(block: Block) -> Block:
    """The cascade that gives the same output as this plain PID.

    Raises:
        ValueRefused: a PID without derivative or with complex zeros, with weights of the command, or with a filter.
    """
    p: PIDParams = block.params
    if p.b != 1.0 or p.c != 1.0 or p.filter_s != 0.0:
        raise ValueRefused(f"b = {p.b!r}, c = {p.c!r}, filter_s = {p.filter_s!r} (pid): a cascade has 1, 1 and 0")
    under = p.kp * p.kp - 4.0 * p.kd * p.ki
    if p.kd <= 0.0 or under < 0.0:
        raise ValueRefused(
            f"kp = {p.kp!r}, ki = {p.ki!r}, kd = {p.kd!r} (pid): a cascade needs kd > 0 and kp^2 >= 4 kd ki, real zeros"
        )
    kpos = 0.5 * (p.kp + math.sqrt(under)) / p.kd
    return cascade_ppi(kpos=kpos, kvp=p.kd, kvi=p.ki / kpos, lower=p.lower, upper=p.upper)
