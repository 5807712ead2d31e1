"""Ball-screw stage with LuGre friction in steps of a fixed cost, for simulated machines in real time and for batches.

The equations of :obj:`leadscrew.plants.ballscrew_stage` by Alexander's SDIRK3 (order 3, L-stable, stiffly accurate;
SIAM J. Numer. Anal. 14 (1977) 1006) in steps of ``dt``, the loop's period / substeps. A stage has the unknowns V and Z.
With ``a = gamma dt``, the torque T, and ``v_c, c``, what the stages before say,

    V = v_c + a (T - F) / J        Z = c + a (V - |V| Z / g(V))        F = s0 Z + s1 (Z - c) / a + s2 V

1. the bristles are eliminated: ``Z = (c + a V) / (1 + a |V| / g(V))``
2. what is left is one equation in V, ``M V + S Z(V) = q`` with ``M = J + a s2``, ``S = a s0 + s1``,
   ``q = J v_c + a T + s1 c``. The sign of V is that of ``q - S c``: the kink of |V| needs no search
3. if g were known, V would be the positive root P(g) of a quadratic. The equation to solve is ``V = P(g(V))``; V lies
   between P(F_C / s0) and P(F_S / s0), so there is always a solution, and it is bracketed from the start
4. four Newton steps, each kept in the bracket; where Newton would leave it, or run into the unstable one of
   three solutions, P itself is taken. Always as many, with no branch: the cost does not depend on the motion.

Bounded at any step. In sliding, reversals included, steps of 50 us are good to 0.1 nm of the table. Where the stage
breaks loose at once, within microseconds, a step of 50 us is good to some nanometres, one of 10 us to 0.2: the page on
stiff friction has the numbers, and ``ballscrew_stage`` with ``rodas`` is the more accurate and the faster choice where
a fixed cost is not asked for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from leadscrew.kernel.block import plant
from leadscrew.plants._ballscrew_stage import BallscrewStageParams, BallscrewStageState, shown

GAMMA = 0.435866521508459
A21 = 0.5 * (1.0 - GAMMA)
B1 = -0.25 * (6.0 * GAMMA * GAMMA - 16.0 * GAMMA + 1.0)
B2 = 0.25 * (6.0 * GAMMA * GAMMA - 20.0 * GAMMA + 5.0)
FAR = 40.0
"""Largest exponent of the Stribeck term: e^-40 of it is nothing beside the rest."""
TINY = 1e-30


class StageStep(NamedTuple):
    """What a step needs, worked out once: constants of the stage equation, the levels of g, and what is shown."""

    travel_per_rad: float
    inertia: float
    damping: float
    dt: float
    a: float
    mass: float
    stiffness: float
    low: float
    rise: float
    per_speed: float


class Root(NamedTuple):
    """The root P of the quadratic, and the slope there."""

    speed: float
    slope: float


class Search(NamedTuple):
    """Where the search for V stands, and the bracket."""

    speed: float
    low: float
    high: float


class StageValue(NamedTuple):
    """Speed and bristles at the end of a stage."""

    speed: float
    bristle: float


def stage_step(params: BallscrewStageParams, dt: float) -> StageStep:
    """``M``, ``S``, ``F_C / s0``, ``(F_S - F_C) / s0`` and ``1 / v_s`` for steps of ``dt``."""
    f = params.friction
    a = GAMMA * dt
    return StageStep(
        params.travel_per_rad, params.inertia, f.damping, dt, a, params.inertia + a * f.viscous,
        a * f.stiffness + f.damping, f.coulomb / f.stiffness, (f.static - f.coulomb) / f.stiffness,
        1.0 / f.stribeck_speed,
    )  # fmt: skip


def level_root(p, c, q, g):
    """The root P of the stage equation where g is known, and the slope of the quadratic there."""
    b = (p.mass + p.stiffness * p.a) * g - q * p.a
    free = (q - p.stiffness * c) * g
    square = p.mass * p.a
    slope = math.sqrt(b * b + 4.0 * square * free)
    half = 0.5 * (abs(b) + slope)
    return Root(free / half if b > 0.0 else half / square, slope)


def narrowed(p, c, q, at):
    """One Newton step on ``V = P(g(V))``, inside a bracket that it narrows."""
    ratio = at.speed * p.per_speed
    over = p.rise * math.exp(-min(ratio * ratio, FAR))
    root = level_root(p, c, q, p.low + over)
    left = at.speed - root.speed
    low = at.speed if left < 0.0 else at.low
    high = at.high if left < 0.0 else at.speed
    bend = -2.0 * ratio * p.per_speed * over
    turn = root.slope + ((p.mass + p.stiffness * p.a) * root.speed + (p.stiffness * c - q)) * bend
    newton = at.speed - left * root.slope / turn
    good = (turn > 0.05 * root.slope) & (newton >= low) & (newton <= high)
    return Search(newton if good else min(high, max(low, root.speed)), low, high)


def solve_stage(p, torque, v, c, guess):
    """Speed and bristles of a stage from what the stages before it say, ``v`` and ``c``."""
    given = p.inertia * v + p.a * torque + p.damping * c
    side = 1.0 if given >= p.stiffness * c else -1.0
    q = side * given
    z = side * c
    fast = level_root(p, z, q, p.low).speed
    slow = level_root(p, z, q, p.low + p.rise).speed
    low = min(fast, slow)
    high = max(fast, slow)
    at = Search(min(high, max(low, side * guess)), low, high)
    at = narrowed(p, z, q, at)  # four calls, not a loop: so compilers work on several lanes at once, six times faster
    at = narrowed(p, z, q, at)
    at = narrowed(p, z, q, at)
    at = narrowed(p, z, q, at)
    ratio = at.speed * p.per_speed
    g = p.low + p.rise * math.exp(-min(ratio * ratio, FAR))
    return StageValue(side * at.speed, side * (z + p.a * at.speed) * g / (g + p.a * at.speed))


def flushed(x):
    """Zero in place of a value that has decayed to nothing: denormal numbers are slow."""
    return x if abs(x) > TINY else 0.0


@plant(BallscrewStageParams, BallscrewStageState, output=shown, prepare=stage_step, drive="torque")
def ballscrew_stage_fixed(p, s, u, load, dt):
    """Ball-screw stage with LuGre friction: state after ``dt`` under torques in N m, by SDIRK3 at a fixed cost."""
    torque = u + load
    per = 1.0 / p.a
    one = solve_stage(p, torque, s.speed, s.bristle, s.speed)
    v1 = (one.speed - s.speed) * per
    z1 = (one.bristle - s.bristle) * per
    reach = p.dt * A21
    v = s.speed + reach * v1
    z = s.bristle + reach * z1
    two = solve_stage(p, torque, v, z, one.speed)
    v2 = (two.speed - v) * per
    z2 = (two.bristle - z) * per
    v = s.speed + p.dt * (B1 * v1 + B2 * v2)
    z = s.bristle + p.dt * (B1 * z1 + B2 * z2)
    end = solve_stage(p, torque, v, z, two.speed)
    angle = s.angle + p.dt * (B1 * one.speed + B2 * two.speed + GAMMA * end.speed)
    return BallscrewStageState(angle, flushed(end.speed), flushed(end.bristle))
