"""What a turning operation is told: the force to hold, and the programmed depth of cut with its next change.

    depth(t) = (start + step min(floor(t / every_s), steps)) min(t / entry_s, 1),      0 from ``leave_s`` on

The stairs are those of a contour that is cut in one pass; ``entry_s`` is the time in which the edge engages (0: it is
in the cut from the start). A machine control knows its programme, so the command also carries the depth after the next
change and the seconds until then: a controller may act before the depth does. Tool entry is not announced.

Source: section 5.2 of the paper of the study ``grey_turning``: 1 mm, then 0.2 mm less after each 2 s, at 150 N.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

NEVER_S = 1e9
"""Seconds until a change that does not come."""

EARLY = 1e-9
"""Share of an interval by which a change may come early: sampling instants are rounded numbers."""


class DepthProgram(NamedTuple):
    """Stairs of the depth of cut, with entry and exit of the tool."""

    start: Annotated[float, Unit("mm"), Ge(0), Doc("depth of cut at the start")] = 1.0
    step: Annotated[float, Unit("mm"), Doc("what each change adds to it")] = 0.0
    every_s: Annotated[float, Unit("s"), Gt(0), Doc("time between two changes")] = 2.0
    steps: Annotated[int, Ge(0), Le(1000), Doc("number of changes")] = 0
    entry_s: Annotated[float, Unit("s"), Ge(0), Doc("time in which the tool enters; 0: it is in the cut")] = 0.0
    leave_s: Annotated[float, Unit("s"), Gt(0), Doc("when it leaves the cut")] = NEVER_S


class CutCommand(NamedTuple):
    """The force to hold, and what the programme says of the depth."""

    force: Annotated[float, Unit("N"), Doc("main cutting force to hold")] = 0.0
    depth: Annotated[float, Unit("mm"), Doc("depth of cut commanded now")] = 0.0
    next_depth: Annotated[float, Unit("mm"), Doc("depth after the next programmed change")] = 0.0
    change_in_s: Annotated[float, Unit("s"), Doc("time until that change")] = NEVER_S


def stair(program, t):
    """How many changes have come at ``t``."""
    return min(math.floor(t / program.every_s + EARLY), 1.0 * program.steps)


def depth_at(program, t):
    """Programmed depth of cut at ``t``, mm; never negative."""
    engaged = min(t / max(program.entry_s, 1e-12), 1.0) if program.entry_s > 0.0 else 1.0
    depth = max(program.start + program.step * stair(program, t), 0.0) * engaged
    return depth if t < program.leave_s else 0.0


def cut_command(force, program, t):
    """The command at ``t``."""
    now = stair(program, t)
    more = now < program.steps
    following = max(program.start + program.step * (now + 1.0), 0.0)
    depth = depth_at(program, t)
    return CutCommand(
        force, depth, following if more else depth, (now + 1.0) * program.every_s - t if more else NEVER_S
    )


class CuttingProgramParams(NamedTuple):
    """Force and depth."""

    force: Annotated[float, Unit("N"), Ge(0), Doc("main cutting force to hold")] = 150.0
    depth: DepthProgram = DepthProgram()


@reference(CuttingProgramParams)
def cutting_program(p, t):
    """The force to hold, the depth of cut and its next change."""
    return cut_command(p.force, p.depth, t)


class CuttingForceParams(NamedTuple):
    """The force to hold."""

    force: Annotated[float, Unit("N"), Ge(0), Doc("main cutting force to hold")] = 150.0


@reference(CuttingForceParams, unit="N")
def cutting_force(p):
    """A constant force, from the start."""
    return p.force
