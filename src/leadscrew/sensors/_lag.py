"""A first-order lag: ``time_constant dy/dt = actual - y``, ``feedback = y``.

Exact where ``actual`` holds its value over the period that ends at the sample:
``y += (1 - exp(-dt / time_constant)) (actual - y)``. With a time constant of 0 it is the ideal sensor.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Ge, Unit

TINY = 1e-200
"""Below this a settled reading is 0: its tail would end in denormal numbers, which are slow."""


class LagParams(NamedTuple):
    """A slow sensor."""

    time_constant: Annotated[float, Unit("s"), Ge(0), Doc("time to 63 % of a step")] = 0.001


class LagState(NamedTuple):
    """The reading."""

    reading: float = 0.0


class LagPlan(NamedTuple):
    """What the step needs."""

    gain: float
    """``1 - exp(-dt / time_constant)``."""


def plan_lag(params: LagParams, dt: float) -> LagPlan:
    """The share of the difference that one period makes up."""
    return LagPlan(-math.expm1(-dt / params.time_constant) if params.time_constant > 0.0 else 1.0)


@sensor(LagParams, LagState, prepare=plan_lag)
def lag(p, s, actual):
    """The reading at the end of a period in which the plant showed ``actual``."""
    reading = s.reading + p.gain * (actual - s.reading)
    kept = reading if abs(reading) > TINY else 0.0
    return LagState(kept), kept
