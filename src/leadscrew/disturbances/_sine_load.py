"""A load that swings: ``offset + amplitude sin(2 pi frequency t + phase)``."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Unit

TWO_PI = 2.0 * math.pi


class SineLoadParams(NamedTuple):
    """A load in the unit of the plant's load."""

    amplitude: Annotated[float, Doc("half of peak to peak")] = 1.0
    frequency: Annotated[float, Unit("Hz"), Ge(0), Doc("cycles per second")] = 1.0
    phase: Annotated[float, Unit("rad"), Doc("angle at t = 0")] = 0.0
    offset: Annotated[float, Doc("mean of the load")] = 0.0


@disturbance(SineLoadParams)
def sine_load(p, t):
    """``offset + amplitude sin(2 pi frequency t + phase)``."""
    return p.offset + p.amplitude * math.sin(TWO_PI * p.frequency * t + p.phase)
