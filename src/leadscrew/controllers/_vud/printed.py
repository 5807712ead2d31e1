"""The VUD controller of Long, Yuan, Xu, Du (2014) as printed, and three in which one equation is another.

All see the axis through :mod:`leadscrew.controllers._vud.universe`: ``e``, ``ec``, their factors ``alpha``, and
``shape``, what the rules say on the contracted universes. They differ in what becomes of ``shape``::

    vud                  rho_(k+1) = beta(rho_k) shape                               (21) with (19) as printed
    vud_beta_e           rho_(k+1) = clip(beta(e_k) shape, -1, 1)                    the error in place of the duty
    vud_incremental      rho_(k+1) = clip(rho_k + gain shape, -1, 1)                 increments, no factor
    vud_integral_factor  rho_(k+1) = clip(beta_k shape, -1, 1)                       Li's integral factor

- ``vud``: ``beta(rho) = |rho|^tau + 0.0001``, 1 in the first period. The duty follows from that of the last period: for
  a constant ``shape`` below one it falls to ``shape^(1/(1-tau))``, a tenth power. That makes the printed law creep;
  see the claims of the study ``vud_lathe``.
- ``vud_beta_e``: ``beta(e) = output_gain (|e|^output_tau + 0.0001)``, ``output_gain`` in the first period. The error in
  place of the duty removes the memory. Exponent and gain, 0.6 and 1.5, are of a search over 600 pairs on the nominal
  plant; because of the gain the duty is clipped. ``output_gain=1, output_tau=0.5`` is the milder variant that the study
  calls ``vud_beta_e_half``.
- ``vud_incremental``: a duty that must fall to 0 at the target is one more integrator behind an axis that is one
  itself: no gain makes it settle.
- ``vud_integral_factor``: ``beta = clip(integral_gain B + start, lowest, 1)``, ``B_(k+1) = B_k - e_k dt``, ``B_0 = 0``,
  the form of Li's adaptive contraction, where the output's factor integrates the inputs. The factor stays as wide as
  the move has made it, so that the axis hunts at the target, and a move to the positive side shrinks it.
  ``integral_gain`` and ``start`` are what a search over 75 pairs on the nominal plant took for the best (its measure is
  not known). A constant factor of 0.5, ``integral_gain=0``, hunts less: the integral earns nothing here. ``floor``,
  that of the inputs' factors, is 0.01 in place of the printed 0.0001, with which the axis hunts over twenty times as
  wide.

The duties of the first two are those of :mod:`leadscrew.controllers._vud.family` to the last bit; ``ec`` of the first
period is not (-0 here where the change is negative, 0 there), so they are blocks of their own.
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
    VudState,
    contraction,
    held,
    ready,
    view,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit


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


@controller(VudParams, VudState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud(p, s, command, feedback, dt):
    """The duty by (21): the last duty's factor times what the rules say on the contracted universes."""
    now = view(p, s, command, feedback, dt)
    beta = contraction(s.rho, p.settings.tau, p.settings.floor, s.started)
    rho = beta * now.shape
    return VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, beta, rho, 1.0), rho


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


@controller(VudBetaEParams, VudState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_beta_e(p, s, command, feedback, dt):
    """The duty by (21) with a factor that follows the error."""
    now = view(p, s, command, feedback, dt)
    beta = p.settings.output_gain * contraction(now.e, p.settings.output_tau, p.settings.floor, s.started)
    rho = held(beta * now.shape, 1.0)
    return VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, beta, rho, 1.0), rho


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


@controller(VudIncrementalParams, VudState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_incremental(p, s, command, feedback, dt):
    """The duty of the last period and what the rules add to it."""
    now = view(p, s, command, feedback, dt)
    rho = held(s.rho + p.settings.gain * now.shape, 1.0)
    return VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, 1.0, rho, 1.0), rho


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


class VudIntegralFactorState(NamedTuple):
    """What the controller saw and did last, and what it has integrated."""

    seen: VudState = VudState()
    integral: Annotated[float, Unit("s"), Doc("integral of -e")] = 0.0


@controller(
    VudIntegralFactorParams, VudIntegralFactorState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1
)
def vud_integral_factor(p, s, command, feedback, dt):
    """The duty by (21) with a factor that integrates the error."""
    now = view(p, s.seen, command, feedback, dt)
    beta = min(1.0, max(p.settings.lowest, p.settings.integral_gain * s.integral + p.settings.start))
    rho = held(beta * now.shape, 1.0)
    seen = VudState(now.e, now.ec, now.alpha_e, now.alpha_ec, beta, rho, 1.0)
    return VudIntegralFactorState(seen, s.integral - now.e * dt), rho
