"""Five sines: a load with lines at five frequencies, each with its own amplitude and phase.

    load = sum over the lines of amplitude sin(2 pi frequency t + phase)

The defaults are the odd harmonics 3 to 11 of a motion of 0.7 Hz, where the position errors of Abdullah et al. (XY
table, NPID) have their lines by Table II; their amplitudes are 0 until given.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Unit

TWO_PI = 2.0 * math.pi


class Line(NamedTuple):
    """One line of the spectrum."""

    frequency: Annotated[float, Unit("Hz"), Ge(0), Doc("cycles per second")] = 1.0
    amplitude: Annotated[float, Doc("half of peak to peak, in the unit of the load")] = 0.0
    phase: Annotated[float, Unit("rad"), Doc("angle at t = 0")] = 0.0


class FiveSinesParams(NamedTuple):
    """The lines."""

    first: Line = Line(2.1)
    second: Line = Line(3.5)
    third: Line = Line(4.9)
    fourth: Line = Line(6.3)
    fifth: Line = Line(7.7)


def one(line, t):
    """A single line at ``t``."""
    return line.amplitude * math.sin(TWO_PI * line.frequency * t + line.phase)


@disturbance(FiveSinesParams)
def five_sines(p, t):
    """The sum of five sines."""
    return one(p.first, t) + one(p.second, t) + one(p.third, t) + one(p.fourth, t) + one(p.fifth, t)
