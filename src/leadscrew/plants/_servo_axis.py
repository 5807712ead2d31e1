"""A servo axis as it is identified from a log: mass, drive, friction that differs by direction, offset, lost motion.

    M dv/dt = g u + load - offset - F(v)        dx/dt = v        F: :mod:`leadscrew.friction.static_map`

Behind the drive the table follows through a play of ``backlash`` (:mod:`leadscrew.plants._backlash`, halves to both
sides). Inside everything is SI, for a linear axis in m and N; for a rotary one read rad, N m, kg m^2. Where the force
of a unit of the drive is not known, the drive's unit stands for the newton and ``force_per_drive`` is 1.

One step of ``dt`` under a held drive, on each side of a stop the exact solution of the linear equation:

    v' = v e^-a + (dt / M) P c1     x' = x + dt v c1 + (dt^2 / M) P c2     a = sigma_2 dt / M
    c1 = (1 - e^-a) / a             c2 = (1 - c1) / a                      P = push - sgn(v) level

A speed that would change its sign stops inside the step, where the straight line between the two speeds has its zero;
there the axis is held while the push is no larger than the static friction of its direction, and otherwise goes on for
the rest of the step. Exact for Coulomb and viscous friction but for the bend of that line (``a`` squared); with a
Stribeck curve the level is taken at the speed half a step on, and the step is of second order.

The model is the usual one of drive identification: A. Janot, P.-O. Vandanjon, M. Gautier, *A generic instrumental
variable approach for industrial robot identification*, IEEE T. Control Systems Technology 22 (2014) 132, section II;
sticking as in :obj:`leadscrew.plants.mass_stribeck`. Default numbers: the ball-screw axis of the EMPS benchmark (A.
Janot, M. Gautier, M. Brunot, 2019), whose friction is without a Stribeck curve.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.lugre import level
from leadscrew.friction.static_map import Sliding, TwoSided, one_way, resting_friction
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._backlash import AxisPosition

EMPS = Sliding(coulomb=20.394, static=20.394, stribeck_speed=0.001, viscous=203.5)

Mass = Annotated[float, Unit("kg"), Gt(0), Doc("all that moves, as seen where the position is measured")]
ForcePerDrive = Annotated[float, Unit("N"), Doc("force of one unit of the drive; negative: it turns the other way")]
Offset = Annotated[float, Unit("N"), Doc("force that does not turn with the direction; positive pushes backwards")]
PerSi = Annotated[float, Gt(0), Doc("units of what is shown per m (rad): 1000 shows mm")]
StartPosition = Annotated[float, Unit("m"), Doc("where a run starts")]
StartSpeed = Annotated[float, Unit("m/s"), Doc("how fast it moves then")]


class ServoAxisParams(NamedTuple):
    """What a log tells of an axis."""

    mass: Mass = 95.109
    force_per_drive: ForcePerDrive = 35.15065
    offset: Offset = -3.165
    backlash: Annotated[float, Unit("m"), Ge(0), Doc("play between drive and table, both halves together")] = 0.0
    per_si: PerSi = 1000.0
    start_position: StartPosition = 0.0
    start_speed: StartSpeed = 0.0
    friction: TwoSided = TwoSided(EMPS, EMPS)


class ServoAxisState(NamedTuple):
    """The drive's side, and the table."""

    position: Annotated[float, Unit("m")] = 0.0
    speed: Annotated[float, Unit("m/s"), Doc("0: at rest")] = 0.0
    table: Annotated[float, Unit("m")] = 0.0


class Linear(NamedTuple):
    """Coefficients of the exact step in one direction."""

    kept: float
    first: float
    """c1"""
    second: float
    """c2"""


class ServoAxisStep(NamedTuple):
    """The parameters as the step reads them."""

    per_mass: float
    force_per_drive: float
    offset: float
    half_gap: float
    per_si: float
    friction: TwoSided
    forward: Linear
    backward: Linear


def linear(a: float) -> Linear:
    """``e^-a``, ``c1`` and ``c2``."""
    if a < 1e-3:
        first = 1.0 - a / 2.0 + a * a / 6.0 - a**3 / 24.0
        return Linear(math.exp(-a), first, 0.5 - a / 6.0 + a * a / 24.0 - a**3 / 120.0)
    first = -math.expm1(-a) / a
    return Linear(math.exp(-a), first, (1.0 - first) / a)


def servo_axis_step(params: ServoAxisParams, dt: float) -> ServoAxisStep:
    """The exact step of each direction."""
    sides = (linear(f.viscous * dt / params.mass) for f in params.friction)
    return ServoAxisStep(
        1.0 / params.mass, params.force_per_drive, params.offset, 0.5 * params.backlash, params.per_si,
        params.friction, *sides,
    )  # fmt: skip


def servo_axis_start(p):
    """In the middle of the play."""
    return ServoAxisState(p.start_position, p.start_speed, p.start_position)


def axis_shown(p, s):
    """The table and the drive's side."""
    return AxisPosition(p.per_si * s.table, p.per_si * s.position)


def speed_on(p, v, push, side, way, step, dt):
    """Speed after ``dt`` of sliding to ``side``, with the level of half a step on."""
    start = push - side * level(way, v)
    half = side * max(side * (v + 0.5 * dt * p.per_mass * (start - way.viscous * v)), 0.0)
    return v * step.kept + dt * p.per_mass * (push - side * level(way, half)) * step.first


@plant(
    ServoAxisParams(), ServoAxisState(), output=axis_shown, prepare=servo_axis_step, initial=servo_axis_start, unit="mm"
)
def servo_axis(p, s, u, load, dt):
    """A servo axis with friction by direction and play, as identified from a log: state after ``dt`` under a drive."""
    push = p.force_per_drive * u + load - p.offset
    v = s.speed
    held = abs(push - resting_friction(p.friction, push)) <= 0.0
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 1.0 if push > 0.0 else -1.0
    ahead = side > 0.0
    way = one_way(p.friction, side)
    kept = p.forward.kept if ahead else p.backward.kept
    first = p.forward.first if ahead else p.backward.first
    second = p.forward.second if ahead else p.backward.second
    free = speed_on(p, v, push, side, way, Linear(kept, first, second), dt)
    stands = (v == 0.0) & held
    slides = (side * free > 0.0) & (not stands)
    # (free - v e^-a) / c1 is dt / M times the mean push
    far = dt * v * first + dt * (free - v * kept) * second / first
    # It stops after ``stopped`` and is held there, or goes on the other way.
    stopped = dt * abs(v) / max(abs(v) + abs(free), 1e-300)
    rest = 0.0 if held else dt - stopped
    other = one_way(p.friction, -side)
    begun = 0.5 * rest * p.per_mass * max(-side * push - other.static, 0.0)
    turned = max(-side * push - level(other, begun), 0.0) * p.per_mass * rest if begun > 0.0 else 0.0
    after = -side * turned / (1.0 + 0.5 * other.viscous * rest * p.per_mass)
    near = 0.5 * v * stopped + 0.5 * after * rest
    speed = free if slides else 0.0 if stands else after
    position = s.position + (far if slides else 0.0 if stands else near)
    table = min(max(s.table, position - p.half_gap), position + p.half_gap)
    return ServoAxisState(position, speed, table)
