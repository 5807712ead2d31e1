"""A ramp that holds: ``initial + rate (t - start)`` for ``duration``, constant before and after.

``ramp_motion`` is the same with its derivatives.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.references._motion import Motion


class RampParams(NamedTuple):
    """A ramp in the unit of the loop's command."""

    initial: Annotated[float, Doc("command before the ramp")] = 0.0
    rate: Annotated[float, Unit("1/s"), Doc("change of the command per second, either sign")] = 1.0
    start: Annotated[float, Unit("s"), Ge(0), Doc("when the ramp starts")] = 0.0
    duration: Annotated[float, Unit("s"), Ge(0), Doc("how long the command changes; it holds from then on")] = 1.0


@reference(RampParams)
def ramp(p, t):
    """``initial + rate`` times the time spent on the ramp."""
    return p.initial + p.rate * min(max(t - p.start, 0.0), p.duration)


@reference(RampParams)
def ramp_motion(p, t):
    """The same ramp as a :class:`~leadscrew.references.Motion`; acceleration 0, at the corners too."""
    since = t - p.start
    running = 1.0 if since >= 0.0 and since < p.duration else 0.0
    return Motion(p.initial + p.rate * min(max(since, 0.0), p.duration), running * p.rate, 0.0)
