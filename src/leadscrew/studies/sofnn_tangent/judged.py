"""The place of the cut: what a user sees of a wrong tangent."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import metric
from leadscrew.kernel.sheet import Doc, Gt, Unit
from leadscrew.plants.flexible_cut import RADIAN


class Along(NamedTuple):
    """How fast the blade goes."""

    feed: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the blade along the line")] = 50.0


class Aside(NamedTuple):
    """Where the cut is, and how far it was."""

    place: float = 0.0
    largest: float = 0.0


def farthest(p, s):
    """The largest distance."""
    return s.largest


@metric(Along(), Aside(), output=farthest, unit="mm")
def lateral(p, s, error, t, dt):
    """Largest deviation of the cut from the programmed line, to either side: ``max abs(int sin e ds)``."""
    place = s.place - math.sin(RADIAN * error) * p.feed * dt
    return Aside(place, max(s.largest, abs(place)))
