"""PD with a disturbance observer and a friction model, its gains raised where the stage moves slowly.

In rad and N m, once a period, with the command a :class:`~leadscrew.references.Motion`:

    T  = J y_r'' + F_hat + d - (kp + m kp_slow) e - (kd + m kd_slow) e',      m = 1 / (1 + (y_r' / slow_speed)^2)
    d  = L (q - J v),      q_next = q + dt (T - F_hat - d),      q = J v + what an align left, in the first period

1. ``e = y - y_r``. Speed and rate of the error come from first differences behind a low-pass of ``low_pass_hz``
   (exact over a period): with ``rate_of_error`` the error is differentiated, ``e' = D e, v = y_r' + e'``; without it
   the angle, ``v = D y, e' = v - y_r'``, half a period and the low-pass late, which at an acceleration ``a`` is wrong
   by ``(dt / 2 + 1 / (2 pi f)) a`` and reaches the torque ``kd`` and ``L J`` times
2. ``F_hat``: friction by the believed model ``hat`` at the commanded speed, its mean over the coming period; nothing
   with ``friction = False``. See :mod:`leadscrew.friction.observer`
3. ``d`` follows the torque that the model does not know, behind a lag of ``1 / L``: from ``J v' = T - F`` it is
   ``d' = L (F - F_hat - d)``. ``L dt < 1``; ``L = 0`` is no observer
4. ``T`` is limited to ``max_torque`` (0: no limit); the observer is told the limited torque, so nothing winds up

Why more gain at low speed: while ``|v| << F_C / (sigma_0 dt)`` (0.25 rad/s at 4 kHz) the bristles hold the stage, and
their damping, 316 N m s/rad on the stage of Shams and Safdari (2010), allows a ``kd`` thirty times what the inertia
alone would. The observer is the momentum (residual) observer known from robots: A. De Luca, R. Mattone, *Sensorless
robot collision detection and hybrid force/motion control*, ICRA 2005. The schedule and all gains are ours.

While the stage slides, the raised gains are too much for 4 kHz: at a constant feed between 0.01 and 0.2 rad/s the
torque chatters by 2 N m peak to peak (``slow_speed`` moves the upper limit), errors stay below 0.1 um.

Inside ``e = y - y_r``; a positive torque moves the stage in the positive direction.

Bumpless start: bristles hold what static friction can, the observer the rest; exactly from rest, in motion but for what
the friction changes in a period. Without an observer as far as static friction holds.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._sliding.fields import Inertia, MaxTorque, Pieces, Travel
from leadscrew.controllers._sliding.stage import TINY
from leadscrew.friction.lugre import HAT, LuGre, level, steady_bristle
from leadscrew.friction.observer import held_friction
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._ballscrew_stage import INERTIA


class PdDobParams(NamedTuple):
    """Gains, schedule and observer, and what the controller believes of the stage."""

    kp: Annotated[float, Unit("N m/rad"), Ge(0), Doc("torque per error")] = 276.0
    kd: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("torque per rate of the error")] = 0.523
    kp_slow: Annotated[float, Unit("N m/rad"), Ge(0), Doc("what kp gains at rest")] = 397.0
    kd_slow: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("what kd gains at rest")] = 16.7
    slow_speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("commanded speed at which half of that gain is left")] = 0.1
    observer_rate: Annotated[float, Unit("1/s"), Ge(0), Doc("rate of the observer, L; 0 for none")] = 1845.0
    low_pass_hz: Annotated[float, Unit("Hz"), Ge(0), Doc("corner of the low-pass of the rate; 0 for none")] = 2000.0
    rate_of_error: Annotated[bool, Doc("differentiate the error, not the angle")] = True
    friction: Annotated[bool, Doc("whether there is F_hat")] = True
    inertia: Inertia = INERTIA
    travel_per_rad: Travel = 1.0
    max_torque: MaxTorque = 0.0
    pieces: Pieces = 20
    hat: LuGre = HAT


class PdDobPlan(NamedTuple):
    """The parameters as the step reads them."""

    kp: float
    kd: float
    kp_slow: float
    kd_slow: float
    slow_speed: float
    observer_rate: float
    inertia: float
    travel_per_rad: float
    max_torque: float
    pieces: int
    hat: LuGre
    friction: float
    """1 or 0."""
    of_error: float
    """1 or 0."""
    kept: float
    """What the low-pass keeps over a period."""


class PdDobState(NamedTuple):
    """What the controller remembers, and what it saw."""

    angle: Annotated[float, Unit("rad"), Doc("measured angle, y")] = 0.0
    target: Annotated[float, Unit("rad"), Doc("commanded angle, y_r")] = 0.0
    rate: Annotated[float, Unit("rad/s"), Doc("filtered rate: of the error, or of the angle")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("believed deflection of the bristles")] = 0.0
    friction: Annotated[float, Unit("N m"), Doc("F_hat")] = 0.0
    momentum: Annotated[float, Unit("N m s"), Doc("q; before the first period what it adds to J v")] = 0.0
    load: Annotated[float, Unit("N m"), Doc("torque that the model does not know, d")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def ready(params: PdDobParams, dt: float) -> PdDobPlan:
    """The parameters as the step reads them."""
    given = params._asdict()
    kept = math.exp(-2.0 * math.pi * params.low_pass_hz * dt) if params.low_pass_hz > 0.0 else 0.0
    switches = {"friction": float(params.friction), "of_error": float(params.rate_of_error), "kept": kept}
    return PdDobPlan(**({n: given[n] for n in PdDobPlan._fields if n in given} | switches))


def feedback_torque(p, e, rate, target_speed):
    """The PD's share of the torque."""
    ratio = target_speed / p.slow_speed
    m = 1.0 / (1.0 + ratio * ratio)
    return -(p.kp + m * p.kp_slow) * e - (p.kd + m * p.kd_slow) * rate


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    target = command.position / params.travel_per_rad
    target_speed = command.velocity / params.travel_per_rad
    angle = feedback / params.travel_per_rad
    feed_forward = params.inertia * command.acceleration / params.travel_per_rad
    missing = output - feed_forward - feedback_torque(params, angle - target, 0.0, target_speed)
    most = params.friction * level(params.hat, 0.0)
    bristle = min(max(missing, -most), most) / params.hat.stiffness
    start = steady_bristle(params.hat, target_speed) if target_speed != 0.0 else bristle
    held = params.friction * (params.hat.stiffness * start + params.hat.viscous * target_speed)
    left = (missing - held) / params.observer_rate if params.observer_rate > 0.0 else 0.0
    return PdDobState(angle, target, 0.0, bristle, 0.0, left, 0.0, 0.0)


@controller(PdDobParams, PdDobState, prepare=ready, align=align, unit="N m", drive="torque")
def pd_dob(p, s, command, feedback, dt):
    """PD scheduled by speed, disturbance observer and friction model, for a stage with LuGre friction; a torque."""
    angle = feedback / p.travel_per_rad
    target = command.position / p.travel_per_rad
    target_speed = command.velocity / p.travel_per_rad
    acceleration = command.acceleration / p.travel_per_rad
    e = angle - target
    moved = angle - s.angle - p.of_error * (target - s.target)
    fresh = s.started <= 0.0
    filtered = p.kept * s.rate + (1.0 - p.kept) * moved / dt
    known = (1.0 - p.of_error) * target_speed if fresh else filtered
    rate = known if abs(known) > TINY else 0.0
    speed = rate + p.of_error * target_speed
    bristle = steady_bristle(p.hat, target_speed) if fresh and target_speed != 0.0 else s.bristle
    held = held_friction(p.hat, bristle, target_speed, acceleration, 1.0, p.pieces, dt)
    friction = p.friction * held.torque
    momentum = s.momentum + (p.inertia * speed if fresh else 0.0)
    load = p.observer_rate * (momentum - p.inertia * speed)
    raw = p.inertia * acceleration + friction + load + feedback_torque(p, e, speed - target_speed, target_speed)
    torque = min(max(raw, -p.max_torque), p.max_torque) if p.max_torque > 0.0 else raw
    after = momentum + dt * (torque - friction - load)
    q = after if abs(after) > TINY else 0.0
    return PdDobState(angle, target, rate, held.bristle, friction, q, load, 1.0), torque
