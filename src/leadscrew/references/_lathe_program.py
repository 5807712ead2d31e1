"""What a retrofitted lathe is told, and the three voltages that its control gives: signals of the whole lathe.

    command(t) = (rpm, force, depth(t), next_depth, change_in_s)

The spindle speed and the force are constant; the depth of cut follows the stairs of
:obj:`leadscrew.references.cutting_program`, with its next change told in advance. ``force_from_s``: until then the
force asked for is ``idle_force`` (0: the feed stands still), so that the spindle can run up and the tool plunge first.

Source: sections 2 and 5 of the paper of the study ``grey_turning``: loops 1 (spindle speed), 2 (force, by the feed) and
3 (depth of cut) of the old lathe, 1,200 1/min and 150 N.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.references._cutting_program import NEVER_S, DepthProgram, cut_command


class LatheCommand(NamedTuple):
    """What the three loops are to hold, and what the programme says of the depth."""

    rpm: Annotated[float, Unit("1/min"), Doc("spindle speed")] = 0.0
    force: Annotated[float, Unit("N"), Doc("main cutting force")] = 0.0
    depth: Annotated[float, Unit("mm"), Doc("depth of cut")] = 0.0
    next_depth: Annotated[float, Unit("mm"), Doc("depth after the next programmed change")] = 0.0
    change_in_s: Annotated[float, Unit("s"), Doc("time until that change")] = NEVER_S


class LatheDrive(NamedTuple):
    """Three analogue outputs of the control."""

    spindle_v: Annotated[float, Unit("V"), Doc("to the inverter of the spindle")] = 0.0
    feed_v: Annotated[float, Unit("V"), Doc("to the servo of the carriage")] = 0.0
    radial_v: Annotated[float, Unit("V"), Doc("to the servo of the cross slide; positive is deeper")] = 0.0


class LatheProgramParams(NamedTuple):
    """Speed, force and depth."""

    rpm: Annotated[float, Unit("1/min"), Ge(0), Doc("spindle speed to hold")] = 1200.0
    force: Annotated[float, Unit("N"), Ge(0), Doc("main cutting force to hold")] = 150.0
    depth: DepthProgram = DepthProgram()
    force_from_s: Annotated[float, Unit("s"), Ge(0), Doc("when the force is asked for")] = 0.0
    idle_force: Annotated[float, Unit("N"), Ge(0), Doc("force asked for until then")] = 0.0


@reference(LatheProgramParams)
def lathe_program(p, t, dt):
    """Spindle speed, force and depth of cut, with the next change of the depth."""
    told = cut_command(p.force if t + 0.5 * dt >= p.force_from_s else p.idle_force, p.depth, t)
    return LatheCommand(p.rpm, told.force, told.depth, told.next_depth, told.change_in_s)
