"""A linear scale behind the low-pass of its electronics: filtered, then rounded to its resolution.

    (1 / (2 pi f)) dx/dt = actual - x,      feedback = q floor(x / q + 1/2)

Exact where ``actual`` moves evenly between two samples, so an axis at constant speed ``v`` is seen ``v / (2 pi f)``
late, whatever the period: with ``k = exp(-2 pi f dt)`` and ``m = (1 - k) / (2 pi f dt)``

    x_next = k x + (m - k) actual_last + (1 - m) actual

``low_pass_hz = 0`` is no filter. At the start the filter has settled on the first position that it sees.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.sensors._counts import rounded

TINY = 1e-30
"""Below this a reading that dies away is 0: its tail would end in denormal numbers, which are slow."""


class FilteredRulerParams(NamedTuple):
    """Corner of the low-pass, and resolution."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("distance between two readings, after interpolation")] = 1e-5
    low_pass_hz: Annotated[float, Unit("Hz"), Ge(0), Doc("corner of the low-pass; 0 for none")] = 1000.0


class FilteredRulerState(NamedTuple):
    """What the filter remembers."""

    x: Annotated[float, Unit("mm"), Doc("filtered position")] = 0.0
    last: Annotated[float, Unit("mm"), Doc("true position at the last sample")] = 0.0
    started: Annotated[float, Doc("0 before the first sample, then 1")] = 0.0


class FilteredRulerPlan(NamedTuple):
    """What the step needs."""

    resolution_mm: float
    kept: float
    """Weight of the filter's last value, k."""
    last: float
    """Weight of the last position."""
    now: float
    """Weight of the present position."""


def plan_filtered_ruler(params: FilteredRulerParams, dt: float) -> FilteredRulerPlan:
    """The weights of one period."""
    if params.low_pass_hz <= 0.0:
        return FilteredRulerPlan(params.resolution_mm, 0.0, 0.0, 1.0)
    turned = 2.0 * math.pi * params.low_pass_hz * dt
    kept = math.exp(-turned)
    mean = -math.expm1(-turned) / turned
    return FilteredRulerPlan(params.resolution_mm, kept, mean - kept, 1.0 - mean)


@sensor(FilteredRulerParams, FilteredRulerState, prepare=plan_filtered_ruler, unit="mm")
def filtered_ruler(p, s, actual):
    """The mark nearest to the filtered position."""
    moved = p.kept * s.x + p.last * s.last + p.now * actual
    x = moved if s.started > 0.0 else actual
    kept = x if abs(x) > TINY else 0.0
    return FilteredRulerState(kept, actual, 1.0), rounded(kept, p.resolution_mm)
