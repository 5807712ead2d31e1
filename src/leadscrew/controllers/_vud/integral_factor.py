"""The VUD controller with Li's integral output factor in place of (19).

    rho_(k+1) = clip(beta shape(e / alpha_e, ec / alpha_ec), -1, 1)                                        (21), clipped
    beta = clip(integral_gain B + start, lowest, 1),   B_(k+1) = B_k - e_k dt,  B_0 = 0

with ``e``, ``ec``, the factors ``alpha`` and ``shape`` of :mod:`leadscrew.controllers._vud.universe`. The form is that
of Li's adaptive contraction, where the output's factor integrates the inputs. It has two weaknesses: the factor stays
as wide as the move has made it, so that the axis hunts at the target, and a move to the positive side shrinks it.

``integral_gain`` and ``start`` are what a search over 75 pairs on the nominal plant took for the best (its measure is
not known). A constant factor of 0.5, ``integral_gain=0``, hunts less: the integral earns nothing here. ``floor``, that
of the inputs' factors, is 0.01 in place of the printed 0.0001, with which the axis hunts over twenty times as wide.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._vud.universe import (
    CENTRES,
    TABLE_2,
    Centres,
    ErrorScale,
    Floor,
    RateInterval,
    RateScale,
    Rules,
    Tau,
    VudInputs,
    VudState,
    ready_inputs,
    view,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit


class VudIntegralFactorParams(NamedTuple):
    """Scales, contraction factors and rules, with an output factor that integrates the error."""

    error_full_scale_mm: ErrorScale = 190.0
    rate_full_scale_mm: RateScale = 25.87
    rate_interval_s: RateInterval = 0.1
    tau: Tau = 0.9
    floor: Floor = 0.01
    integral_gain: Annotated[float, Unit("1/s"), Ge(0), Doc("growth of the factor per second at e = -1")] = 0.5
    start: Annotated[float, Ge(0), Le(1), Doc("factor before anything is integrated")] = 0.3
    lowest: Annotated[float, Gt(0), Le(1), Doc("smallest factor")] = 0.01
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


class VudIntegralFactor(NamedTuple):
    """The parameters as the step reads them."""

    inputs: VudInputs
    integral_gain: float
    start: float
    lowest: float


class VudIntegralFactorState(NamedTuple):
    """What the controller saw and did last, and what it has integrated."""

    seen: VudState = VudState()
    integral: Annotated[float, Unit("s"), Doc("integral of -e")] = 0.0


def ready(params: VudIntegralFactorParams, dt: float) -> VudIntegralFactor:
    """The parameters as the step reads them."""
    return VudIntegralFactor(ready_inputs(params), params.integral_gain, params.start, params.lowest)


@controller(
    VudIntegralFactorParams(), VudIntegralFactorState(), prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1
)
def vud_integral_factor(p, s, command, feedback, dt):
    """The duty by (21) with a factor that integrates the error."""
    now = view(p.inputs, s.seen, command, feedback, dt)
    beta = min(1.0, max(p.lowest, p.integral_gain * s.integral + p.start))
    rho = min(1.0, max(-1.0, beta * now.shape))
    integral = s.integral - now.e * dt
    seen = VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, beta, rho, 1.0)
    return VudIntegralFactorState(seen, integral), rho
