"""A test move: strokes from rest to rest, each with its speed, a rest after it, and what it is for.

Every stroke is the profile of :mod:`leadscrew.references._motion`, at the same acceleration and jerk, so that the
move is at once a table of samples, a path of ours (:func:`path_of`) and a program of ``G1`` and ``G4`` in exact
stop mode.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.references._motion import Profile, profile_duration, shortest_profile, travel
from leadscrew.util.errors import ValueRefused

SHARE = 0.98
"""Of speed, acceleration and jerk that a move uses at most: the rest is for the loop that follows it."""
ENDS = 0.02
"""Of the travel that a move keeps away from each end, for the same reason."""


class Limits(NamedTuple):
    """Allowed values; ``jerk`` 0: not limited. m, m/s, m/s^2, m/s^3 (rad likewise), s."""

    low: float
    high: float
    speed: float
    acceleration: float
    jerk: float = 0.0
    duration: float = 60.0

    @property
    def middle(self) -> float:
        """Where the move starts and ends."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest position of a move."""
        margin = ENDS * (self.high - self.low)
        return self.low + margin, self.high - margin


def checked(limits: Limits, per_si: float = 1.0, unit: str = "m") -> Limits:
    """The limits, where a move can be made of them.

    Raises:
        ValueRefused: a value that is none, or out of its range, said in the user's unit.
    """
    low, high = per_si * limits.low, per_si * limits.high
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueRefused(f"travel {low:g} to {high:g} {unit}: expected two numbers, the lower one first")
    for name, value, of in (
        ("top speed", limits.speed, f"{unit}/s"), ("top acceleration", limits.acceleration, f"{unit}/s^2"),
    ):  # fmt: skip
        if not 0.0 < value < math.inf:
            raise ValueRefused(f"{name} = {per_si * value:g} {of}: allowed range is (0, inf)")
    if not 0.0 <= limits.jerk < math.inf:
        raise ValueRefused(f"jerk = {per_si * limits.jerk:g} {unit}/s^3: allowed range is [0, inf); 0 is no limit")
    if not 1.0 <= limits.duration <= 3600.0:
        raise ValueRefused(f"duration = {limits.duration:g} s: allowed range is [1, 3600]")
    return limits


START_REST = 1.0
"""Seconds of rest before the first stroke, for the recorder and the noise of the sensor."""


class Stroke(NamedTuple):
    """From where the last one ended to ``end``, at ``speed`` at most, then ``rest`` seconds."""

    end: float
    speed: float
    rest: float
    purpose: str


@dataclass(frozen=True)
class Move:
    """Strokes from ``start``, inside limits."""

    start: float
    strokes: tuple[Stroke, ...]
    limits: Limits

    def profiles(self) -> list[tuple[float, float, Profile, Stroke]]:
        """Start time, start position, profile and stroke of each."""
        found, time, here = [], START_REST, self.start
        for stroke in self.strokes:
            profile = profile_of(abs(stroke.end - here), stroke.speed, self.limits)
            found.append((time, here, profile, stroke))
            time, here = time + profile_duration(profile) + stroke.rest, stroke.end
        return found

    @property
    def duration(self) -> float:
        """Seconds, first and last rest included."""
        return START_REST + sum(profile_duration(p) + s.rest for _, _, p, s in self.profiles())


class Sampled(NamedTuple):
    """The move at every period: n values each, SI; ``stroke`` is the number of the stroke, -1 before the first."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    stroke: np.ndarray


def profile_of(distance: float, speed: float, limits: Limits) -> Profile:
    """The shortest profile that uses :data:`SHARE` of the limits at most."""
    return shortest_profile(
        distance, min(speed, SHARE * limits.speed), SHARE * limits.acceleration, SHARE * limits.jerk or math.inf
    )


def sampled(move: Move, period: float) -> Sampled:
    """The move at whole periods."""
    count = math.ceil(move.duration / period) + 1
    time = period * np.arange(count)
    position, velocity, acceleration = np.full(count, move.start), np.zeros(count), np.zeros(count)
    number = np.full(count, -1)
    for k, (start, here, profile, stroke) in enumerate(move.profiles()):
        first = math.ceil(start / period - 1e-9)
        last = min(math.ceil((start + profile_duration(profile)) / period + 1e-9), count)
        way = -1.0 if stroke.end < here else 1.0
        rows = np.array([travel(profile, t - start) for t in time[first:last]]).reshape(-1, 3)
        position[first:last] = here + way * rows[:, 0]
        velocity[first:last], acceleration[first:last] = way * rows[:, 1], way * rows[:, 2]
        position[last:] = stroke.end
        number[first:] = k
    return Sampled(time, position, velocity, acceleration, number)


def check(seen: Sampled, limits: Limits, per_si: float = 1.0, unit: str = "m") -> None:
    """Passes where every sample keeps every limit; the jerk by differences of the acceleration.

    Raises:
        ValueRefused: the first sample that does not, with its time, value and limit.
    """
    period = float(seen.time[1] - seen.time[0])
    slack = 1.0 + 1e-9
    jerk = np.diff(seen.acceleration, prepend=0.0) / period
    tests = (
        ("position", seen.position, limits.low, limits.high, unit),
        ("speed", seen.velocity, -limits.speed, limits.speed, f"{unit}/s"),
        ("acceleration", seen.acceleration, -limits.acceleration, limits.acceleration, f"{unit}/s^2"),
        ("jerk", jerk, -(limits.jerk or math.inf), limits.jerk or math.inf, f"{unit}/s^3"),
    )
    for name, values, low, high, of in tests:
        room = (slack - 1.0) * max(abs(low), abs(high)) if math.isfinite(high) else 0.0
        bad = np.flatnonzero((values < low - room) | (values > high + room))
        if len(bad):
            k = int(bad[0])
            raise ValueRefused(
                f"{name} of {per_si * values[k]:g} {of} at {seen.time[k]:g} s: outside of {per_si * low:g} to "
                f"{per_si * high:g}"
            )


def path_of(move: Move, per_si: float = 1000.0) -> Block:
    """The move as a reference of ours, :func:`leadscrew.references.path`; its ``x`` is the axis, mm (deg)."""
    from leadscrew.references._path import line, path

    segments, here = [], move.start
    for stroke in move.strokes:
        piece = line((per_si * here, 0.0, 0.0), (per_si * stroke.end, 0.0, 0.0),
                     60.0 * per_si * min(stroke.speed, SHARE * move.limits.speed))  # fmt: skip
        segments.append(piece._replace(dwell=stroke.rest))
        here = stroke.end
    return path(
        segments, max_acceleration=per_si * SHARE * move.limits.acceleration,
        max_jerk=per_si * SHARE * move.limits.jerk, rapid=60.0 * per_si * move.limits.speed, start_time=START_REST,
    )  # fmt: skip


def there_and_back(
    middle: float, ends: Sequence[float], speed: float, rest: float, purpose: str, times: int = 1
) -> tuple[Stroke, ...]:
    """Strokes to each of the ends in turn, some times, and back to the middle."""
    once = [Stroke(end, speed, rest, purpose) for end in ends]
    return (*(once * times), Stroke(middle, speed, rest, purpose))
