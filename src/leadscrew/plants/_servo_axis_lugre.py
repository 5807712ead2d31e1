"""A servo axis as it is identified from a log that shows pre-sliding: LuGre friction with values for each direction.

    M dv/dt = f u + load - offset - F        dx/dt = v        F = s0 z + s1 dz/dt + s2 v        dz/dt = v - |v| z / g(v)

The axis of :obj:`leadscrew.plants.servo_axis` with bristles (:mod:`leadscrew.friction.asymmetric`) in place of exact
sticking, and without play; state and Jacobian are those of :obj:`leadscrew.plants.mass_lugre`. Stiff: while it slides
the bristles settle at the rate ``s0 |v| / g``, 2.5e4 1/s at 0.1 m/s with the values below, which RK4 at 1 ms cannot
follow. Integrated by ``rodas`` unless a loop names a method; ``sdirk3`` has a fixed cost. A start in motion has the
bristles bent as in steady sliding. Units as in ``servo_axis``.
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.friction.asymmetric import TwoSidedLuGre, one_way_lugre
from leadscrew.friction.lugre import bristle_rate, friction, steady_bristle
from leadscrew.kernel.block import plant
from leadscrew.plants._backlash import AxisPosition
from leadscrew.plants._mass_lugre import MassLuGreState, mass_lugre_jacobian
from leadscrew.plants._servo_axis import EMPS, ForcePerDrive, Mass, Offset, PerSi, StartPosition, StartSpeed


class ServoAxisLuGreParams(NamedTuple):
    """What a log tells of an axis; stiffness and damping of the bristles are chosen, the rest is ``servo_axis``."""

    mass: Mass = 95.109
    force_per_drive: ForcePerDrive = 35.15065
    offset: Offset = -3.165
    per_si: PerSi = 1000.0
    start_position: StartPosition = 0.0
    start_speed: StartSpeed = 0.0
    friction: TwoSidedLuGre = TwoSidedLuGre(stiffness=5e6, damping=5e3, forward=EMPS, backward=EMPS)


def lugre_axis_start(p):
    """At rest with straight bristles, or in steady sliding."""
    f = one_way_lugre(p.friction, p.start_speed)
    bent = steady_bristle(f, p.start_speed) if p.start_speed != 0.0 else 0.0
    return MassLuGreState(p.start_position, p.start_speed, bent)


def lugre_axis_shown(p, s):
    """Table and drive are one."""
    return AxisPosition(p.per_si * s.position, p.per_si * s.position)


@plant(
    ServoAxisLuGreParams(),
    MassLuGreState(),
    output=lugre_axis_shown,
    initial=lugre_axis_start,
    jacobian=mass_lugre_jacobian,
    stiff=True,
    unit="mm",
)
def servo_axis_lugre(p, s, u, load):
    """A servo axis with LuGre friction by direction, as identified from a log: derivatives under a drive."""
    f = one_way_lugre(p.friction, s.speed)
    rate = bristle_rate(f, s.speed, s.bristle)
    force = p.force_per_drive * u + load - p.offset - friction(f, s.speed, s.bristle, rate)
    return MassLuGreState(s.speed, force / p.mass, rate)
