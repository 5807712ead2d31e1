"""Super-twisting sliding mode: a continuous torque whose integral finds what the friction model has wrong.

    s  = e' + lam e
    T  = F_hat + J (y_r'' - lam e') - k1 sqrt(|s|) sat(s / layer) + w
    w' = -k2 sat(s / layer)

Source: A. Levant, *Sliding order and sliding accuracy in sliding mode control*, Int. J. Control 58 (1993) 1247; on the
stage of Shams and Safdari (2010) with the equivalent control of :mod:`leadscrew.controllers._sliding.conventional`.
``sat`` in place of the sign, and the sampled form, are ours: ``w`` moves by ``k2 dt`` a period at most and waits where
the torque is limited and it would push further. With ``d`` the torque that the model does not know,
``|d'| < k2`` lets ``w`` follow it.

Defaults (ours, for 4 kHz): ``k1 = 1.39, k2 = 95, layer = 1e-3, lam = 600``, a filter that keeps 4 % of the last speed
(2 kHz) and f_hat without ``s1 dz/dt``, that is ``hat.damping = 0``: the most accurate of the sliding laws in the
slowest motion, and one that chatters by 0.1 N m in fast reversals. f_hat and what it sees:
:mod:`leadscrew.controllers._sliding.stage`.

Bumpless start: bristles hold what static friction can, ``w`` the rest; exactly from rest, in motion but for what the
friction changes in a period.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._sliding.conventional import surface
from leadscrew.controllers._sliding.fields import (
    Inertia,
    Lam,
    MaxTorque,
    Pieces,
    SpeedFilter,
    Travel,
    first_friction,
    stage_params,
)
from leadscrew.controllers._sliding.stage import FrictionFrom, SlidingParams, holding, sat, standing, view
from leadscrew.friction.lugre import HAT, LuGre
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._ballscrew_stage import INERTIA


class SuperTwistingParams(NamedTuple):
    """Gains of the law, and what the controller believes of the stage."""

    lam: Lam = 600.0
    k1: Annotated[float, Unit("N m (s/rad)^0.5"), Ge(0), Doc("gain of the root of s")] = 1.39
    k2: Annotated[float, Unit("N m/s"), Ge(0), Doc("fastest change of the integral")] = 95.0
    layer: Annotated[float, Unit("rad/s"), Gt(0), Doc("size of s below which the sign is a slope")] = 1e-3
    inertia: Inertia = INERTIA
    travel_per_rad: Travel = 1.0
    speed_filter_s: SpeedFilter = 1.13e-5
    max_torque: MaxTorque = 0.0
    friction_from: FrictionFrom = 1
    pieces: Pieces = 20
    hat: LuGre = HAT._replace(damping=0.0)


class SuperTwistingPlan(NamedTuple):
    """The parameters as the step reads them."""

    stage: SlidingParams
    k1: float
    k2: float
    layer: float


class SuperTwistingState(NamedTuple):
    """What the controller remembers, and what it saw."""

    angle: Annotated[float, Unit("rad"), Doc("measured angle, y")] = 0.0
    speed: Annotated[float, Unit("rad/s"), Doc("measured speed, y'")] = 0.0
    xi: Annotated[float, Unit("rad s"), Doc("always 0: the law needs no integral of the error")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("believed deflection of the bristles")] = 0.0
    friction: Annotated[float, Unit("N m"), Doc("F_hat")] = 0.0
    surface: Annotated[float, Unit("rad/s"), Doc("s")] = 0.0
    w: Annotated[float, Unit("N m"), Doc("the integral, w")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def ready(params: SuperTwistingParams, dt: float) -> SuperTwistingPlan:
    """The parameters as the step reads them."""
    return SuperTwistingPlan(stage_params(params), params.k1, params.k2, params.layer)


def proportional(p, now):
    """The torque without friction and ``w``."""
    s = surface(p.stage, now)
    pull = p.k1 * math.sqrt(abs(s)) * sat(s / p.layer)
    return p.stage.inertia * (now.acceleration - p.stage.lam * now.rate) - pull


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    now = standing(params.stage, command, feedback, 0.0)
    s = surface(params.stage, now)
    missing = output - proportional(params, now)
    held = holding(params.stage, now, s, missing)
    w = missing - first_friction(params.stage, command, held.bristle)
    return SuperTwistingState(held.angle, held.speed, 0.0, held.bristle, 0.0, s, w, 0.0)


@controller(SuperTwistingParams, SuperTwistingState, prepare=ready, align=align, unit="N m", drive="torque")
def super_twisting(p, s, command, feedback, dt):
    """Super-twisting sliding mode with a friction model, for a stage with LuGre friction; a torque."""
    now = view(p.stage, s, command, feedback, dt)
    sigma = surface(p.stage, now)
    moved = s.w - s.started * p.k2 * sat(sigma / p.layer) * dt
    raw = now.friction + proportional(p, now) + moved
    limit = p.stage.max_torque
    torque = min(max(raw, -limit), limit) if limit > 0.0 else raw
    w = s.w if (raw - torque) * (moved - s.w) > 0.0 else moved
    return SuperTwistingState(now.angle, now.speed, 0.0, now.bristle, now.friction, sigma, w, 1.0), torque
