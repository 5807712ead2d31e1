"""One controller for all variants of the VUD law: what is printed and what may be changed are parameters of one block.

    xe = held(error_gain e),  xec = held(rate_gain lag(ec))                    e, ec by (5), (6)
    rho_(k+1) = clip(beta(z_k) shape(xe / alpha_e, xec / alpha_ec), -output_limit, output_limit)           (21)
    alpha(x) = 1  |  |x|^tau + floor, (17), (18)  |  1 - depth exp(-steepness x^2)            none, power, exponential
    beta(z) = output_gain (z + output_floor),  output_gain output_first in the first period             (19)
    z = 1  |  |rho|^t  |  |xe|^t  |  |xec|^t  |  (|xe| |xec|)^t  |  (|xe|^t + |xec|^t) / 2  |  max(|xe|, |xec|)^t

with ``t = output_tau`` and ``output_from`` none, duty, error, rate, product, mean, maximum in the order of the last
line (at none ``beta = output_gain``). In the first period the factors ``alpha`` are 1 and ``ec`` is 0. ``held`` keeps a
value inside [-1, 1] where ``hold_inputs`` is on. A ``rate_gain`` of 0 ignores the rate, a negative one reverses it;
``rate_interval_s`` equal to the period takes the raw difference of two periods for ``ec``.

With its defaults this is the printed law, but clipped; :data:`PRINTED` and :data:`BETA_E` are the parameters with which
it is ``vud`` and ``vud_beta_e`` of :mod:`leadscrew.controllers._vud.printed`, duty for duty to the last bit.
Dozens of variants then share one compiled program. Source of (5) to (21): Long, Yuan, Xu, Du (2014); the other ``z``
and the exponential ``alpha`` are in the literature on variable universes, and here to compare with.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

from leadscrew.controllers._vud.universe import (
    CENTRES,
    TABLE_2,
    Centres,
    ErrorScale,
    Exponent,
    Least,
    RateInterval,
    RateScale,
    Rules,
    change,
    held,
)
from leadscrew.fuzzy.inference import RuleBase, infer, rule_base
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

TINY = 1e-30
"""Below this the filtered rate is 0: its tail would end in denormal numbers, which are slow."""

Kind = Annotated[
    Literal["none", "power", "exponential"] | int,
    Doc("contraction factor: 1, |x|^tau + floor, 1 - depth exp(-steepness x^2)"),
]


class VudFamilyParams(NamedTuple):
    """Scales, contraction factors, output factor and rules."""

    error_full_scale_mm: ErrorScale = 190.0
    rate_full_scale_mm: RateScale = 25.87
    rate_interval_s: RateInterval = 0.1
    error_gain: Annotated[float, Gt(0), Le(1000), Doc("gain of e before the rules")] = 1.0
    rate_gain: Annotated[float, Ge(-1000), Le(1000), Doc("gain of ec; 0 ignores it, below 0 reverses it")] = 1.0
    filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the low-pass of ec; 0 for none")] = 0.0
    hold_inputs: Annotated[Literal["off", "on"] | int, Doc("both inputs inside [-1, 1] before they are contracted")] = 0
    e_kind: Kind = 1
    e_tau: Exponent = 0.9
    e_floor: Least = 1e-4
    ec_kind: Kind = 1
    ec_tau: Exponent = 0.9
    ec_floor: Least = 1e-4
    bell_depth: Annotated[float, Ge(0), Le(0.999), Doc("depth of the exponential factors")] = 0.9
    bell_steepness: Annotated[float, Ge(0), Doc("steepness of the exponential factors")] = 5.0
    output_from: Annotated[
        Literal["none", "duty", "error", "rate", "product", "mean", "maximum"] | int,
        Doc("what beta follows: nothing, the last duty, e, ec, or product, mean or maximum of e and ec"),
    ] = 1
    output_tau: Annotated[float, Ge(0), Le(2), Doc("exponent of the output's factor")] = 0.9
    output_floor: Annotated[float, Ge(0), Le(1), Doc("floor of the output's factor")] = 1e-4
    output_gain: Annotated[float, Gt(0), Le(1000), Doc("gain of the output's factor")] = 1.0
    output_first: Annotated[float, Ge(0), Le(1000), Doc("the output's factor in the first period, before its gain")] = (
        1.0
    )
    output_limit: Annotated[float, Gt(0), Le(1000), Doc("largest size of the duty")] = 1.0
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


class VudFamilyState(NamedTuple):
    """What the controller saw and did last, all of it worth recording."""

    e: Annotated[float, Doc("normalised error, without gain")] = 0.0
    ec: Annotated[float, Doc("normalised change of the error, behind its low-pass, without gain")] = 0.0
    alpha_e: Annotated[float, Doc("contraction of the universe of e")] = 1.0
    alpha_ec: Annotated[float, Doc("contraction of the universe of ec")] = 1.0
    beta: Annotated[float, Doc("contraction of the universe of the duty")] = 1.0
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


class VudFamily(NamedTuple):
    """The parameters as the step reads them."""

    settings: VudFamilyParams
    kept: Annotated[float, Doc("share of the filtered rate that stays over a period")]
    largest: Annotated[float, Doc("largest size of an input before it is contracted")]
    rules: RuleBase


PRINTED = {"output_limit": 2.0}
"""With these parameters the family is the block ``vud``, whose duty stays below 1.01 without a limit."""

BETA_E: dict[str, str | float] = {"output_from": "error", "output_tau": 0.6, "output_gain": 1.5}
"""With these parameters the family is the block ``vud_beta_e``."""


def low_pass(filter_s: float, dt: float) -> float:
    """Share that a lag of ``filter_s`` keeps over a period ``dt`` of held input; 0 where there is no lag."""
    return math.exp(-dt / filter_s) if filter_s > 0.0 else 0.0


def ready(params: VudFamilyParams, dt: float) -> VudFamily:
    """The parameters as the step reads them, the rules checked.

    Raises:
        ValueRefused: centres that do not increase.
    """
    return VudFamily(
        params,
        low_pass(params.filter_s, dt),
        1.0 if params.hold_inputs else 1e300,
        rule_base(params.e_centres, params.ec_centres, params.rules),
    )


def filtered_rate(p, s, e, kept, dt):
    """``ec`` of (6) behind its low-pass: 0 in the first period, which has no earlier error."""
    ec = kept * s.ec + (1.0 - kept) * (s.started * change(p, s, e, dt) / p.rate_full_scale_mm)
    return ec if abs(ec) > TINY else 0.0


def factor(x, kind, tau, floor, depth, steepness):
    """A contraction factor by its kind."""
    power = abs(x) ** tau + floor
    bell = 1.0 - depth * math.exp(-steepness * x * x)
    return power if kind == 1 else bell if kind == 2 else 1.0


def output_factor(p, rho, xe, xec):
    """``z + output_floor``, 1 where the output's factor follows nothing."""
    duty, a, b = abs(rho), abs(xe), abs(xec)
    followed = duty if p.output_from == 1 else a if p.output_from == 2 else b if p.output_from == 3 else a * b
    one = max(a, b) if p.output_from == 6 else a if p.output_from == 5 else followed
    other = b if p.output_from == 5 else one
    z = 0.5 * (one**p.output_tau + other**p.output_tau)
    return 1.0 if p.output_from == 0 else z + p.output_floor


@controller(VudFamilyParams, VudFamilyState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_family(p, s, command, feedback, dt):
    """The duty by (21) with the factors that the parameters choose."""
    g = p.settings
    e = (command - feedback) / g.error_full_scale_mm
    ec = filtered_rate(g, s, e, p.kept, dt)
    xe, xec = held(g.error_gain * e, p.largest), held(g.rate_gain * ec, p.largest)
    alpha_e = factor(xe, g.e_kind, g.e_tau, g.e_floor, g.bell_depth, g.bell_steepness) if s.started > 0.0 else 1.0
    alpha_ec = factor(xec, g.ec_kind, g.ec_tau, g.ec_floor, g.bell_depth, g.bell_steepness) if s.started > 0.0 else 1.0
    shape = infer(p.rules, xe / alpha_e, xec / alpha_ec)
    beta = g.output_gain * (output_factor(g, s.rho, xe, xec) if s.started > 0.0 else g.output_first)
    rho = held(beta * shape, g.output_limit)
    return VudFamilyState(e, ec, alpha_e, alpha_ec, beta, rho, 1.0), rho
