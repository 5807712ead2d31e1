"""Cascade of a servo axis, in the axis' own units, with feed-forward of an identified model.

::

    w  = kpos (r - y) + D (velocity_share r - y)                        error of the speed; D: backward difference,
                                                                        in the first term of u behind a lag filter_s
    u  = kvp w + kvi sum w dt + model_share (M r'' + B r' + C(r') + O)  at the time t + ahead_s
    C  = coulomb_forward tanh(r' / smooth) for r' >= 0, coulomb_backward tanh(r' / smooth) for r' < 0

``M, B, C, O`` are inertia, viscous friction, Coulomb friction and offset of the axis, all in units of the drive: what a
log tells (:mod:`leadscrew.identify.axis.fit`), divided by the force of a unit of the drive. The friction is that of the
commanded speed, so it is no feedback; ``tanh`` spreads its leap over the speeds below ``smooth``. ``ahead_s``: dead
time and half a period, because the output is held.

The command is a :class:`~leadscrew.references.Motion`. Units: those of the position shown (``mm``, say) and of the
drive (V, A, N). With ``velocity_share = 1``, no lag and ``model_share = 0`` it is the PID of
:obj:`leadscrew.controllers.cascade_ppi`. At ``lower`` and ``upper`` the integral waits (clamping). Bumpless start: the
integral is preset. Structure: G. Ellis, *Control System Design Guide*, 4th ed., 2012, chapters 12 and 16; the gains
that a machine file gets are of :mod:`leadscrew.machine.gains`. Default numbers: the EMPS axis, with the gains of its
log.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._look_ahead import advanced
from leadscrew.controllers._parallel import Lower, Upper, ordered
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

TINY = 1e-30


class AxisModel(NamedTuple):
    """The axis in units of its drive."""

    acceleration: Annotated[float, Unit("drive s^2/mm"), Ge(0), Doc("drive per acceleration, M")] = 0.0
    viscous: Annotated[float, Unit("drive s/mm"), Ge(0), Doc("drive per speed, B")] = 0.0
    coulomb_forward: Annotated[float, Unit("drive"), Ge(0), Doc("drive against Coulomb friction forwards")] = 0.0
    coulomb_backward: Annotated[float, Unit("drive"), Ge(0), Doc("drive against Coulomb friction backwards")] = 0.0
    offset: Annotated[float, Unit("drive"), Doc("drive that holds what pushes backwards, O")] = 0.0
    smooth: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed over which the leap of Coulomb friction is spread")] = 0.5


class AxisCascadeParams(NamedTuple):
    """Gains of both loops, model and limits."""

    kpos: Annotated[float, Unit("1/s"), Ge(0), Doc("speed per position error")] = 1.0
    kvp: Annotated[float, Unit("drive s/mm"), Ge(0), Doc("drive per speed error")] = 1.0
    kvi: Annotated[float, Unit("drive/mm"), Ge(0), Doc("drive per integral of the speed error")] = 0.0
    velocity_share: Annotated[float, Ge(0), Le(2), Doc("share of the commanded speed in the speed loop")] = 0.0
    model_share: Annotated[float, Ge(0), Le(2), Doc("share of the model's drive that is added")] = 0.0
    filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the speed, by backward Euler; 0 for none")] = 0.0
    ahead_s: Annotated[float, Unit("s"), Ge(0), Le(0.1), Doc("how far ahead the command is read")] = 0.0
    lower: Lower = -math.inf
    upper: Upper = math.inf
    model: AxisModel = AxisModel()


class AxisCascadeState(NamedTuple):
    """What the cascade remembers."""

    integral: Annotated[float, Unit("mm"), Doc("integral of the speed error")] = 0.0
    command: Annotated[float, Unit("mm"), Doc("commanded position of the last period")] = 0.0
    feedback: Annotated[float, Unit("mm"), Doc("measured position of the last period")] = 0.0
    speed: Annotated[float, Unit("mm/s"), Doc("speed error less the position's part, behind its lag")] = 0.0
    fresh: Annotated[float, Doc("1 before the first period, 2 after a bumpless start, else 0")] = 1.0


def model_drive(p, command):
    """What the believed axis needs for the motion ``ahead_s`` after ``command``."""
    then = advanced(command, p.ahead_s)
    m = p.model
    coulomb = m.coulomb_forward if then.velocity >= 0.0 else m.coulomb_backward
    friction = m.viscous * then.velocity + coulomb * math.tanh(then.velocity / m.smooth)
    return p.model_share * (m.acceleration * then.acceleration + friction + m.offset)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; without ``kvi`` the one of a controller at rest."""
    known = params.kvp * params.kpos * (command.position - feedback) + model_drive(params, command)
    integral = (output - known) / params.kvi if params.kvi > 0.0 else 0.0
    return AxisCascadeState(integral, command.position, feedback, 0.0, 2.0)


@controller(AxisCascadeParams, AxisCascadeState, prepare=ordered, align=align)
def axis_cascade(p, s, command, feedback, dt):
    """Position loop P around a speed loop PI, with feed-forward of an identified axis; in units of its drive."""
    going = 1.0 if s.fresh == 0.0 else 0.0
    integrating = 0.0 if s.fresh == 2.0 else 1.0
    position = p.kpos * (command.position - feedback)
    moved = going * (p.velocity_share * (command.position - s.command) - (feedback - s.feedback))
    change = integrating * (position * dt + moved)
    integral = s.integral + change
    speed = (p.filter_s * s.speed + moved) / (p.filter_s + dt)
    raw = p.kvp * (position + speed) + p.kvi * integral + model_drive(p, command)
    output = min(max(raw, p.lower), p.upper)
    outwards = (raw - output) * change > 0.0
    kept = s.integral if outwards else integral
    slow = speed if abs(speed) > TINY else 0.0
    return AxisCascadeState(kept if abs(kept) > TINY else 0.0, command.position, feedback, slow, 0.0), output
