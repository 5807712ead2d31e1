"""A digital-to-analogue converter: the output in whole steps of its range, held at its ends.

    q = (upper - lower) / 2^bits,      u = clip(q floor(output / q + 1/2), lower, upper - q)

``bits = 0`` is an ideal converter: the range only. What is not finite is taken as 0 V, within the range. A converter
of 12 bits and -10 to 10 V has steps of 4.88 mV; at 150 mm/min per volt that is 0.73 mm/min of feed, at 1 mm depth of
cut in S45C 2.4 N.

:data:`lathe_dac` is three of them, for the voltages of spindle, feed and cross slide.

Source: Figure 1 of the paper of the study ``grey_turning`` names the card (ADLINK PCI-8136, six analogue outputs), but
no resolution; 12 bits and -10 to 10 V are assumed.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit
from leadscrew.references._lathe_program import LatheDrive
from leadscrew.util.errors import ValueRefused


class DacParams(NamedTuple):
    """Resolution and range."""

    bits: Annotated[int, Ge(0), Le(32), Doc("resolution; 0: no rounding")] = 12
    lower: Annotated[float, Unit("V"), Doc("lower end of the range")] = -10.0
    upper: Annotated[float, Unit("V"), Doc("upper end of the range")] = 10.0


class DacPlan(NamedTuple):
    """What the step needs."""

    per_volt: float
    """Steps a volt; 0 without rounding."""
    quantum: float
    lower: float
    upper: float


def plan_dac(params: DacParams, dt: float) -> DacPlan:
    """The quantum and the largest value.

    Raises:
        ValueRefused: the ends of the range are not in order.
    """
    if params.lower >= params.upper:
        raise ValueRefused(f"lower = {params.lower!r} (dac): must lie below upper = {params.upper!r}")
    if params.bits == 0:
        return DacPlan(0.0, 0.0, params.lower, params.upper)
    quantum = (params.upper - params.lower) / 2.0**params.bits
    return DacPlan(1.0 / quantum, quantum, params.lower, params.upper - quantum)


def converted(p, output):
    """One voltage as the converter gives it; 0 V for what is not finite."""
    asked = min(max(output, p.lower), p.upper + p.quantum) if math.isfinite(output) else 0.0
    step = p.quantum * math.floor(asked * p.per_volt + 0.5)
    return min(max(step if p.per_volt > 0.0 else asked, p.lower), p.upper)


@actuator(DacParams, prepare=plan_dac, unit="V")
def dac(p, output):
    """The nearest step of the converter."""
    return converted(p, output)


class LatheDacParams(NamedTuple):
    """The three converters of a lathe."""

    spindle: DacParams = DacParams()
    feed: DacParams = DacParams()
    radial: DacParams = DacParams()


class LatheDacPlan(NamedTuple):
    """What the three need."""

    spindle: DacPlan
    feed: DacPlan
    radial: DacPlan


def plan_lathe_dac(params: LatheDacParams, dt: float) -> LatheDacPlan:
    """The three plans.

    Raises:
        ValueRefused: the ends of a range are not in order.
    """
    return LatheDacPlan(plan_dac(params.spindle, dt), plan_dac(params.feed, dt), plan_dac(params.radial, dt))


@actuator(LatheDacParams, prepare=plan_lathe_dac, unit="V")
def lathe_dac(p, output):
    """Three voltages, each in the steps of its converter."""
    return LatheDrive(
        converted(p.spindle, output.spindle_v), converted(p.feed, output.feed_v), converted(p.radial, output.radial_v)
    )
