"""A load that comes on and stays: 0 before ``time``, ``size`` from then on."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Unit


class StepLoadParams(NamedTuple):
    """A load in the unit of the plant's load."""

    size: Annotated[float, Doc("load after the step")] = 1.0
    time: Annotated[float, Unit("s"), Ge(0), Doc("when the load comes on, to the nearest period")] = 0.0


@disturbance(StepLoadParams)
def step_load(p, t, dt):
    """``size`` from the sample nearest to ``time`` on."""
    return p.size if t > p.time - 0.5 * dt else 0.0
