"""The VUD controller with an observer: the 36 rules of Table 2 on where the axis would stop, in place of where it is.

With ``x_0``, ``K``, ``I`` and the slow mode ``m`` of :mod:`leadscrew.controllers._vud.fast_observer`:

1. ``stop = x_0 - K (I - sign(m) T_m b ln(1 + |m| / b))``: where the axis comes to rest if a duty of ``b`` against its
   motion takes the slow mode to zero; that takes ``T_m ln(1 + |m| / b)``
2. ``e  = held((command - stop) / error_full_scale)``,  ``ec = held(v / speed_full_scale)``, ``held`` inside [-1, 1],
   ``v = K s m``, ``s = T_m^2 / ((T_m - T_e)(T_m - T_p))``: the slow part of the speed at which the error grows
3. ``alpha_e = |e|^tau_e + floor_e``, ``alpha_ec = |ec|^tau_ec + floor_ec``                            (17), (18)
4. ``rho = held(output_gain shape(e / alpha_e, ec / alpha_ec))``                            (21), beta a constant

``shape`` and its 36 rules are the paper's, untouched; the sign of ``ec`` is that of a change of the error, as in (6).
What differs from :mod:`leadscrew.controllers._vud.printed`: what ``e`` and ``ec`` are made of, their scales, exponents
and floors of their own, and a constant in place of (19).

``stop = command`` is the switching line of the time-optimal stop of an integrator behind one lag: full duty on one
side, braking on the other. ``b`` below 1 leaves the rules room to keep the axis on the line. The lags of 1.5 and
0.8 ms are not in the line; ``x_0 - K I`` counts them exactly. The gain at the target is one that the sensor's lag would
not allow without the observer.

``speed_limit_mm_s`` and ``brake_limit`` keep the duty where a motor with a largest speed and current follows it as the
linear chain does: ``|rho| <= speed_limit / K``, and ``|rho| <= brake_limit`` against the motion.

Ours; settings and how they were found: ``leadscrew.studies.vud_lathe.controllers``; limits: ``docs/vud_fast.md``.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._vud.fast_observer import Chain, ChainParams, ChainState, corrected, moved, ready_chain
from leadscrew.controllers._vud.universe import CENTRES, TABLE_2, Centres, Exponent, Rules, held
from leadscrew.fuzzy.inference import RuleBase, infer, rule_base
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Gt, Le, Unit

Least = Annotated[float, Gt(0), Le(2), Doc("smallest value of this contraction factor")]


class VudFastParams(NamedTuple):
    """Scales, contraction factors, braking, limits, the believed chain, and the rules."""

    error_full_scale_mm: Annotated[float, Unit("mm"), Gt(0), Doc("error of the predicted stop that makes e = 1")] = 1.0
    speed_full_scale_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Doc("slow part of the speed that makes ec = 1")] = 25.0
    e_tau: Exponent = 0.8
    e_floor: Least = 0.07
    ec_tau: Exponent = 0.7
    ec_floor: Least = 0.7
    output_gain: Annotated[float, Gt(0), Le(1000), Doc("duty that the rules' 1 stands for, before the limit")] = 2.2
    braking: Annotated[float, Gt(0), Le(1), Doc("b: duty against the motion that the prediction counts on")] = 0.83
    speed_limit_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed that the duty never asks for more than")] = 1e6
    brake_limit: Annotated[float, Gt(0), Le(1), Doc("largest duty against the motion")] = 1.0
    chain: ChainParams = ChainParams()
    e_centres: Centres = CENTRES
    ec_centres: Centres = CENTRES
    rules: Rules = TABLE_2


class VudFastState(NamedTuple):
    """What the controller saw and did last, all of it worth recording, and its observer."""

    e: Annotated[float, Doc("normalised error of the predicted stop")] = 0.0
    ec: Annotated[float, Doc("normalised slow part of the speed, its sign that of the error's change")] = 0.0
    alpha_e: Annotated[float, Doc("contraction of the universe of e")] = 1.0
    alpha_ec: Annotated[float, Doc("contraction of the universe of ec")] = 1.0
    beta: Annotated[float, Doc("gain of the output, a constant")] = 1.0
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0
    chain: ChainState = ChainState()


class VudFast(NamedTuple):
    """The parameters as the step reads them."""

    error_scale: float
    speed_scale: float
    e_tau: float
    e_floor: float
    ec_tau: float
    ec_floor: float
    output_gain: float
    braking: float
    speed_limit: float
    brake_limit: float
    lag: float
    chain: Chain
    rules: RuleBase


def ready(params: VudFastParams, dt: float) -> VudFast:
    """The parameters as the step reads them, the rules checked.

    Raises:
        ValueRefused: centres that do not increase, or two lags of the chain that are the same.
    """
    return VudFast(
        *params[:10],
        params.chain.mechanical_lag_s,
        ready_chain(params.chain, dt),
        rule_base(params.e_centres, params.ec_centres, params.rules),
    )


class Ahead(NamedTuple):
    """Where the axis would stop, and the slow part of the speed at which the error grows."""

    stop: float
    speed: float


def predicted(p, now):
    """What the observer foresees; ``p`` has its chain, the mechanical lag and the duty of braking."""
    speed = now.gain * p.chain.speed
    back = p.lag * p.braking * math.log(1.0 + abs(now.slow) / p.braking)
    stop = now.offset - speed * (now.travel - math.copysign(back, now.slow))
    return Ahead(stop, speed * p.chain.slow_share * now.slow)


@controller(VudFastParams, VudFastState, prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1)
def vud_fast(p, s, command, feedback, dt):
    """The duty by the 36 rules, on the error of the predicted stop and the slow part of the speed."""
    now = corrected(p.chain, s.chain, feedback, s.started)
    ahead = predicted(p, now)
    e = held((command - ahead.stop) / p.error_scale, 1.0)
    ec = held(ahead.speed / p.speed_scale, 1.0)
    alpha_e = abs(e) ** p.e_tau + p.e_floor
    alpha_ec = abs(ec) ** p.ec_tau + p.ec_floor
    asked = p.output_gain * infer(p.rules, e / alpha_e, ec / alpha_ec)
    limit = p.brake_limit if asked * now.slow < 0.0 else 1.0
    rho = held(asked, min(limit, p.speed_limit / (now.gain * p.chain.speed)))
    after = moved(p.chain, now, rho, dt)
    return VudFastState(e, ec, alpha_e, alpha_ec, p.output_gain, rho, 1.0, after), rho
