"""A move from rest to rest by a polynomial of the fifth degree, with its derivatives.

    x = (t - start) / duration, held inside [0, 1]
    position = initial + distance (10 x^3 - 15 x^4 + 6 x^5)

Speed and acceleration are 0 at both ends and continuous everywhere, the jerk is finite: the smoothest step that a
controller with ``y_r''`` can be given. The largest speed is ``1.875 distance / duration``, in the middle, the largest
acceleration ``5.774 distance / duration^2`` (``10 / sqrt(3)``).

``duration = 0`` is a bare step: its derivatives do not exist at the jump and are given as 0, which is what a controller
that has only a position would assume. A drive answers that with a blow.

Source: any textbook on trajectories (minimum-jerk polynomial; T. Flash, N. Hogan, J. Neuroscience 5, 1985).
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.references._motion import Motion


class QuinticParams(NamedTuple):
    """A move in the unit of the loop's command."""

    distance: Annotated[float, Doc("length of the move, either sign")] = 1.0
    duration: Annotated[float, Unit("s"), Ge(0), Doc("how long it takes; 0 for a bare step")] = 0.05
    start: Annotated[float, Unit("s"), Ge(0), Doc("when it starts")] = 0.0
    initial: Annotated[float, Doc("command before it")] = 0.0


@reference(QuinticParams)
def quintic(p, t):
    """The move as a :class:`~leadscrew.references.Motion`: position, velocity, acceleration."""
    since = t - p.start
    there = since >= p.duration
    moving = since > 0.0 and not there
    rate = 1.0 / p.duration if moving else 0.0
    x = since * rate if moving else 1.0 if there else 0.0
    left = 1.0 - x
    return Motion(
        p.initial + p.distance * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
        p.distance * 30.0 * x * x * left * left * rate,
        p.distance * 60.0 * x * left * (1.0 - 2.0 * x) * rate * rate,
    )
