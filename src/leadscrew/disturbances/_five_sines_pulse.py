"""Five sines and a pulse on top: the forces of a cut, and a push that comes once.

    load = force (sum over the lines of amplitude sin(2 pi frequency t + phase)) + pulse

``force`` multiplies all lines at once; with ``force = 1`` and a pulse of size 0 it is ``five_sines`` bit for bit.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.disturbances._five_sines import Line, one
from leadscrew.disturbances._pulse_load import PulseLoadParams
from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge


class FiveSinesPulseParams(NamedTuple):
    """The lines, how strong they are together, and the pulse."""

    first: Line = Line(2.1)
    second: Line = Line(3.5)
    third: Line = Line(4.9)
    fourth: Line = Line(6.3)
    fifth: Line = Line(7.7)
    force: Annotated[float, Ge(0), Doc("what all lines are multiplied with")] = 1.0
    pulse: PulseLoadParams = PulseLoadParams(size=0.0)


@disturbance(FiveSinesPulseParams)
def five_sines_pulse(p, t, dt):
    """The sum of five sines, and the pulse while it lasts."""
    lines = p.force * (one(p.first, t) + one(p.second, t) + one(p.third, t) + one(p.fourth, t) + one(p.fifth, t))
    after = p.pulse.start + p.pulse.duration - 0.5 * dt
    on = t > p.pulse.start - 0.5 * dt and t <= after
    return lines + p.pulse.size if on else lines
