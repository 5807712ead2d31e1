"""Paths in the plane (with depth): lines and arcs at a programmed feed, at rest between them.

Along each segment the speed follows the rest-to-rest profile of :mod:`leadscrew.references._motion`: the path stops at
the end of **every** segment, as LinuxCNC does in exact stop mode (G61.1). There is no blending and no look-ahead: a
path of many short segments is therefore slower here than on a machine that runs in G64.

The position at the distance ``s`` along a segment of length ``L`` is, for a line and an arc alike,

``x = x0 + ux s + r cos(a + k s)``,  ``y = y0 + uy s + r sin(a + k s)``,  ``z = z0 + uz s``

with ``r = 0`` for a line, and for an arc the centre ``(x0, y0)``, the angle ``a`` of its start and ``k = sweep / L``.
Where the two radii of a printed arc differ by rounding, ``ux, uy`` lead it to the programmed end without a jump.

``max_acceleration`` bounds the length of the acceleration vector. On an arc, 1/2 of it is kept for the centripetal part
``v^2 / r`` (which bounds the feed there by ``sqrt(max_acceleration r / 2)``) and ``sqrt(3)/2`` for the tangential part:
together they are the whole.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._motion import Motion, Profile, profile_duration, row_at, shortest_profile, travel
from leadscrew.util.errors import ValueRefused, entry_point


class PathPoint(NamedTuple):
    """The command of two axes."""

    x: Motion = Motion()
    y: Motion = Motion()


class PathPoint3(NamedTuple):
    """The command of three axes."""

    x: Motion = Motion()
    y: Motion = Motion()
    z: Motion = Motion()


class Segment(NamedTuple):
    """One row of the geometry: see the module. Lengths in mm, angles in rad."""

    length: float = 0.0
    x0: float = 0.0
    y0: float = 0.0
    z0: float = 0.0
    ux: float = 0.0
    uy: float = 0.0
    uz: float = 0.0
    radius: float = 0.0
    angle: float = 0.0
    turn: float = 0.0
    """``sweep / length`` in rad/mm, positive counter-clockwise."""
    feed: float = 0.0
    """In mm/min; 0: at the rapid rate."""
    dwell: float = 0.0
    """Seconds at rest after the segment."""


class PathParams(NamedTuple):
    """Limits and geometry of a path."""

    segments: Annotated[NDArray[np.float64], Doc("one row for each segment, the fields of Segment")]
    max_acceleration: Annotated[float, Unit("mm/s^2"), Gt(0), Doc("limit of the acceleration vector")] = 1000.0
    max_jerk: Annotated[float, Unit("mm/s^3"), Ge(0), Doc("limit of the jerk along the path; 0: no limit")] = 0.0
    rapid: Annotated[float, Unit("mm/min"), Gt(0), Doc("speed of G0")] = 6000.0
    feed_override: Annotated[float, Gt(0), Doc("factor on the feed of G1, G2 and G3")] = 1.0
    start_time: Annotated[float, Unit("s"), Ge(0), Doc("when the path starts")] = 0.0


class PathPlan(NamedTuple):
    """What the step needs: for each segment its start time, its profile and its geometry."""

    table: NDArray[np.float64]
    last: int
    """Index of the last row."""


TANGENTIAL = math.sqrt(3.0) / 2.0
CENTRIPETAL = 0.5
SAME_PLACE_MM = 1e-9
"""Incremental programs come back to a place with rounding errors: an arc shorter than this is a full turn."""


def segment_profile(segment: Segment, params: PathParams) -> Profile:
    """The speed along one segment, inside the limits."""
    speed = params.feed_override * segment.feed / 60.0 if segment.feed > 0.0 else params.rapid / 60.0
    acceleration = params.max_acceleration
    if segment.radius > 0.0:
        # The centripetal part is r (k v)^2: on a helix only the motion in the plane turns.
        speed = min(speed, math.sqrt(CENTRIPETAL * acceleration / segment.radius) / abs(segment.turn))
        acceleration = TANGENTIAL * acceleration
    return shortest_profile(segment.length, speed, acceleration, params.max_jerk or math.inf)


def plan_path(params: PathParams, dt: float) -> PathPlan:
    """When each segment starts and how fast it is run."""
    rows = []
    time = params.start_time
    for row in params.segments:
        segment = Segment(*map(float, row))
        profile = segment_profile(segment, params)
        rows.append([time, *profile, *segment[1:10]])
        time += profile_duration(profile) + segment.dwell
    return PathPlan(np.array(rows), len(rows) - 1)


def duration(block: Block) -> float:
    """When the path of a block made by :func:`path` or ``path_from_gcode`` ends, in seconds, last dwell included."""
    params = block.params
    segments = [Segment(*map(float, row)) for row in params.segments]
    return params.start_time + sum(profile_duration(segment_profile(s, params)) + s.dwell for s in segments)


def point_on_path(p, t):
    """The point at ``t``: the segment that ``t`` lies in or after is found by bisection."""
    low = row_at(p.table, p.last, t)
    profile = Profile(
        p.table[low, 1], p.table[low, 2], p.table[low, 3], p.table[low, 4], p.table[low, 5], p.table[low, 6]
    )
    along = travel(profile, t - p.table[low, 0])
    s = along.position
    v = along.velocity
    a = along.acceleration
    ux = p.table[low, 10]
    uy = p.table[low, 11]
    uz = p.table[low, 12]
    turn = p.table[low, 15]
    angle = p.table[low, 14] + turn * s
    across = p.table[low, 13] * math.cos(angle)
    up = p.table[low, 13] * math.sin(angle)
    # Derivatives with respect to s are the direction; turn^2 v^2 is the centripetal part.
    dx = ux - up * turn
    dy = uy + across * turn
    swing = turn * turn * v * v
    return PathPoint3(
        Motion(p.table[low, 7] + ux * s + across, dx * v, dx * a - across * swing),
        Motion(p.table[low, 8] + uy * s + up, dy * v, dy * a - up * swing),
        Motion(p.table[low, 9] + uz * s, uz * v, uz * a),
    )


def path_xy(p, t):
    """The point at ``t`` in the plane."""
    point = point_on_path(p, t)
    return PathPoint(point.x, point.y)


def line(start: tuple[float, float, float], end: tuple[float, float, float], feed: float = 0.0) -> Segment:
    """A straight segment; ``feed`` in mm/min, 0 for the rapid rate."""
    length = math.dist(start, end)
    if length == 0.0:
        return Segment(0.0, *start, feed=feed)
    ux, uy, uz = ((b - a) / length for a, b in zip(start, end, strict=True))
    return Segment(length, *start, ux, uy, uz, feed=feed)


def arc(
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    centre: tuple[float, float],
    clockwise: bool,
    feed: float = 0.0,
) -> Segment:
    """A circular or helical segment in the XY plane; a full turn where the end lies over the start.

    The radius is that of the start.
    """
    radius = math.dist(start[:2], centre)
    angle = math.atan2(start[1] - centre[1], start[0] - centre[0])
    sweep = math.atan2(end[1] - centre[1], end[0] - centre[0]) - angle
    full = 2.0 * math.pi
    if math.dist(start[:2], end[:2]) < SAME_PLACE_MM:
        sweep = full
    elif clockwise:
        sweep = -sweep
    sweep = sweep % full or full
    sweep = -sweep if clockwise else sweep
    depth = end[2] - start[2]
    length = math.hypot(radius * sweep, depth)
    missed_x = end[0] - (centre[0] + radius * math.cos(angle + sweep))
    missed_y = end[1] - (centre[1] + radius * math.sin(angle + sweep))
    return Segment(
        length,
        *centre,
        start[2],
        missed_x / length,
        missed_y / length,
        depth / length,
        radius,
        angle,
        sweep / length,
        feed,
    )


@entry_point
def path(segments: list[Segment], with_z: bool = False, **params: float) -> Block:
    """A reference that runs ``segments`` in turn, at rest between them; commands a :class:`PathPoint`.

    With ``with_z`` it commands a :class:`PathPoint3`; without, motion in Z takes its time and is not shown. Further
    keywords are parameters of :class:`PathParams`.

    Raises:
        ValueRefused: no segment, or a value out of range.
    """
    if not segments:
        raise ValueRefused("segments = [] (path): expected one segment or more")
    table = np.array(segments, dtype=np.float64).reshape(-1, len(Segment._fields))
    step = point_on_path if with_z else path_xy
    block = reference(PathParams(table), prepare=plan_path, name="path", unit="mm", doc=__doc__)(step)
    return block.using(segments=table, **params)
