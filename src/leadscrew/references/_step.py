"""A step: ``initial`` before ``time``, ``target`` from then on."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Unit


class StepParams(NamedTuple):
    """A step in the unit of the loop's command."""

    initial: Annotated[float, Doc("command before the step")] = 0.0
    target: Annotated[float, Doc("command after the step")] = 1.0
    time: Annotated[float, Unit("s"), Ge(0), Doc("when the command steps, to the nearest period")] = 0.0


@reference(StepParams)
def step(p, t, dt):
    """``target`` from the sample nearest to ``time`` on, ``initial`` before."""
    return p.target if t > p.time - 0.5 * dt else p.initial
