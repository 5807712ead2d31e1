"""The rules of the fuzzy force controller: seven triangular sets an input, four active rules, height defuzzification.

    x = e / S1,  y = ec / S2                     held to [-6, 6]: the outer sets are shouldered
    w_i = mu_i(x) nu_i(y)                        (17), product inference
    w_i = min(mu_i(x), nu_i(y))                  the antecedent of (16), min inference
    output = sum w_i y_i / sum w_i               (18), y_i = 2 S3 times the consequent's index

Sets NB, NM, NS, ZO, PS, PM, PB with peaks at -6, -4, -2, 0, 2, 4, 6 scaling factors and feet at their neighbours'
peaks (Fig 3). The memberships of an input sum to one, so at most two sets of each input, and four rules, are active.
With the product the sum of the ``w_i`` is one and the output is the bilinear interpolation of the table; with the
minimum it lies between 1 and 2 and the output has kinks where two memberships are equal.

With the standard table (:data:`~leadscrew.controllers._grey_fuzzy.rule_tables.STANDARD`) and the product the output is
``S3 (x + y)`` exactly while ``|x + y| <= 4``, and within ``S3 / 2`` of ``S3 clip(x + y, -6, 6)`` elsewhere.

Source: the paper of the study ``grey_turning``, equations (15) to (18) and Fig 3; what its text layer
does not say is ours.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

import numpy as np

from leadscrew.controllers._grey_fuzzy.rule_tables import MOST
from leadscrew.fuzzy.inference import RuleBase, inside_universe, interval_index, rule_base, upper_membership
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

CENTRES = 2.0 * np.arange(-MOST, MOST + 1)
"""Peaks of the sets, in scaling factors."""

ErrorScale = Annotated[float, Unit("N"), Gt(0), Doc("scaling factor S1 of the error: its sets peak every 2 S1")]
ChangeScale = Annotated[float, Unit("N"), Gt(0), Doc("scaling factor S2 of the error's change in one period")]
OutputScale = Annotated[float, Unit("V"), Gt(0), Doc("scaling factor S3 of the output: the rules say up to 6 S3")]
Rules = Annotated[np.ndarray, Ge(-MOST), Le(MOST), Doc("consequents, -3 NB to 3 PB; rows by error, columns by change")]
Inference = Annotated[Literal["product", "minimum"] | int, Doc("how a rule fires: by (17) or (16)")]
Positional = Annotated[bool, Doc("the rules give the output itself; else what one period adds to it")]
Lower = Annotated[float, Unit("V"), Doc("least output")]
Upper = Annotated[float, Unit("V"), Doc("largest output")]


class Surface(NamedTuple):
    """Scaling factors and rules as a step reads them."""

    error_gain: float
    change_gain: float
    output_scale: float
    rules: RuleBase
    inference: int
    positional: bool
    lower: float
    upper: float


class Firing(NamedTuple):
    """The four rules that are active: their corner of the table and their shares, which sum to one."""

    row: int
    column: int
    low_low: float
    low_high: float
    high_low: float
    high_high: float


def ready_surface(params) -> Surface:
    """The parameters that every fuzzy controller of this package has, as the step reads them.

    Raises:
        ValueRefused: limits the wrong way round.
    """
    from leadscrew.util.errors import ValueRefused

    if not params.lower < params.upper:
        raise ValueRefused(f"lower = {params.lower:g} V, upper = {params.upper:g} V: the lower limit must be below")
    return Surface(
        1.0 / params.error_scale, 1.0 / params.change_scale, params.output_scale,
        rule_base(CENTRES, CENTRES, 2.0 * np.asarray(params.rules, dtype=float)),
        params.inference, params.positional, params.lower, params.upper,
    )  # fmt: skip


def firing(p, error, change):
    """Which rules are active at an error and a change of it, and their shares of the output."""
    x = inside_universe(p.rules.first, error * p.error_gain)
    y = inside_universe(p.rules.second, change * p.change_gain)
    i = interval_index(p.rules.first, x)
    j = interval_index(p.rules.second, y)
    mu = upper_membership(p.rules.first, i, x)
    nu = upper_membership(p.rules.second, j, y)
    product = p.inference == 0
    ll = (1.0 - mu) * (1.0 - nu) if product else min(1.0 - mu, 1.0 - nu)
    lh = (1.0 - mu) * nu if product else min(1.0 - mu, nu)
    hl = mu * (1.0 - nu) if product else min(mu, 1.0 - nu)
    hh = mu * nu if product else min(mu, nu)
    share = 1.0 if product else 1.0 / (ll + lh + hl + hh)
    return Firing(i, j, ll * share, lh * share, hl * share, hh * share)


def concluded(p, error, change):
    """What the rules say at an error and a change of it, (18)."""
    f = firing(p, error, change)
    t = p.rules.table
    low = f.low_low * t[f.row, f.column] + f.low_high * t[f.row, f.column + 1]
    high = f.high_low * t[f.row + 1, f.column] + f.high_high * t[f.row + 1, f.column + 1]
    return p.output_scale * (low + high)


def driven(p, before, error, change):
    """The output: what the rules say, added to the output before unless positional; held to its limits."""
    raw = concluded(p, error, change) + (0.0 if p.positional else before)
    return min(max(raw, p.lower), p.upper)


def before_output(p, error, change, output):
    """The output before, from which the next one is ``output``; a positional law has no such memory."""
    return output - concluded(p, error, change)
