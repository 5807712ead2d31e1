"""A sine: ``offset + amplitude sin(2 pi frequency t + phase)``, alone and with its derivatives."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.references._motion import Motion

TWO_PI = 2.0 * math.pi


class SineParams(NamedTuple):
    """A sine in the unit of the loop's command."""

    amplitude: Annotated[float, Doc("half of peak to peak")] = 1.0
    frequency: Annotated[float, Unit("Hz"), Ge(0), Doc("cycles per second")] = 1.0
    phase: Annotated[float, Unit("rad"), Doc("angle at t = 0; pi/2 gives a cosine")] = 0.0
    offset: Annotated[float, Doc("mean of the command")] = 0.0


@reference(SineParams)
def sine(p, t):
    """``offset + amplitude sin(2 pi frequency t + phase)``."""
    return p.offset + p.amplitude * math.sin(TWO_PI * p.frequency * t + p.phase)


@reference(SineParams)
def sine_motion(p, t):
    """The same sine as a :class:`Motion`: position, velocity, acceleration."""
    omega = TWO_PI * p.frequency
    wave = p.amplitude * math.sin(omega * t + p.phase)
    slope = p.amplitude * math.cos(omega * t + p.phase)
    return Motion(p.offset + wave, omega * slope, -omega * omega * wave)
