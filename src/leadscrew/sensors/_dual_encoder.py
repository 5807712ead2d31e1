"""Two encoders for one loop: the motor's at once, the table's through a lag (dual position feedback).

    feedback = m + c,      lag dc/dt = (x - m) - c        m, x: readings of the motor and of the table, each rounded

What happens fast is seen at the motor, where neither play nor the screw's swinging delays it; what remains, the table
decides. After a reversal across a play the error dies out with ``lag``, as far as the rest of the loop is faster. With
``lag = 0`` it is the table's scale, with a long one the motor's encoder. Exact where the readings hold over the
period that ends at the sample. It starts at ``c = 0``: where the motor was set.

Source: the usual hybrid of semi-closed and fully closed loop of machine controls ("dual position feedback"); the lag of
10 ms is ours. For plants with both (:mod:`leadscrew.plants._backlash`), in the unit in which they show them.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.sensors._counts import counted

TINY = 1e-30
"""Below this a settled correction is 0: its tail would end in denormal numbers, which are slow."""


class DualEncoderParams(NamedTuple):
    """The lag, and the resolution of both encoders."""

    lag: Annotated[float, Unit("s"), Ge(0), Doc("time in which the table's reading takes over")] = 0.01
    resolution: Annotated[float, Ge(0), Doc("one count, in the unit of the plant; 0 for none")] = 1e-5


class DualEncoderState(NamedTuple):
    """The correction; both encoders show the same at the start."""

    correction: float = 0.0


class DualEncoderPlan(NamedTuple):
    """What the step needs."""

    gain: float
    resolution: float


def plan_dual_encoder(params: DualEncoderParams, dt: float) -> DualEncoderPlan:
    """The share of the difference that one period makes up."""
    return DualEncoderPlan(-math.expm1(-dt / params.lag) if params.lag > 0.0 else 1.0, params.resolution)


@sensor(DualEncoderParams, DualEncoderState, prepare=plan_dual_encoder)
def dual_encoder(p, s, actual):
    """The motor's count, corrected slowly by the table's."""
    motor, table = counted(actual.motor, p.resolution), counted(actual.position, p.resolution)
    correction = s.correction + p.gain * (table - motor - s.correction)
    kept = correction if abs(correction) > TINY else 0.0
    return DualEncoderState(kept), motor + kept
