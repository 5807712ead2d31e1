"""A step behind a critically damped filter of the second order, with its derivatives.

    r'' + 2 rate r' + rate^2 r = rate^2 (initial + distance) from ``start`` on, at rest before
    position = initial + distance (1 - (1 + a) e^-a),   a = rate (t - start)

What a servo's set-point filter makes of a step. Speed and position are continuous, the acceleration jumps at the start
by ``rate^2 distance``. 99 % of the way are made after ``6.64 / rate``.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._motion import Motion

GONE = 700.0
"""e^-700 is 1e-304; beyond begin denormal numbers."""


class FilteredStepParams(NamedTuple):
    """A step in the unit of the loop's command, and the filter."""

    distance: Annotated[float, Doc("height of the step, either sign")] = 1.0
    rate: Annotated[float, Unit("1/s"), Gt(0), Doc("both poles of the filter")] = 150.0
    start: Annotated[float, Unit("s"), Ge(0), Doc("when it steps")] = 0.0
    initial: Annotated[float, Doc("command before it")] = 0.0


@reference(FilteredStepParams)
def filtered_step(p, t):
    """The step as a :class:`~leadscrew.references.Motion`: position, velocity, acceleration."""
    a = p.rate * max(t - p.start, 0.0)
    left = math.exp(-min(a, GONE))
    stepped = 1.0 if t >= p.start else 0.0
    return Motion(
        p.initial + p.distance * (1.0 - (1.0 + a) * left),
        p.distance * p.rate * a * left,
        stepped * p.distance * p.rate * p.rate * (1.0 - a) * left,
    )
