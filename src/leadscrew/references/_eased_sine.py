"""A sine that grows from rest: ``w(t) amplitude sin(2 pi frequency t)``, alone and with its derivatives.

    x = t / ease_s, held inside [0, 1],      w = 10 x^3 - 15 x^4 + 6 x^5

From ``ease_s`` on it is the plain sine; before that position, speed and acceleration are continuous, so neither the
axis nor a feed-forward of the acceleration gets a blow. ``ease_s = 0`` starts the sine at full size.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.references._motion import Motion

TWO_PI = 2.0 * math.pi


class EasedSineParams(NamedTuple):
    """A sine in the unit of the loop's command."""

    amplitude: Annotated[float, Doc("half of peak to peak")] = 1.0
    frequency: Annotated[float, Unit("Hz"), Ge(0), Doc("cycles per second")] = 1.0
    ease_s: Annotated[float, Unit("s"), Ge(0), Doc("time in which it grows to full size")] = 1.0


def eased(p, t):
    """Position, velocity and acceleration at ``t``."""
    growing = t < p.ease_s
    rate = 1.0 / p.ease_s if growing else 0.0
    x = t * rate if growing else 1.0
    left = 1.0 - x
    w = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    dw = 30.0 * x * x * left * left * rate
    ddw = 60.0 * x * left * (1.0 - 2.0 * x) * rate * rate
    omega = TWO_PI * p.frequency
    wave = p.amplitude * math.sin(omega * t)
    slope = p.amplitude * omega * math.cos(omega * t)
    return Motion(w * wave, dw * wave + w * slope, ddw * wave + 2.0 * dw * slope - w * omega * omega * wave)


@reference(EasedSineParams)
def eased_sine(p, t):
    """The growing sine as a number."""
    return eased(p, t).position


@reference(EasedSineParams)
def eased_sine_motion(p, t):
    """The growing sine as a :class:`~leadscrew.references.Motion`."""
    return eased(p, t)
