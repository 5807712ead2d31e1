"""PD with a disturbance observer and a friction model that it learns, its gains where the bristles can bear them.

In rad and N m, once a period, with the command a :class:`~leadscrew.references.Motion`:

    T  = J y_r'' + F_hat + d - (kp + m kp_slow) e - (kd + m kd_slow) e' + u_stuck
    m  = 1 / (1 + ((y_r'^2 + (slow_time y_r'')^2) / slow_speed^2)^2)
    d  = L (q - J v),      q_next = q + dt (T - F_hat - d)                   as in leadscrew.controllers._pd_dob

1. ``e = y - y_r``, its rate from the first difference behind a low-pass; ``v = y_r' + e'``
2. ``F_hat``: friction over the coming period on the commanded motion, by numbers that are learned from period to period
   and start at the believed model ``hat``: :mod:`leadscrew.controllers._learned_friction`. Stribeck's fall is left to
   the observer
3. ``u_stuck = -min(kd_share D, kd_stuck) e'``, ``D = sigma_1 (1 - side w)`` with the learned ``sigma_1`` and the share
   ``w`` by which the measured travel has bent the bristles: after a reversal they damp the stage, and bear a gain that
   would make a sliding stage chatter. It pushes back by the damping torque in ``F_hat`` at most: more would let the
   stage slip the other way, in which they do not damp
4. ``m`` raises the gains in slow motion that stays slow for ``slow_time``, not where a fast one turns round
5. ``T`` is limited to ``max_torque`` (0: no limit); observer and learning are told the limited torque

Nothing is learned in slow motion (``m > 0.5``: Stribeck's fall would be taken for Coulomb friction), at an error above
``learn_within``, or while the command stands.

Start-up: what Table 2 believes (bristles twice as stiff) errs at the first reversals; see
``docs/friction_compensation.md`` for how much and how long. The law and all gains are ours.

Inside ``e = y - y_r``; a positive torque moves the stage in the positive direction.

Bumpless start: bristles hold what Coulomb friction can, the observer the rest.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.controllers._learned_friction import (
    COUNT,
    LearnedPlan,
    at_start,
    believed,
    foreseen,
    learn,
    seen,
    spread_at_start,
)
from leadscrew.controllers._sliding.fields import Inertia, MaxTorque, Travel
from leadscrew.controllers._sliding.stage import TINY
from leadscrew.friction.lugre import HAT, LuGre
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._ballscrew_stage import INERTIA


class PdLearnedParams(NamedTuple):
    """Gains, schedule, observer, how it learns, and what it believes of the stage before."""

    kp: Annotated[float, Unit("N m/rad"), Ge(0), Doc("torque per error")] = 290.2
    kd: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("torque per rate of the error")] = 0.8412
    kp_slow: Annotated[float, Unit("N m/rad"), Ge(0), Doc("what kp gains in slow motion")] = 4367.0
    kd_slow: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("what kd gains in slow motion")] = 11.24
    slow_speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("commanded speed at which half of it is left")] = 0.01667
    slow_time: Annotated[float, Unit("s"), Ge(0), Doc("time for which a motion must stay slow")] = 0.008
    kd_stuck: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("most that kd gains while bristles damp")] = 5.0
    kd_share: Annotated[float, Ge(0), Doc("the same as a share of that damping")] = 0.6807
    observer_rate: Annotated[float, Unit("1/s"), Ge(0), Doc("rate of the observer, L; 0 for none")] = 2386.0
    low_pass_hz: Annotated[float, Unit("Hz"), Ge(0), Doc("corner of the low-pass of the rate; 0 for none")] = 1451.0
    learns: Annotated[bool, Doc("whether it learns")] = True
    torque_noise: Annotated[float, Unit("N m"), Gt(0), Doc("noise of a friction torque, in sliding")] = 0.6533
    speed_noise: Annotated[float, Unit("rad/s"), Ge(0), Doc("noise of a speed, on bristles that damp")] = 0.004724
    forget: Annotated[float, Ge(0), Le(1), Doc("what a period of turning bristles forgets, as a share")] = 0.00035
    learn_within: Annotated[float, Unit("rad"), Ge(0), Doc("largest error at which it learns")] = 0.0001
    inertia: Inertia = INERTIA
    travel_per_rad: Travel = 1.0
    max_torque: MaxTorque = 0.0
    pieces: Annotated[int, Ge(1), Le(100), Doc("pieces of a period in the mean of F_hat")] = 6
    hat: LuGre = HAT


class PdLearnedPlan(NamedTuple):
    """The parameters as the step reads them."""

    kp: float
    kd: float
    kp_slow: float
    kd_slow: float
    slow_speed: float
    slow_time: float
    kd_stuck: float
    kd_share: float
    observer_rate: float
    learns: float
    learn_within: float
    inertia: float
    travel_per_rad: float
    max_torque: float
    pieces: int
    kept: float
    """What the low-pass keeps over a period."""
    learning: LearnedPlan
    numbers: np.ndarray
    """The learned numbers before anything is learned."""
    spread: np.ndarray
    """How uncertain they are then."""
    still: np.ndarray
    still_before: np.ndarray
    still_gain: np.ndarray
    """Zeros, for :func:`align`: a step's arrays must come from somewhere."""


class PdLearnedState(NamedTuple):
    """What the controller remembers, has learned, and saw."""

    known: Annotated[np.ndarray, Doc("F_C, g, sigma_1, sigma_2, load")]
    spread: Annotated[np.ndarray, Doc("how uncertain they are, P")]
    slope: Annotated[np.ndarray, Doc("dF / d(number) of the period that runs")]
    slope_before: Annotated[np.ndarray, Doc("and of the one before")]
    gain: Annotated[np.ndarray, Doc("P s of the last correction")]
    angle: Annotated[float, Unit("rad"), Doc("measured angle, y")] = 0.0
    target: Annotated[float, Unit("rad"), Doc("commanded angle, y_r")] = 0.0
    error_step: Annotated[float, Unit("rad"), Doc("what the error gained in the last period")] = 0.0
    rate: Annotated[float, Unit("rad/s"), Doc("filtered rate of the error")] = 0.0
    acceleration: Annotated[float, Unit("rad/s^2"), Doc("commanded")] = 0.0
    share: Annotated[float, Doc("bristle deflection on the commanded motion")] = 0.0
    bent: Annotated[float, Unit("1/rad"), Doc("its slope by g")] = 0.0
    seen: Annotated[float, Doc("bend on the measured motion")] = 0.0
    damping: Annotated[float, Unit("N m s/rad"), Doc("damping of the bristles, sigma_1 (1 - side w)")] = 0.0
    damping_before: Annotated[float, Unit("N m s/rad"), Doc("a period ago")] = 0.0
    modelled: Annotated[float, Unit("N m"), Doc("friction by the model on the measured motion")] = 0.0
    torque: Annotated[float, Unit("N m"), Doc("T")] = 0.0
    torque_before: Annotated[float, Unit("N m"), Doc("a period ago")] = 0.0
    friction: Annotated[float, Unit("N m"), Doc("F_hat")] = 0.0
    momentum: Annotated[float, Unit("N m s"), Doc("q; before the first period what it adds to J v")] = 0.0
    load: Annotated[float, Unit("N m"), Doc("torque that the model does not know, d")] = 0.0
    difference: Annotated[float, Unit("N m"), Doc("friction that was there less the model's, as counted")] = 0.0
    coulomb: Annotated[float, Unit("N m"), Doc("learned F_C")] = 0.0
    bend: Annotated[float, Unit("rad"), Doc("learned g; sigma_0 = F_C / g")] = 0.0
    bristle_damping: Annotated[float, Unit("N m s/rad"), Doc("learned sigma_1")] = 0.0
    viscous: Annotated[float, Unit("N m s/rad"), Doc("learned sigma_2")] = 0.0
    periods: Annotated[float, Doc("periods since the start, up to 3")] = 0.0


def initial(params: PdLearnedParams) -> PdLearnedState:
    """Nothing learned."""
    return PdLearnedState(
        at_start(params.hat), spread_at_start(params.hat), np.zeros(COUNT), np.zeros(COUNT), np.zeros(COUNT)
    )


def ready(params: PdLearnedParams, dt: float) -> PdLearnedPlan:
    """The parameters as the step reads them."""
    given = params._asdict()
    kept = math.exp(-2.0 * math.pi * params.low_pass_hz * dt) if params.low_pass_hz > 0.0 else 0.0
    learning = LearnedPlan(params.torque_noise, params.speed_noise, params.forget, believed(params.hat))
    more: dict[str, Any] = {"learns": float(params.learns), "kept": kept, "learning": learning}
    more |= {"numbers": at_start(params.hat), "spread": spread_at_start(params.hat)}
    more |= {name: np.zeros(COUNT) for name in ("still", "still_before", "still_gain")}
    return PdLearnedPlan(**({n: given[n] for n in PdLearnedPlan._fields if n in given} | more))


def slowness(p, target_speed, acceleration):
    """``m``."""
    soon = p.slow_time * acceleration
    ratio = (target_speed * target_speed + soon * soon) / (p.slow_speed * p.slow_speed)
    return 1.0 / (1.0 + ratio * ratio)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; nothing learned."""
    known = params.numbers
    target = command.position / params.travel_per_rad
    speed = command.velocity / params.travel_per_rad
    acceleration = command.acceleration / params.travel_per_rad
    angle = feedback / params.travel_per_rad
    stiff = params.kp + slowness(params, speed, acceleration) * params.kp_slow
    missing = output - params.inertia * acceleration + stiff * (angle - target)
    share = 1.0 if speed > 0.0 else -1.0 if speed < 0.0 else min(max(missing / known[0], -1.0), 1.0)
    held = known[0] * share + known[3] * speed
    left = (missing - held) / params.observer_rate if params.observer_rate > 0.0 else 0.0
    return PdLearnedState(
        params.numbers, params.spread, params.still, params.still_before, params.still_gain, angle, target,
        0.0, 0.0, acceleration, share, 0.0, share, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, left, 0.0, 0.0, known[0], known[1], known[2], known[3], 0.0,
    )  # fmt: skip


@controller(PdLearnedParams, initial(PdLearnedParams()), initial=initial, prepare=ready, align=align, unit="N m",
            drive="torque")  # fmt: skip
def pd_learned(p, s, command, feedback, dt):
    """PD where the bristles bear it, disturbance observer, and a friction model that is learned; a torque."""
    angle = feedback / p.travel_per_rad
    target = command.position / p.travel_per_rad
    speed = command.velocity / p.travel_per_rad
    acceleration = command.acceleration / p.travel_per_rad
    fresh = s.periods <= 0.0
    e = angle - target
    step = 0.0 if fresh else e - (s.angle - s.target)
    filtered = p.kept * s.rate + (1.0 - p.kept) * step / dt
    rate = filtered if abs(filtered) > TINY else 0.0
    slow = slowness(p, speed, acceleration)
    side = 1.0 if speed > 0.0 else -1.0 if speed < 0.0 else 0.0

    moved = 0.0 if fresh else angle - s.angle
    sliding = fresh & (side != 0.0)
    was = seen(s.known, side if sliding else s.seen, moved, dt)
    difference = 0.0
    if (p.learns > 0.0) & (s.periods > 2.5) & (abs(e) < p.learn_within) & (slow < 0.5):
        inertial = p.inertia * (s.acceleration + (step - s.error_step) / (dt * dt))
        there = 0.5 * (s.torque + s.torque_before) - inertial
        damped = 0.5 * (s.damping + s.damping_before)
        turning = max(1.0 - abs(s.share), 0.0)
        difference = learn(p.learning, s.known, s.spread, s.gain, s.slope, s.slope_before,
                           there - 0.5 * (was.torque + s.modelled), damped, turning)  # fmt: skip
    for i in range(5):
        s.slope_before[i] = s.slope[i]
    start = side if sliding else s.share
    coming = foreseen(s.known, s.slope, start, s.bent, speed, acceleration, p.pieces, dt)
    damping = max(s.known[2] * (1.0 - side * coming.share), 0.0)

    gained = min(p.kd_share * s.known[2] * max(1.0 - side * was.share, 0.0), p.kd_stuck)
    push = -gained * rate
    most = max(side * coming.damping, 0.0)
    held_back = max(push, -most) if side > 0.0 else min(push, most)
    feedback_torque = held_back - (p.kp + slow * p.kp_slow) * e - (p.kd + slow * p.kd_slow) * rate

    v = speed + rate
    momentum = s.momentum + (p.inertia * v if fresh else 0.0)
    load = p.observer_rate * (momentum - p.inertia * v)
    raw = p.inertia * acceleration + coming.torque + load + feedback_torque
    torque = min(max(raw, -p.max_torque), p.max_torque) if p.max_torque > 0.0 else raw
    after = momentum + dt * (torque - coming.torque - load)
    q = after if abs(after) > TINY else 0.0
    return PdLearnedState(
        s.known, s.spread, s.slope, s.slope_before, s.gain, angle, target, step, rate, acceleration,
        coming.share, coming.bent, was.share, damping, s.damping, was.torque,
        torque, s.torque, coming.torque, q, load, difference,
        s.known[0], s.known[1], s.known[2], s.known[3], min(s.periods + 1.0, 3.0),
    ), torque  # fmt: skip
