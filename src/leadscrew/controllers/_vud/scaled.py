"""The VUD controller with scaled inputs and no output factor: quick and still, with Table 2 as printed.

    xe = held(error_gain e),  xec = held(rate_gain lag(ec))                    e, ec by (5), (6); held in [-1, 1]
    alpha_e = |xe|^e_tau + e_floor,  alpha_ec = |xec|^ec_tau + ec_floor,  1 in the first period        (17), (18)
    drive = output_gain shape(xe / alpha_e, xec / alpha_ec) + I
    rho = clip(drive + sgn(drive) dead_zone_share dead_zone, -1, 1)

``beta = 1``: no memory of the duty, so nothing creeps. The floors of 0.17 in place of 0.0001 keep the contracted rules
from acting as a relay on the last count of the grating, and the low-pass keeps one count out of ``ec``.

Two options against friction, both off by default, since a table of rules has no integral action of its own:

- ``I`` integrates ``-integral_gain error`` (mm) while ``|error| < integral_zone_mm``, and is 0 outside it and inside
  ``integral_reset_mm``, which is less than a count: it ends with the error;
- the inverse of a dead zone of ``dead_zone`` (duty) adds a share of it. More than all of it makes the axis hunt.

The defaults are the result of a search (differential evolution) on the nominal axis of 289 mm/s; :data:`ROBUST` of one
over slow and fast axes with an imperfect grating, which is no slower on the nominal one.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._vud.family import filtered_rate, low_pass
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
    contraction,
    held,
)
from leadscrew.fuzzy.inference import RuleBase, infer, rule_base
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit


class VudScaledParams(NamedTuple):
    """Scales, contraction factors, gain and rules; integral action and the inverse of a dead zone."""

    error_full_scale_mm: ErrorScale = 190.0
    rate_full_scale_mm: RateScale = 25.87
    rate_interval_s: RateInterval = 0.1
    error_gain: Annotated[float, Gt(0), Le(1000), Doc("gain of e before it is held")] = 4.612
    rate_gain: Annotated[float, Ge(0), Le(1000), Doc("gain of ec before it is held")] = 0.494
    filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the low-pass of ec; 0 for none")] = 0.00213
    e_tau: Exponent = 0.236
    e_floor: Least = 0.1685
    ec_tau: Exponent = 0.0986
    ec_floor: Least = 0.1685
    output_gain: Annotated[float, Gt(0), Le(1000), Doc("duty that the rules' 1 stands for, before the limit")] = 2.638
    integral_gain: Annotated[float, Unit("1/(mm s)"), Ge(0), Doc("duty per millimetre and second; 0 for none")] = 0.0
    integral_zone_mm: Annotated[float, Unit("mm"), Gt(0), Doc("size of error below which it integrates")] = 0.1
    integral_reset_mm: Annotated[float, Unit("mm"), Ge(0), Doc("size of error below which the integral is 0")] = 0.0006
    dead_zone: Annotated[float, Ge(0), Le(1), Doc("duty below which the motor is believed to stand")] = 0.0
    dead_zone_share: Annotated[float, Ge(0), Le(2), Doc("share of it that is added to the duty")] = 0.8
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


ROBUST = VudScaledParams(
    error_gain=4.94,
    rate_gain=0.41,
    filter_s=0.00064,
    e_tau=0.1595,
    e_floor=0.4053,
    ec_tau=0.0628,
    ec_floor=0.4204,
    output_gain=5.0,
)
"""For axes of 259 to 334 mm/s at full duty, found by differential evolution over the eight numbers above.

- Population 40, about 800 generations, NumPy's ``default_rng(1)``; the nominal set was one of the first population.
- Bounds, in the order above: 2..12, 0.1..1.5, 0.5..6 ms, 0.05..0.7, 0.02..0.5, 0.02..0.5, 0.02..0.5, 1..5.
- Steps to -50 and -170 mm on 14 axes, 7 speeds from 259 to 334 mm/s twice: once with the ideal count; once with one or
  two waves a pitch in the grating's reading (to 0.15 and 0.08 um), 50 nm of noise and a backlash of up to 2 um.
- Cost: the latest entry into 2 um over 0.29 s and 0.74 s; added to it 0.5 per um of overshoot above 1 um, 2 per um of
  error after 1.2 s above 0.31 um (ideal) or 0.6 um, 100 per unit of chatter with the ideal count.
- Rounded to four digits. On 41 other speeds and other errors, backlash to 4 um: 0.284 s and 0.746 s, 1.0 um, 0.35 um.

The gain is at its bound on purpose: with 15 allowed, 2 um comes 0.013 s earlier and the duty is half as noisy again.
The floors are at 0.4, so the search has all but taken the contraction away: robust means nearly fixed universes here.
"""


class VudScaledState(NamedTuple):
    """What the controller saw and did last, all of it worth recording."""

    e: Annotated[float, Doc("normalised error, without gain")] = 0.0
    ec: Annotated[float, Doc("normalised change of the error, behind its low-pass, without gain")] = 0.0
    alpha_e: Annotated[float, Doc("contraction of the universe of e")] = 1.0
    alpha_ec: Annotated[float, Doc("contraction of the universe of ec")] = 1.0
    integral: Annotated[float, Doc("duty of the integral action")] = 0.0
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


class VudScaled(NamedTuple):
    """The parameters as the step reads them."""

    settings: VudScaledParams
    kept: Annotated[float, Doc("share of the filtered rate that stays over a period")]
    offset: Annotated[float, Doc("duty added against the dead zone")]
    rules: RuleBase


def ready(params: VudScaledParams, dt: float) -> VudScaled:
    """The parameters as the step reads them, the rules checked.

    Raises:
        ValueRefused: centres that do not increase.
    """
    rules = rule_base(params.e_centres, params.ec_centres, params.rules)
    return VudScaled(params, low_pass(params.filter_s, dt), params.dead_zone * params.dead_zone_share, rules)


def integrated(p, s, error, dt):
    """The integral action: 0 far away, 0 at the target, the sum of errors between."""
    size = abs(error)
    inside = size < p.integral_zone_mm and size >= p.integral_reset_mm
    return s.integral - p.integral_gain * error * dt if inside else 0.0


@controller(VudScaledParams, VudScaledState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_scaled(p, s, command, feedback, dt):
    """The duty by the rules on the contracted universes, with the options against friction."""
    g = p.settings
    error = command - feedback
    e = error / g.error_full_scale_mm
    ec = filtered_rate(g, s, e, p.kept, dt)
    xe, xec = held(g.error_gain * e, 1.0), held(g.rate_gain * ec, 1.0)
    alpha_e = contraction(xe, g.e_tau, g.e_floor, s.started)
    alpha_ec = contraction(xec, g.ec_tau, g.ec_floor, s.started)
    integral = integrated(g, s, error, dt)
    drive = g.output_gain * infer(p.rules, xe / alpha_e, xec / alpha_ec) + integral
    offset = p.offset if drive > 0.0 else -p.offset if drive < 0.0 else 0.0
    rho = held(drive + offset, 1.0)
    return VudScaledState(e, ec, alpha_e, alpha_ec, integral, rho, 1.0), rho
