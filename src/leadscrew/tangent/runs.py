"""What a program cuts, from plunge to lift, told from what it moves above the work."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from leadscrew.kernel.errors import DataError
from leadscrew.tangent.interpreter import Step

SAME_HEIGHT_MM = 1e-6
"""Heights this close are one."""


class Run(NamedTuple):
    """Moves that cut, from plunge to lift."""

    steps: list[Step]
    offset: float
    """Of the axis at the plunge, deg, as a comment says."""
    plunge: float | None
    """Slowest feed of the way down to it, mm/min; 0: rapid; None: it does not go down."""


def runs_of(steps: Sequence[Step], name: str) -> tuple[list[Run], list[int]]:
    """What cuts, and the lines of what moves X or Y above the work otherwise than to the start of a cut."""
    lowest = min((s.end[2] for s in steps if s.code and s.flat > 0.0), default=0.0)
    top = top_of(steps)
    found: list[Run] = []
    above: list[int] = []
    cutting, offset = False, 0.0
    plunge: float | None = None
    waiting: Step | None = None
    for step in steps:
        falls = step.end[2] - step.start[2]
        if step.code and step.flat > 0.0 and abs(falls) > SAME_HEIGHT_MM:
            raise DataError(
                f"{name}, line {step.line}: X or Y moves together with Z: a ramp is not a cut at one depth; expected "
                "to plunge, then to cut"
            )
        air = lowest + SAME_HEIGHT_MM < step.end[2] >= top - SAME_HEIGHT_MM
        if falls or (step.flat > 0.0 and (step.code == 0 or air)):
            cutting = False
            if step.flat > 0.0:
                above += [] if waiting is None else [waiting.line]
                waiting = step
            if falls > 0.0:
                plunge = None
            elif falls < 0.0:
                plunge = min((v for v in (plunge, step.feed) if v), default=0.0)
        elif step.flat > 0.0 and not cutting:
            found.append(Run([], offset, plunge))
            cutting, waiting = True, None
        if cutting:
            found[-1].steps.append(step)
        offset = offset if step.offset is None else step.offset
    above += [] if waiting is None else [waiting.line]
    for run in found:
        while run.steps[-1].curve is None:
            run.steps.pop()
    return found, above


def top_of(steps: Sequence[Step]) -> float:
    """The highest place that the program brings the knife to, mm; where it is before the first, nobody knows."""
    return max((s.end[2] for s in steps if s.end[2] != s.start[2]), default=steps[0].start[2])
