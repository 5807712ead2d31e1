"""A spindle whose speed wanders: two lines that move, together with five that stand still.

    load  = five_sines(t) + spindle_v sin(2 pi n + spindle_phase) + tooth_v sin(teeth 2 pi n + tooth_phase)
    dn/dt = spindle_hz (1 + drift t + wander sin(2 pi t / wander_s)),      n(0) = 0, in turns

As every load it is held for one period: a line at ``f`` acts ``T / 2`` late and smaller by ``sinc(f T)``, 0.4 % at
100 Hz and 2 kHz. For lines that stand still, acting exactly: :obj:`leadscrew.plants.xy_table_cutting`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.disturbances._five_sines import FiveSinesParams, five_sines
from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

TWO_PI = 2.0 * math.pi


class WanderingSpindleParams(NamedTuple):
    """The lines that stand still, and the spindle."""

    lines: FiveSinesParams = FiveSinesParams()
    spindle_hz: Annotated[float, Unit("Hz"), Ge(0), Doc("revolutions a second at t = 0")] = 50.0
    drift: Annotated[float, Unit("1/s"), Ge(-1), Le(1), Doc("growth of the speed, as a share of it, a second")] = 0.0
    wander: Annotated[float, Ge(0), Le(1), Doc("largest deviation of the speed, as a share of it")] = 0.0
    wander_s: Annotated[float, Unit("s"), Gt(0), Doc("period of that deviation")] = 10.0
    spindle_v: Annotated[float, Unit("V"), Doc("force line once a revolution, as a voltage at the input")] = 1e-3
    spindle_phase: Annotated[float, Unit("rad"), Doc("its angle at t = 0")] = 0.0
    teeth: Annotated[int, Ge(1), Le(100), Doc("teeth of the cutter")] = 2
    tooth_v: Annotated[float, Unit("V"), Doc("force line once a tooth, as a voltage at the input")] = 2e-3
    tooth_phase: Annotated[float, Unit("rad"), Doc("its angle at t = 0")] = 0.0


def speed_hz(p, t):
    """Revolutions a second at ``t``."""
    return p.spindle_hz * (1.0 + p.drift * t + p.wander * math.sin(TWO_PI * t / p.wander_s))


@disturbance(WanderingSpindleParams)
def wandering_spindle(p, t):
    """Five sines and two lines of a spindle whose speed drifts and wanders."""
    swung = p.wander * p.wander_s / TWO_PI * (1.0 - math.cos(TWO_PI * t / p.wander_s))
    turns = p.spindle_hz * (t + 0.5 * p.drift * t * t + swung)
    spindle = p.spindle_v * math.sin(TWO_PI * turns + p.spindle_phase)
    return five_sines(p.lines, t) + spindle + p.tooth_v * math.sin(TWO_PI * p.teeth * turns + p.tooth_phase)
