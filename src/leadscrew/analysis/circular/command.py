"""A circle as the command of a loop: at rest, then up to speed smoothly, then turn after turn at constant feed.

    phi(t) = start + d w T (q^3 - q^4 / 2),  q = t / T      up to T
    phi(t) = start + d w (t - T / 2)                        from there
    x = x_c + R cos phi,   y = y_c + R sin phi

``d`` is 1 counter-clockwise and -1 clockwise, ``w = feed / R``. The angular speed rises as ``3 q^2 - 2 q^3``: speed and
acceleration have no jump at either end, the jerk is finite. ``T`` is a quarter of the time of a turn, so that an eighth
of a turn brings it up to speed. Velocities and accelerations are exact derivatives.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.sheet import Doc, Gt, Unit
from leadscrew.references._motion import Motion
from leadscrew.references._path import PathPoint, PathPoint3


class CircleParams(NamedTuple):
    """The circle, in the unit of the loop's command."""

    radius: Annotated[float, Gt(0), Doc("of the circle")] = 100.0
    speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("angular speed at the feed")] = 1.0
    turning: Annotated[float, Doc("1 counter-clockwise, -1 clockwise")] = 1.0
    start: Annotated[float, Unit("rad"), Doc("angle of the start point, from +x towards +y")] = 0.0
    centre_x: Annotated[float, Doc("of the circle")] = 0.0
    centre_y: Annotated[float, Doc("of the circle")] = 0.0


class Point(NamedTuple):
    """Positions of two axes, for controllers that take no derivatives."""

    x: float = 0.0
    y: float = 0.0


class Point3(NamedTuple):
    """Positions of three axes."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


QUARTER = 0.5 * math.pi
"""Angle that the feed would turn in the time that it takes to come up to it, rad."""


def phase(p, t):
    """Angle, its rate and its acceleration."""
    rise = QUARTER / p.speed
    q = min(t / rise, 1.0)
    ahead = p.speed * max(t - rise, 0.0)
    turned = QUARTER * (q * q * q - 0.5 * q * q * q * q) + ahead
    rate = p.speed * q * q * (3.0 - 2.0 * q)
    growth = p.speed / rise * 6.0 * q * (1.0 - q)
    return Motion(p.start + p.turning * turned, p.turning * rate, p.turning * growth)


def along_x(p, t):
    """Motion of X."""
    turn = phase(p, t)
    c = p.radius * math.cos(turn.position)
    s = p.radius * math.sin(turn.position)
    square = turn.velocity * turn.velocity
    return Motion(p.centre_x + c, -s * turn.velocity, -s * turn.acceleration - c * square)


def along_y(p, t):
    """Motion of Y."""
    turn = phase(p, t)
    c = p.radius * math.cos(turn.position)
    s = p.radius * math.sin(turn.position)
    square = turn.velocity * turn.velocity
    return Motion(p.centre_y + s, c * turn.velocity, c * turn.acceleration - s * square)


@reference(CircleParams())
def circle_motion(p, t):
    """The circle with derivatives, for both axes."""
    return PathPoint(along_x(p, t), along_y(p, t))


@reference(CircleParams())
def circle_motion_3(p, t):
    """The same for three axes; the third rests at 0."""
    return PathPoint3(along_x(p, t), along_y(p, t), Motion(0.0, 0.0, 0.0))


@reference(CircleParams())
def circle_point(p, t):
    """Positions of both axes."""
    return Point(along_x(p, t).position, along_y(p, t).position)


@reference(CircleParams())
def circle_point_3(p, t):
    """Positions of three axes; the third rests at 0."""
    return Point3(along_x(p, t).position, along_y(p, t).position, 0.0)


@reference(CircleParams())
def circle_x_motion(p, t):
    """Motion of X alone."""
    return along_x(p, t)


@reference(CircleParams())
def circle_y_motion(p, t):
    """Motion of Y alone."""
    return along_y(p, t)


@reference(CircleParams())
def circle_x(p, t):
    """Position of X alone."""
    return along_x(p, t).position


@reference(CircleParams())
def circle_y(p, t):
    """Position of Y alone."""
    return along_y(p, t).position


REACHED_TURNS = 0.125
"""Turns made when the feed is reached."""


def time_of(turns: float, speed: float) -> float:
    """When the circle has turned that far, past the rise, s."""
    return (2.0 * math.pi * turns + 0.5 * QUARTER) / speed
