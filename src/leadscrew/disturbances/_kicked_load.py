"""A constant or slowly changing load, with a kick at the start: what finds out whether a loop chatters under load.

    load = size + rate min(t, max(2 turn_s - t, 0)) + kick sin(2 pi kick_hz t)        the kick until ``kick_s`` only

With ``rate`` 0 the load is constant. Otherwise it rises until ``turn_s`` and falls back as fast: a loop that behaves
otherwise on the way down than on the way up has hysteresis.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Unit

TWO_PI = 2.0 * math.pi


class KickedLoadParams(NamedTuple):
    """A load in the unit of the plant's load."""

    size: Annotated[float, Doc("load at t = 0")] = 0.0
    rate: Annotated[float, Unit("1/s"), Doc("by how much it rises a second, until turn_s")] = 0.0
    turn_s: Annotated[float, Unit("s"), Ge(0), Doc("when it stops to rise and begins to fall")] = 0.0
    kick: Annotated[float, Doc("amplitude of the kick, in the unit of the load")] = 0.0
    kick_hz: Annotated[float, Unit("Hz"), Ge(0), Doc("frequency of the kick")] = 190.0
    kick_s: Annotated[float, Unit("s"), Ge(0), Doc("end of the kick")] = 2.0


@disturbance(KickedLoadParams)
def kicked_load(p, t):
    """A load that rises and falls slowly, or stays, with a sine on top at the start."""
    slow = p.size + p.rate * min(t, max(2.0 * p.turn_s - t, 0.0))
    return slow + (p.kick * math.sin(TWO_PI * p.kick_hz * t) if t < p.kick_s else 0.0)
