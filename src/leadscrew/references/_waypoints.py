"""Positioning: from one position to the next, at rest for a dwell at each, with limited velocity, acceleration, jerk.

Each move is the profile of :mod:`leadscrew.references._motion`; the sequence ends at the last position and stays there.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._motion import Motion, Profile, profile_duration, row_at, shortest_profile, travel
from leadscrew.util.errors import ValueRefused, entry_point


class WaypointsParams(NamedTuple):
    """The sequence, in mm or in any other unit of length or angle used throughout."""

    positions: Annotated[NDArray[np.float64], Unit("mm"), Doc("start position and each next one")]
    dwell: Annotated[NDArray[np.float64], Unit("s"), Ge(0), Doc("rest at each position before the next move")]
    max_velocity: Annotated[float, Unit("mm/s"), Gt(0), Doc("limit of the speed")] = 100.0
    max_acceleration: Annotated[float, Unit("mm/s^2"), Gt(0), Doc("limit of the acceleration")] = 1000.0
    max_jerk: Annotated[float, Unit("mm/s^3"), Ge(0), Doc("limit of the jerk; 0: no limit")] = 0.0


class WaypointsPlan(NamedTuple):
    """One row for each move: start time, start position, direction, then the fields of its profile."""

    table: NDArray[np.float64]
    last: int
    """Index of the last row."""


def plan_waypoints(params: WaypointsParams, dt: float) -> WaypointsPlan:
    """When each move starts, and its profile."""
    rows = []
    time = 0.0
    for here, there, dwell in zip(params.positions[:-1], params.positions[1:], params.dwell[:-1], strict=True):
        profile = shortest_profile(
            abs(there - here), params.max_velocity, params.max_acceleration, params.max_jerk or math.inf
        )
        time += dwell
        rows.append([time, here, -1.0 if there < here else 1.0, *profile])
        time += profile_duration(profile)
    return WaypointsPlan(np.array(rows), len(rows) - 1)


def waypoints_step(p, t):
    """The move that ``t`` lies in or after, found by bisection, as a :class:`Motion`."""
    low = row_at(p.table, p.last, t)
    profile = Profile(
        p.table[low, 3], p.table[low, 4], p.table[low, 5], p.table[low, 6], p.table[low, 7], p.table[low, 8]
    )
    along = travel(profile, t - p.table[low, 0])
    direction = p.table[low, 2]
    return Motion(
        p.table[low, 1] + direction * along.position, direction * along.velocity, direction * along.acceleration
    )


@entry_point
def waypoints(positions: Any, dwell: Any = 0.0, **params: float) -> Block:
    """A reference that visits ``positions`` in turn, from the first, and rests ``dwell`` seconds at each.

    ``dwell`` is one number or one for each position (the last has no effect: the sequence stays there); further
    keywords are the other parameters of :class:`WaypointsParams`.

    Raises:
        ValueRefused: fewer than two positions, or a value out of range.
    """
    places = np.array(positions, dtype=np.float64)
    if places.ndim != 1 or places.size < 2:
        raise ValueRefused(f"positions = {positions!r} (waypoints): expected two or more numbers")
    rests = np.broadcast_to(np.asarray(dwell, dtype=np.float64), places.shape).copy()
    empty = WaypointsParams(places, rests)
    block = reference(empty, prepare=plan_waypoints, name="waypoints", unit="mm")(waypoints_step)
    return block.using(positions=places, dwell=rests, **params)
