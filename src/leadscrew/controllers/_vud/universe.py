"""What every VUD controller shares: its inputs, the contraction of their universes, and the rules on them.

In the order in which it happens, with the numbers of Long, Yuan, Xu, Du (2014):

1. ``e = (command - feedback) / 190 mm``                                     (5)
2. ``ec`` = change of the error per 0.1 s, over 25.87 mm                     (6), see below
3. ``alpha_e = |e|^tau + 0.0001``, ``alpha_ec = |ec|^tau + 0.0001``; 1 in the first period    (17), (18)
4. ``shape`` = output of the rules at ``(e / alpha_e, ec / alpha_ec)``, held inside [-1, 1]     the quotient of (21)

The paper gives the unit of 25.87 as mm/s. Its Table 1 fits only millimetres per 0.1 s, the interval at which the
table was logged (258.7 mm/s), so the interval is a parameter of its own here. ``ec`` is signed: Table 1 prints
magnitudes where the target is positive. In the first period there is no earlier error and ``ec`` is 0.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from leadscrew.fuzzy.inference import RuleBase, infer, rule_base
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

CENTRES = np.array([-1.0, -0.67, -0.33, 0.33, 0.67, 1.0])
"""Peaks of NB, NM, NS, PS, PM, PB (section IV.b, step 3)."""

TABLE_2 = np.array(
    [
        [1.000, 1.000, 1.000, 1.000, 0.677, 0.677],
        [1.000, 1.000, 1.000, 0.677, 0.677, 0.677],
        [0.677, 0.677, 0.677, 0.333, 0.333, 0.333],
        [-0.333, -0.333, -0.333, -0.677, -0.677, -0.677],
        [-0.677, -0.677, -0.677, -1.000, -1.000, -1.000],
        [-0.677, -0.677, -1.000, -1.000, -1.000, -1.000],
    ]
)
"""Table 2 as printed: rows by the sets of ``e``, columns by those of ``ec``."""

ErrorScale = Annotated[float, Unit("mm"), Gt(0), Doc("position error that makes e = 1, the 1/K_e of (5)")]
RateScale = Annotated[float, Unit("mm"), Gt(0), Doc("error change per interval that makes ec = 1, the 1/K_ec of (6)")]
RateInterval = Annotated[float, Unit("s"), Gt(0), Doc("interval to which the error change refers; Table 1 says 0.1 s")]
Tau = Annotated[float, Ge(0), Le(2), Doc("exponent of the contraction factors, (17) to (19)")]
Floor = Annotated[float, Gt(0), Le(1), Doc("smallest contraction factor, (17) to (19)")]
Centres = Annotated[np.ndarray, Doc("peaks of the sets, increasing")]
Exponent = Annotated[float, Ge(0), Le(2), Doc("exponent of this contraction factor")]
Least = Annotated[float, Gt(0), Le(1), Doc("smallest value of this contraction factor")]
Rules = Annotated[np.ndarray, Ge(-1), Le(1), Doc("duty of each rule, rows by e and columns by ec; Table 2 as printed")]


@cache
def ruled(settings: Any) -> Any:
    """The type of the parameters as a step reads them: one for each block, so that no loop is compiled twice."""
    return NamedTuple("Ruled", [("settings", settings), ("rules", RuleBase)])


class VudState(NamedTuple):
    """What the controller saw and did last, all of it worth recording."""

    e: Annotated[float, Doc("normalised error")] = 0.0
    ec: Annotated[float, Doc("normalised change of the error")] = 0.0
    alpha_e: Annotated[float, Doc("contraction of the universe of e")] = 1.0
    alpha_ec: Annotated[float, Doc("contraction of the universe of ec")] = 1.0
    beta: Annotated[float, Doc("contraction of the universe of the duty")] = 1.0
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


class VudView(NamedTuple):
    """What the controller sees in one period."""

    e: float
    ec: float
    alpha_e: float
    alpha_ec: float
    shape: float


def ready(params, dt: float) -> Any:
    """The parameters as a step reads them, the rules checked.

    Raises:
        ValueRefused: centres that do not increase.
    """
    plan_type = ruled(cast(Any, type(params)))
    return plan_type(params, rule_base(params.e_centres, params.ec_centres, params.rules))


def held(x, largest):
    """``x`` inside ``[-largest, largest]``."""
    return min(largest, max(-largest, x))


def contraction(x, tau, floor, started):
    """(17) to (19): ``|x|^tau + floor``, and 1 in the first period."""
    return abs(x) ** tau + floor if started > 0.0 else 1.0


def change(g, s, e, dt):
    """Change of the error per interval, mm."""
    return (e - s.e) * g.error_full_scale_mm * (g.rate_interval_s / dt)


def view(p, s, command, feedback, dt):
    """Steps 1 to 4 of the module's table."""
    g = p.settings
    e = (command - feedback) / g.error_full_scale_mm
    ec = s.started * change(g, s, e, dt) / g.rate_full_scale_mm
    alpha_e = contraction(e, g.tau, g.floor, s.started)
    alpha_ec = contraction(ec, g.tau, g.floor, s.started)
    shape = infer(p.rules, e / alpha_e, ec / alpha_ec)
    return VudView(e, ec, alpha_e, alpha_ec, shape)
