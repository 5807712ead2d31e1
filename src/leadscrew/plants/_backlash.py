"""Classic backlash: a dead band whose impacts are fully plastic; and an axis whose table follows its drive through it.

Position play: the table is pushed by one of two flanks, and stands still while neither touches it.

    forward:   y = m+ (x - b+)        backward:  y = m- (x + b-)
    y_next = min(max(y, m+ (x - b+)), m- (x + b-))

``x`` is the drive, ``y`` the table; gaps and slopes differ by side where the joint does. The total play is ``b+ + b-``.
With unlike slopes the two lines cross, at ``x = (m+ b+ + m- b-) / (m+ - m-)``; the model makes sense before it, that is
while ``m+ (x - b+) < m- (x + b-)``.

Reaction against twist, the same dead band as a force (the joint is a spring outside its gap):

    F = k+ max(x - b+, 0) + k- min(x + b-, 0)

Source: Figure 1 of Shams and Safdari (2010), after J. Marchi (1998), whose drawing is lost; the play is the standard
one: G. Tao, P. Kokotovic, *Adaptive Control of Systems with Actuator and Sensor Nonlinearities* (1996), chapter 2.
With impacts that bounce: :obj:`leadscrew.plants.backlash_two_mass`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit


class Play(NamedTuple):
    """Gaps of the two flanks, and travel of the table per travel of the drive on each."""

    forward_gap: Annotated[
        float, Unit("m"), Ge(0), Doc("travel from the middle until the drive pushes forwards, b+")
    ] = 1e-6
    backward_gap: Annotated[
        float, Unit("m"), Ge(0), Doc("travel from the middle until the drive pushes backwards, b-")
    ] = 1e-6
    forward_slope: Annotated[float, Gt(0), Doc("table per drive while pushed forwards, m+")] = 1.0
    backward_slope: Annotated[float, Gt(0), Doc("table per drive while pushed backwards, m-")] = 1.0


class DeadBand(NamedTuple):
    """Gaps of the two flanks, and the stiffness of the joint behind each."""

    forward_gap: Annotated[
        float, Unit("m"), Ge(0), Doc("travel from the middle until the drive pushes forwards, b+")
    ] = 1e-6
    backward_gap: Annotated[
        float, Unit("m"), Ge(0), Doc("travel from the middle until the drive pushes backwards, b-")
    ] = 1e-6
    forward_stiffness: Annotated[float, Unit("N/m"), Gt(0), Doc("stiffness of the forward flank, k+")] = 1e8
    backward_stiffness: Annotated[float, Unit("N/m"), Gt(0), Doc("stiffness of the backward flank, k-")] = 1e8


def followed(p, driven, driver):
    """Where a table at ``driven`` is taken by a drive that has moved to ``driver`` without turning on the way."""
    pushed = max(driven, p.forward_slope * (driver - p.forward_gap))
    return min(pushed, p.backward_slope * (driver + p.backward_gap))


def forward_depth(p, twist):
    """How far the forward flank is pressed in; 0 in the gap."""
    return max(twist - p.forward_gap, 0.0)


def backward_depth(p, twist):
    """How far the backward flank is pressed in, a positive length; 0 in the gap."""
    return max(-p.backward_gap - twist, 0.0)


def reaction(p, twist):
    """Static force that the drive puts on the table at this twist, drive minus table."""
    return p.forward_stiffness * forward_depth(p, twist) - p.backward_stiffness * backward_depth(p, twist)


class BacklashAxisParams(NamedTuple):
    """A drive with one mass and viscous friction, and its play to the table."""

    mass: Annotated[
        float, Unit("kg"), Gt(0), Doc("all that moves, as seen at the table; 83.6 rotating and 62.4 sliding")
    ] = 146.0
    viscous: Annotated[float, Unit("N s/m"), Ge(0), Doc("viscous friction; 0.4 N m s/rad through the screw")] = 1.58e5
    play: Play = Play()


class BacklashAxisState(NamedTuple):
    """Motion of the drive as seen at the table, and the table."""

    drive: Annotated[float, Unit("m")] = 0.0
    speed: Annotated[float, Unit("m/s")] = 0.0
    table: Annotated[float, Unit("m")] = 0.0


class AxisPosition(NamedTuple):
    """What an axis with backlash shows: the table, which a linear scale sees, and the drive, which an encoder sees."""

    position: float = 0.0
    motor: float = 0.0


class BacklashAxisHold(NamedTuple):
    """The exact step of the drive."""

    kept: float
    travel_from_speed: float
    speed_from_force: float
    travel_from_force: float
    play: Play


def backlash_axis_hold(params: BacklashAxisParams, dt: float) -> BacklashAxisHold:
    """The exact solution for a force held over ``dt``."""
    rate = params.viscous / params.mass
    a = rate * dt
    kept = math.exp(-a)
    share = -math.expm1(-a) / a if a > 1e-9 else 1.0 - 0.5 * a
    rest = (1.0 - share) / a if a > 1e-4 else 0.5 - a / 6.0
    return BacklashAxisHold(kept, share * dt, share * dt / params.mass, rest * dt * dt / params.mass, params.play)


def shown(p, s):
    """The table and the drive."""
    return AxisPosition(s.table, s.drive)


@plant(BacklashAxisParams, BacklashAxisState, output=shown, prepare=backlash_axis_hold, unit="m")
def backlash_axis(p, s, u, dt):
    """An axis whose table follows the drive through a classic dead band: state after ``dt`` under a force.

    The table takes no part in the dynamics but by its mass in ``mass``: it has none of its own in the gap, and it stops
    at once when a flank leaves it. The drive's motion is exact; the play sees it at the ends of the steps only.
    """
    speed = p.kept * s.speed + p.speed_from_force * u
    drive = s.drive + p.travel_from_speed * s.speed + p.travel_from_force * u
    return BacklashAxisState(drive, speed if abs(speed) > 1e-30 else 0.0, followed(p.play, s.table, drive))
