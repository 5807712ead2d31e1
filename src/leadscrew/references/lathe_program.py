"""What a retrofitted lathe is told, and the three voltages that its control gives: signals of the whole lathe.

    command(t) = (rpm, force, depth(t), next_depth, change_in_s)

The spindle speed and the force are constant; the depth of cut follows the stairs of
:mod:`leadscrew.references.cutting_program`, with its next change told in advance. ``force_from_s``: until then the
force asked for is ``idle_force`` (0: the feed stands still), so that the spindle can run up and the tool plunge first.

Source: sections 2 and 5 of the paper of the study ``grey_turning``: loops 1 (spindle speed), 2 (force, by the feed) and
3 (depth of cut) of the old lathe, 1,200 1/min and 150 N.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.sheet import Doc, Ge, Unit
from leadscrew.references.cutting_program import NEVER_S, DepthProgram, cut_command


class LatheCommand(NamedTuple):
    """What the three loops are to hold, and what the programme says of the depth."""

    rpm: float = 0.0
    """Spindle speed, 1/min."""
    force: float = 0.0
    """Main cutting force, N."""
    depth: float = 0.0
    """Depth of cut, mm."""
    next_depth: float = 0.0
    """Depth after the next programmed change, mm."""
    change_in_s: float = NEVER_S
    """Seconds until that change."""


class LatheDrive(NamedTuple):
    """Three analogue outputs of the control."""

    spindle_v: float = 0.0
    """To the inverter of the spindle, V."""
    feed_v: float = 0.0
    """To the servo of the carriage, V."""
    radial_v: float = 0.0
    """To the servo of the cross slide, V; positive: deeper."""


class LatheProgramParams(NamedTuple):
    """Speed, force and depth."""

    rpm: Annotated[float, Unit("1/min"), Ge(0), Doc("spindle speed to hold")] = 1200.0
    force: Annotated[float, Unit("N"), Ge(0), Doc("main cutting force to hold")] = 150.0
    depth: DepthProgram = DepthProgram()
    force_from_s: Annotated[float, Unit("s"), Ge(0), Doc("when the force is asked for")] = 0.0
    idle_force: Annotated[float, Unit("N"), Ge(0), Doc("force asked for until then")] = 0.0


@reference(LatheProgramParams())
def lathe_program(p, t, dt):
    """Spindle speed, force and depth of cut, with the next change of the depth."""
    told = cut_command(p.force if t + 0.5 * dt >= p.force_from_s else p.idle_force, p.depth, t)
    return LatheCommand(p.rpm, told.force, told.depth, told.next_depth, told.change_in_s)
