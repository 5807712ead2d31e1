"""The VUD controller with the rules read as increments of the duty: the rules' answer is added, not multiplied.

    rho_(k+1) = clip(rho_k + gain shape(e / alpha_e, ec / alpha_ec), -1, 1)                in place of (19) and (21)

with ``e``, ``ec``, the factors ``alpha`` and ``shape`` of :mod:`leadscrew.controllers._vud.universe`. A duty that must
fall to 0 at the target is one more integrator behind an axis that is one itself: no gain makes it settle.
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
from leadscrew.kernel.parameters import Doc, Gt, Le


class VudIncrementalParams(NamedTuple):
    """Scales, contraction factors and rules, and what one period adds."""

    error_full_scale_mm: ErrorScale = 190.0
    rate_full_scale_mm: RateScale = 25.87
    rate_interval_s: RateInterval = 0.1
    tau: Tau = 0.9
    floor: Floor = 1e-4
    gain: Annotated[float, Gt(0), Le(1), Doc("duty per period that the rules' 1 adds")] = 0.01
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


class VudIncremental(NamedTuple):
    """The parameters as the step reads them."""

    inputs: VudInputs
    gain: float


def ready(params: VudIncrementalParams, dt: float) -> VudIncremental:
    """The parameters as the step reads them."""
    return VudIncremental(ready_inputs(params), params.gain)


@controller(VudIncrementalParams, VudState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_incremental(p, s, command, feedback, dt):
    """The duty of the last period and what the rules add to it."""
    now = view(p.inputs, s, command, feedback, dt)
    rho = min(1.0, max(-1.0, s.rho + p.gain * now.shape))
    return VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, 1.0, rho, 1.0), rho
