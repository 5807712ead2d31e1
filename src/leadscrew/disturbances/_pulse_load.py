"""A load for a while: ``size`` for ``duration`` from ``start`` on, 0 before and after."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Unit


class PulseLoadParams(NamedTuple):
    """A load in the unit of the plant's load."""

    size: Annotated[float, Doc("load during the pulse")] = 1.0
    start: Annotated[float, Unit("s"), Ge(0), Doc("when the load comes on, to the nearest period")] = 0.0
    duration: Annotated[float, Unit("s"), Ge(0), Doc("how long it stays, to the nearest period")] = 0.1


@disturbance(PulseLoadParams)
def pulse_load(p, t, dt):
    """``size`` from the sample nearest to ``start`` until the one nearest to ``start + duration``."""
    return p.size if t > p.start - 0.5 * dt and t <= p.start + p.duration - 0.5 * dt else 0.0
