"""Motion: a command with its derivatives, and the rest-to-rest speed profile that all positioning references share.

The profile (in the order in which it happens; each end mirrors the other):

1. the acceleration rises at ``jerk`` for ``jerk_time`` to ``acceleration`` (at once where ``jerk_time`` is 0);
2. it holds for ``hold_time``;
3. it falls at ``jerk`` for ``jerk_time``: the peak velocity is ``acceleration (jerk_time + hold_time)``;
4. the velocity holds for ``cruise_time``; then 3, 2, 1 backwards with the opposite acceleration.

With ``jerk_time = 0`` this is the trapezoid of speed, without ``hold_time`` and ``cruise_time`` the shortest S-curve.
Formulas: the standard seven-segment profile (for example L. Biagiotti, C. Melchiorri, *Trajectory Planning for
Automatic Machines and Robots*, Springer 2008, sections 3.2 and 3.4), derived here for rest to rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from leadscrew.util.errors import ValueRefused


class Motion(NamedTuple):
    """A command with its first two time derivatives, in its unit, unit/s and unit/s^2."""

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


class Profile(NamedTuple):
    """A rest-to-rest speed profile over ``distance >= 0``; times in seconds, see the module."""

    distance: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    """0 where ``jerk_time`` is 0."""
    jerk_time: float = 0.0
    hold_time: float = 0.0
    cruise_time: float = 0.0


def shortest_profile(
    distance: float, max_velocity: float, max_acceleration: float, max_jerk: float = math.inf
) -> Profile:
    """The shortest rest-to-rest profile over ``distance >= 0`` inside the limits, each positive.

    Raises:
        ValueRefused: the limits are so far apart that the durations are not numbers.
    """
    try:
        profile = _shortest_profile(distance, max_velocity, max_acceleration, max_jerk) if distance else Profile()
    except (OverflowError, ZeroDivisionError):
        profile = Profile(math.nan)
    if not math.isfinite(sum(profile)):
        raise ValueRefused(
            f"a move over {distance!r} with max_velocity = {max_velocity!r}, max_acceleration = {max_acceleration!r} "
            f"and max_jerk = {max_jerk!r} takes a time that cannot be computed: the values are too far apart"
        )
    return profile


def _shortest_profile(d: float, v: float, a: float, j: float) -> Profile:
    if math.isinf(j):
        v = min(v, math.sqrt(a * d))
        hold = v / a
        return Profile(d, a, 0.0, 0.0, hold, max(d / v - hold, 0.0))
    if d < 2.0 * _distance_to_reach(v, a, j):
        if d * j * j >= 2.0 * a**3:  # the limit of acceleration is reached: d = v (v/a + a/j)
            v = 0.5 * a * (math.sqrt((a / j) ** 2 + 4.0 * d / a) - a / j)
        else:  # it is not: d = 2 j jerk_time^3, v = j jerk_time^2
            v = j * (d / (2.0 * j)) ** (2.0 / 3.0)
    jerk_time = a / j if v * j >= a * a else math.sqrt(v / j)
    hold = max(v / a - jerk_time, 0.0) if v * j >= a * a else 0.0
    return Profile(d, j * jerk_time, j, jerk_time, hold, max(d / v - 2.0 * jerk_time - hold, 0.0))


def _distance_to_reach(v: float, a: float, j: float) -> float:
    """The distance from rest to velocity ``v``."""
    return 0.5 * v * (v / a + a / j if v * j >= a * a else 2.0 * math.sqrt(v / j))


def profile_duration(profile):
    """How long the profile takes, in seconds."""
    return 2.0 * (2.0 * profile.jerk_time + profile.hold_time) + profile.cruise_time


def travel(profile, t):
    """Distance travelled, speed and tangential acceleration at ``t`` seconds after the start, as a :class:`Motion`.

    Before the start and from the end on the profile is at rest; the end is ``distance`` exactly. The second half is
    the first one seen from the end, so both ends are exact and neither gathers rounding errors of the other.
    """
    speed_up = 2.0 * profile.jerk_time + profile.hold_time
    duration = 2.0 * speed_up + profile.cruise_time
    first_half = t < 0.5 * duration
    from_end = max(min(t, duration - t), 0.0)
    # Time spent so far in rising, holding and falling acceleration, and at constant velocity.
    t1 = min(from_end, profile.jerk_time)
    t2 = min(max(from_end - profile.jerk_time, 0.0), profile.hold_time)
    t3 = min(max(from_end - profile.jerk_time - profile.hold_time, 0.0), profile.jerk_time)
    t4 = max(from_end - speed_up, 0.0)
    v1 = 0.5 * profile.jerk * t1 * t1
    v2 = v1 + profile.acceleration * t2
    v3 = v2 + (profile.acceleration - 0.5 * profile.jerk * t3) * t3
    x1 = profile.jerk * t1 * t1 * t1 / 6.0
    x2 = x1 + (v1 + 0.5 * profile.acceleration * t2) * t2
    x3 = x2 + (v2 + (0.5 * profile.acceleration - profile.jerk * t3 / 6.0) * t3) * t3
    x4 = x3 + v3 * t4
    rising = profile.jerk * t1 if from_end < profile.jerk_time else profile.acceleration - profile.jerk * t3
    size = rising if from_end <= speed_up and t >= 0.0 and t < duration else 0.0
    return Motion(x4 if first_half else profile.distance - x4, v3, size if first_half else -size)


class Move(NamedTuple):
    """One move from rest to rest: where and when it starts, which way (1 or -1), and its profile."""

    start: float
    direction: float
    start_time: float
    profile: Profile


def move_at(move, t):
    """Position, velocity and acceleration of a :class:`Move` at ``t``."""
    along = travel(move.profile, t - move.start_time)
    return Motion(
        move.start + move.direction * along.position,
        move.direction * along.velocity,
        move.direction * along.acceleration,
    )


def row_at(table, last, t):
    """The last row of a table whose first column, a time, is not after ``t``; by bisection, 0 before the first."""
    low = 0
    high = last
    while low < high:
        middle = (low + high + 1) // 2
        if t >= table[middle, 0]:
            low = middle
        else:
            high = middle - 1
    return low
