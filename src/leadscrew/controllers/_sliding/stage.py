"""What every sliding-mode controller of the stage shares: what it sees, what it believes, and how it ends.

The stage is ``J y'' = T - F`` in rad and N m, so ``y'' = f + u`` with ``f = -F / J``, ``u = T / J`` (rad/s^2). In the
order in which it happens, once a period, with the command a :class:`~leadscrew.references.Motion`:

1. ``y = feedback / travel_per_rad``, and the same for ``y_r, y_r', y_r''`` of the command
2. ``y' = (speed_filter_s y'_last + y - y_last) / (speed_filter_s + dt)``: first difference, behind a backward-Euler
   lag; in the first period ``y_r'``
3. ``e = y - y_r,  e' = y' - y_r',  xi = xi + e dt``; from the second period on; xi waits at the torque's limit
4. ``F_hat``: friction by the believed model ``hat``, one of the readings of the paper's f_hat:
   ``friction_from`` ``commanded``: own bristles, driven by the commanded speed (a feed-forward; the default, and our
   reading); ``measured_undamped``: own bristles, driven by the measured speed, without ``s1 dz/dt``; ``measured``: the
   same with it, the letter of the paper, whose believed damping exceeds the real one: with ``pieces`` 0 the torque
   leaps to kilonewton metres; ``none``
5. ``F~ = F_C + (F_S - F_C) exp(-(y' / v_s)^2) + s2 |y'|`` with the parameters ``bound``, ``K = F~ / J + eta``, and the
   slope inside the boundary layer ``K / boundary``, or ``layer_rate`` where that is positive
6. the law of the controller: ``u = y_r'' + terms in e', e, xi - K sat(slope s / K)``
7. ``T = F_hat + J u``, limited to ``max_torque`` (0: no limit)

Source: Shams and Safdari (2010), equations (6) to (16), Table 2. The sampled form, 1 to 4 and 7, is ours: the paper
has none. The paper's gains (``layer_rate`` 0) make slopes of 1.7e5 1/s and more: such a law is stable only if sampled
every 12 us or faster, the complementary one every 6 us. ``layer_rate = 4000`` (ours) is for 4 kHz and above; in general
keep ``layer_rate dt <= 1``, for the complementary law half of it.

Inside ``e = y - y_r`` as in the paper; a positive torque moves the stage in the positive direction.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from leadscrew.friction.lugre import HAT, LuGre, Stribeck, level, steady_bristle, steady_friction
from leadscrew.friction.observer import held_friction
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._ballscrew_stage import INERTIA

TINY = 1e-30
"""Below this a filtered speed is 0: its tail would end in denormal numbers, which are slow."""


FrictionFrom = Annotated[
    Literal["none", "commanded", "measured_undamped", "measured"] | int,
    Doc("speed that drives f_hat; the undamped one leaves out s1 dz/dt"),
]


class SlidingParams(NamedTuple):
    """Gains of the law, and what the controller believes of the stage."""

    lam: Annotated[float, Unit("1/s"), Gt(0), Doc("rate of the error on the surface, lambda")] = 150.0
    boundary: Annotated[float, Unit("rad/s"), Gt(0), Doc("thickness of the boundary layer, phi, (11), (15)")] = 0.1
    layer_rate: Annotated[
        float, Unit("1/s"), Ge(0), Doc("slope K / phi inside the layer, in place of boundary; 0 to use boundary")
    ] = 0.0
    eta: Annotated[float, Unit("rad/s^2"), Ge(0), Doc("reserve of the switching gain, (12); 120 or 20")] = 120.0
    inertia: Annotated[float, Unit("kg m^2"), Gt(0), Doc("believed inertia at the screw, J")] = INERTIA
    travel_per_rad: Annotated[
        float, Unit("1/rad"), Gt(0), Doc("command and feedback per radian: 1 for rad, 1.5923 for mm of the table")
    ] = 1.0
    speed_filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the measured speed; 0 for none")] = 0.0
    max_torque: Annotated[float, Unit("N m"), Ge(0), Doc("largest size of the torque; 0 for no limit")] = 0.0
    friction_from: FrictionFrom = 1
    pieces: Annotated[
        int, Ge(0), Le(1000), Doc("pieces of a period in the mean of f_hat; 0 for f_hat at the sample")
    ] = 20
    hat: LuGre = HAT
    bound: Stribeck = Stribeck()


class SlidingState(NamedTuple):
    """What a sliding-mode controller remembers, and what it saw."""

    angle: Annotated[float, Unit("rad"), Doc("measured angle, y")] = 0.0
    speed: Annotated[float, Unit("rad/s"), Doc("measured speed, y'")] = 0.0
    xi: Annotated[float, Unit("rad s"), Doc("integral of the error")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("believed deflection of the bristles")] = 0.0
    surface: Annotated[float, Unit("rad/s"), Doc("what the switching term acts on")] = 0.0
    friction: Annotated[float, Unit("N m"), Doc("F_hat")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


class View(NamedTuple):
    """What the law needs: steps 1 to 5 of the module's table."""

    angle: float
    speed: float
    e: float
    rate: float
    xi: float
    acceleration: float
    friction: float
    bristle: float
    gain: float
    slope: float


def switching_gain(p, speed):
    """``K``, step 5."""
    return steady_friction(p.bound, speed) / p.inertia + p.eta


def layer_slope(p, gain):
    """``K / phi``, step 5."""
    return p.layer_rate if p.layer_rate > 0.0 else gain / p.boundary


def view(p, s, command, feedback, dt):
    """Steps 1 to 5 of the module's table."""
    angle = feedback / p.travel_per_rad
    target_speed = command.velocity / p.travel_per_rad
    acceleration = command.acceleration / p.travel_per_rad
    e = angle - command.position / p.travel_per_rad
    difference = (p.speed_filter_s * s.speed + (angle - s.angle)) / (p.speed_filter_s + dt)
    flushed = difference if abs(difference) > TINY else 0.0
    speed = flushed if s.started > 0.0 else target_speed
    xi = s.xi + s.started * e * dt
    commanded = p.friction_from == 1
    v = target_speed if commanded else speed
    fresh = s.started <= 0.0 and target_speed != 0.0
    bristle = steady_bristle(p.hat, target_speed) if fresh else s.bristle
    held = held_friction(
        p.hat, bristle, v, acceleration if commanded else 0.0, 0.0 if p.friction_from == 2 else 1.0, p.pieces, dt
    )
    gain = switching_gain(p, speed)
    return View(
        angle,
        speed,
        e,
        speed - target_speed,
        xi,
        acceleration,
        held.torque if p.friction_from > 0 else 0.0,
        held.bristle,
        gain,
        layer_slope(p, gain),
    )


def sat(x):
    """``x`` inside [-1, 1]."""
    return min(1.0, max(-1.0, x))


def ended(p, s, now, surface, wanted):
    """Step 7: the next state and the torque for ``u = wanted``."""
    raw = now.friction + p.inertia * wanted
    torque = min(max(raw, -p.max_torque), p.max_torque) if p.max_torque > 0.0 else raw
    outwards = (raw - torque) * now.e < 0.0
    xi = s.xi if outwards else now.xi
    return SlidingState(now.angle, now.speed, xi, now.bristle, surface, now.friction, 1.0), torque


def standing(p, command, feedback, xi_per_e):
    """A view as in the first period, without friction and with ``xi = xi_per_e e``: what an align starts from."""
    angle = feedback / p.travel_per_rad
    speed = command.velocity / p.travel_per_rad
    e = angle - command.position / p.travel_per_rad
    gain = switching_gain(p, speed)
    return View(
        angle,
        speed,
        e,
        0.0,
        xi_per_e * e,
        command.acceleration / p.travel_per_rad,
        0.0,
        0.0,
        gain,
        layer_slope(p, gain),
    )


def holding(p, now, surface, missing):
    """The state in which the bristles hold the torque ``missing``, as far as static friction can."""
    most = level(p.hat, 0.0) / p.hat.stiffness
    bristle = min(max(missing / p.hat.stiffness, -most), most)
    return SlidingState(now.angle, now.speed, now.xi, bristle, surface, 0.0, 0.0)
