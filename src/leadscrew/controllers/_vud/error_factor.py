"""The VUD controller with one equation changed: the output's factor follows the error, not the last duty.

    rho_(k+1) = clip(beta(e_k) * shape(e_k / alpha_e, ec_k / alpha_ec), -1, 1)             (21), clipped
    beta(e) = output_gain (|e|^output_tau + 0.0001),  output_gain in the first period      in place of (19)

Changes to :mod:`leadscrew.controllers._vud.literal`, and nothing else:

- (19): the error in place of the duty, which removes the memory that makes the printed law creep;
- (19): an exponent and a gain of its own, 0.6 and 1.5 (from a search over 600 pairs on the nominal plant);
- (21): the duty is clipped to [-1, 1], because the gain may ask for more.

With ``output_gain=1, output_tau=0.5`` it is the milder variant that the study calls ``vud_beta_e_half``.
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
    contraction,
    ready_inputs,
    view,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le


class VudBetaEParams(NamedTuple):
    """Scales, contraction factors and rules, with an output factor of its own."""

    error_full_scale_mm: ErrorScale = 190.0
    rate_full_scale_mm: RateScale = 25.87
    rate_interval_s: RateInterval = 0.1
    tau: Tau = 0.9
    floor: Floor = 1e-4
    output_tau: Annotated[float, Ge(0), Le(2), Doc("exponent of the output's factor")] = 0.6
    output_gain: Annotated[float, Gt(0), Doc("gain of the output's factor")] = 1.5
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


class VudBetaE(NamedTuple):
    """The parameters as the step reads them."""

    inputs: VudInputs
    output_tau: float
    output_gain: float


def ready(params: VudBetaEParams, dt: float) -> VudBetaE:
    """The parameters as the step reads them."""
    return VudBetaE(ready_inputs(params), params.output_tau, params.output_gain)


@controller(VudBetaEParams, VudState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_beta_e(p, s, command, feedback, dt):
    """The duty by (21) with a factor that follows the error."""
    now = view(p.inputs, s, command, feedback, dt)
    beta = p.output_gain * contraction(now.e, p.output_tau, p.inputs.floor, s.started)
    rho = min(1.0, max(-1.0, beta * now.shape))
    return VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, beta, rho, 1.0), rho
