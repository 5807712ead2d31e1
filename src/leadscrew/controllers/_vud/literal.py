"""The VUD controller of Long, Yuan, Xu, Du (2014) as printed: equations (17) to (21).

    rho_(k+1) = beta(rho_k) * shape(e_k / alpha_e, ec_k / alpha_ec)                        (21)
    beta(rho) = |rho|^tau + 0.0001,  1 in the first period                                 (19)

with ``e``, ``ec``, the factors ``alpha`` and ``shape`` of :mod:`leadscrew.controllers._vud.universe`. The duty of this
period is made from the duty of the last one: for a constant ``shape`` below one it falls to ``shape^(1/(1-tau))``,
a tenth power. That makes the printed law creep; see the claims of the study ``vud_lathe``.
"""

from __future__ import annotations

from typing import NamedTuple

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


class VudParams(NamedTuple):
    """Scales, contraction factors and rules of the printed controller."""

    error_full_scale_mm: ErrorScale = 190.0
    rate_full_scale_mm: RateScale = 25.87
    rate_interval_s: RateInterval = 0.1
    tau: Tau = 0.9
    floor: Floor = 1e-4
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


def ready(params: VudParams, dt: float) -> VudInputs:
    """The parameters as the step reads them."""
    return ready_inputs(params)


@controller(VudParams, VudState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud(p, s, command, feedback, dt):
    """The duty by (21): the last duty's factor times what the rules say on the contracted universes."""
    now = view(p, s, command, feedback, dt)
    beta = contraction(s.rho, p.tau, p.floor, s.started)
    rho = beta * now.shape
    return VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, beta, rho, 1.0), rho
