"""A plain PD controller of the lathe axis, for comparison: no rules, no universes.

    rho = clip(-kp (error + t_d d), -1, 1),    d = low-pass of (error_k - error_(k-1)) / dt

The low-pass is a lag of ``filter_s``, exact for a held input; in the first period ``d`` is 0. Gains: 47.6 per 190 mm
and 15.4 ms, tuned on the nominal plant.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Unit


class DutyPDParams(NamedTuple):
    """Gains of the PD controller."""

    kp: Annotated[float, Unit("1/mm"), Ge(0), Doc("duty per millimetre of error")] = 47.6 / 190.0
    t_d: Annotated[float, Unit("s"), Ge(0), Doc("derivative time")] = 0.0154
    filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the derivative's low-pass")] = 0.00055


class DutyPDState(NamedTuple):
    """The last error and the filtered derivative."""

    error: Annotated[float, Unit("mm")] = 0.0
    derivative: Annotated[float, Unit("mm/s")] = 0.0
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


class DutyPD(NamedTuple):
    """The gains as the step reads them."""

    kp: float
    t_d: float
    kept: float
    """Share of the filtered derivative that stays over a period."""


def ready(params: DutyPDParams, dt: float) -> DutyPD:
    """The gains with the low-pass worked out for the period."""
    kept = math.exp(-dt / params.filter_s) if params.filter_s > 0.0 else 0.0
    return DutyPD(params.kp, params.t_d, kept)


@controller(DutyPDParams, DutyPDState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def duty_pd(p, s, command, feedback, dt):
    """The duty against the error and its filtered derivative."""
    error = command - feedback
    raw = s.started * (error - s.error) / dt
    derivative = p.kept * s.derivative + (1.0 - p.kept) * raw
    flushed = derivative if abs(derivative) > 1e-30 else 0.0
    rho = min(1.0, max(-1.0, -p.kp * (error + p.t_d * flushed)))
    return DutyPDState(error, flushed, rho, 1.0), rho
