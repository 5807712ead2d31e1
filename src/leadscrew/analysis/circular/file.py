"""The door for measured circles: a CSV file with one line for each point, in the order in which they were measured.

    angle_deg,deviation_um,direction          or        x_mm,y_mm
    0.0,1.2,ccw                                         100.0012,0.0
    ...                                                 ...

- place: ``x`` and ``y``, each with its unit (``_mm``, ``_um``, ``_in``); or the angle (``angle_deg``, ``angle_rad``,
  from +x towards +y) with ``radius`` or ``deviation`` (radius less the nominal one; ``_mm``, ``_um``, ``_in``);
- ``direction``, if there: ``ccw`` or ``cw``. Without it the points say it: one direction, or one and then the other.

Of several turns in a direction the last full one counts. Other columns are ignored, lines that start with ``#``
skipped.

An encoder that loses counts, a bar that is touched: a **jump** is refused, because every quantity here is made of the
largest and the smallest radius. As a jump counts a change between neighbours of more than 30 times the usual one (30
scaled median absolute deviations, and at least 1 um), of the radius or along the path. Play and stick-slip jump too, so
the limit for the radius is ten times as high within 15 degrees of a reversal, and there is none within 3 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CCW, CW, FEWEST, TURN, USUAL, CircularTest, Floats, Turn, positive
from leadscrew.kernel.parameters import nearest
from leadscrew.util.csv_lines import number, read_lines
from leadscrew.util.errors import DataError

USUAL_SCATTER = 30.0
"""Scaled median absolute deviations that a change between neighbours may have."""
LEAST_UM = 1.0
NEAR, AT = math.radians(15.0), math.radians(3.0)
FACTOR = 10.0
"""How much more a change of the radius may be near a reversal."""
WIDEST_GAP = math.radians(2.0)


def refuse_jumps(path: Path, turn: Turn, rows: Sequence[int]) -> None:
    """Nothing, where the turn has no jump.

    Raises:
        DataError: it has; names the row, the size and the angle.
    """
    angle = turn.angle
    step = turn.sign * np.diff(angle)
    usual = turn.spacing
    where = np.degrees(np.mod(angle[1:], 2.0 * math.pi))
    gaps = np.flatnonzero(step > max(5.0 * usual, WIDEST_GAP))
    if gaps.size:
        at = int(gaps[0])
        raise DataError(
            f"{path}, row {rows[at + 1]}: {math.degrees(float(step[at])):.3g} degrees without a point before "
            f"{where[at]:.1f} degrees; {math.degrees(usual):.3g} degrees are usual here"
        )
    change = 1000.0 * np.diff(np.hypot(turn.x_mm, turn.y_mm))
    change -= np.median(change)
    limit = max(USUAL_SCATTER * _scatter(change), LEAST_UM)
    middle = 0.5 * (angle[:-1] + angle[1:])
    from_reversal = np.abs(np.mod(middle + 0.25 * math.pi, 0.5 * math.pi) - 0.25 * math.pi)
    at_reversal = from_reversal < max(AT, 2.0 * usual)
    limits = np.where(at_reversal, np.inf, np.where(from_reversal < NEAR, FACTOR * limit, limit))
    _refuse(path, rows, where, change, limits, "the radius jumps")
    # Along the path: points may be missing or measured twice, but steps are multiples of the usual one.
    missing = step - np.maximum(np.round(step / usual), 0.0) * usual
    size = float(np.mean(np.hypot(turn.x_mm, turn.y_mm)))
    along = 1000.0 * size * missing
    limits = np.full(along.size, max(USUAL_SCATTER * _scatter(along), LEAST_UM, 10.0 * size * usual))
    _refuse(path, rows, where, along, limits, "the path jumps along itself")


def gap_um(turn: Turn) -> float:
    """By how much the radius of the last point differs from the first; 0 where that is no more than between neighbours.

    Where a turn starts at a reversal, play makes a step of it: ten times as much is then allowed.
    """
    radii = 1000.0 * np.hypot(turn.x_mm, turn.y_mm)
    change = np.diff(radii)
    limit = max(USUAL_SCATTER * _scatter(change), LEAST_UM)
    start = abs(math.remainder(float(turn.angle[0]), 0.5 * math.pi))
    gap = abs(float(radii[-1] - radii[0]))
    return gap if gap > (FACTOR * limit if start < NEAR else limit) else 0.0


def _refuse(path: Path, rows: Sequence[int], where: Floats, change: Floats, limits: Floats, what: str) -> None:
    beyond = np.flatnonzero(np.abs(change) > limits)
    if beyond.size:
        at = int(beyond[0])
        raise DataError(
            f"{path}, row {rows[at + 1]}: {what} by {change[at]:.1f} um at {where[at]:.1f} degrees, where neighbours "
            f"differ by {float(np.median(np.abs(change))):.2g} um: an encoder jump? measure the turn again"
        )


def _scatter(values: Floats) -> float:
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


MM = {"mm": 1.0, "um": 1e-3, "in": 25.4}
ANGLES = {"angle_deg": math.pi / 180.0, "angle_rad": 1.0}
WORDS = {"ccw": CCW, "+": CCW, "counter-clockwise": CCW, "cw": CW, "-": CW, "clockwise": CW}


class Points(NamedTuple):
    """Points of one direction, from the centre of the nominal circle, and their rows in the file."""

    x_mm: Floats
    y_mm: Floats
    rows: list[int]


def read_circles(
    path: str | Path,
    radius_mm: float,
    feed_mm_min: float | None = None,
    centre_mm: tuple[float, float] = (0.0, 0.0),
    source: str = "measured",
) -> CircularTest:
    """The circular test in a file.

    Raises:
        DataError: what is wrong with the file, by row (as an editor counts lines) and column; too few points, less than
            a full turn, a jump, points that run against the direction that the file says.
        ValueRefused: a radius or feed that is not positive.
    """
    path = Path(path)
    positive("radius", radius_mm, "mm")
    x, y, said, rows = _points(path, radius_mm, centre_mm)
    if len(rows) < FEWEST:
        raise DataError(f"{path}: {len(rows)} points; a circle needs at least {FEWEST} a turn, and {USUAL} are usual")
    if not np.hypot(x, y).all():
        raise DataError(f"{path}, row {rows[int(np.argmin(np.hypot(x, y)))]}: the point lies on the centre")
    groups = _groups(x, y, said, rows)
    turns, counts = {}, {}
    for direction, points in groups.items():
        try:
            last = _last_turn(points)
            turns[direction] = Turn(direction, last.x_mm, last.y_mm)
        except DataError as error:
            raise DataError(f"{path}: {error}") from None
        refuse_jumps(path, turns[direction], last.rows)
        counts[direction] = len(last.rows)
    each = ", ".join(f"{n} points {d}" for d, n in counts.items())
    try:
        return CircularTest(
            radius_mm, turns.get(CCW), turns.get(CW), feed_mm_min=feed_mm_min, source=source, name=path.name,
            start_deg=math.degrees(float(next(iter(turns.values())).angle[0])) % 360.0, sampling=f"{each}, as measured",
            open_um=max(map(gap_um, turns.values())),
        )  # fmt: skip
    except DataError as error:
        raise DataError(f"{path}: {error}") from None


def _groups(x: Floats, y: Floats, said: list[str], rows: list[int]) -> dict[str, Points]:
    """The points of each direction."""
    if said:
        found = {}
        for direction in (CCW, CW):
            here = [i for i, d in enumerate(said) if d == direction]
            if here:
                found[direction] = Points(x[here], y[here], [rows[i] for i in here])
        return found
    angle = np.unwrap(np.arctan2(y, x))
    net, width = float(angle[-1] - angle[0]), float(np.ptp(angle))
    if abs(net) >= 0.9 * width:
        return {CCW if net > 0 else CW: Points(x, y, rows)}
    first_up = angle.max() - angle[0] > angle[0] - angle.min()
    cut = int(np.argmax(angle) if first_up else np.argmin(angle)) + 1
    halves = [Points(x[:cut], y[:cut], rows[:cut]), Points(x[cut:], y[cut:], rows[cut:])]
    return dict(zip((CCW, CW) if first_up else (CW, CCW), halves, strict=True))


def _last_turn(points: Points) -> Points:
    """The last full turn of points that make more than one."""
    angle = np.unwrap(np.arctan2(points.y_mm, points.x_mm))
    if angle.size < 3:
        return points
    spacing = float(np.median(np.abs(np.diff(angle))))
    kept = np.flatnonzero(np.abs(angle - angle[-1]) > TURN - 0.5 * spacing)
    first = int(kept[-1]) + 1 if kept.size else 0
    return Points(points.x_mm[first:], points.y_mm[first:], points.rows[first:])


def _points(path: Path, radius: float, centre: tuple[float, float]) -> tuple[Floats, Floats, list[str], list[int]]:
    lines = read_lines(path, "x_mm, y_mm or angle_deg, deviation_um")
    row, header = lines[0]
    for name in header:
        if name and header.count(name) > 1:
            raise DataError(f"{path}, row {row}: the column {name!r} appears {header.count(name)} times")
    first, second, polar = _columns(path, row, header)
    at = header.index("direction") if "direction" in header else None
    rows, said, values = [], [], []
    for row, cells in lines[1:]:
        if len(cells) != len(header):
            raise DataError(f"{path}, row {row}: {len(cells)} cells where the header has {len(header)}")
        values.append([number(path, row, c, cells[header.index(c)]) for c in (first, second)])
        rows.append(row)
        if at is not None:
            word = cells[at].lower()
            if word not in WORDS:
                raise DataError(f"{path}, row {row}, column 'direction': {cells[at]!r}; expected ccw or cw")
            said.append(WORDS[word])
    table = np.array(values)
    scale = MM[second.rsplit("_", 1)[1]]
    if not polar:
        return scale * table[:, 0] - centre[0], scale * table[:, 1] - centre[1], said, rows
    if centre != (0.0, 0.0):
        raise DataError(f"{path}: has angles and radii, which have a centre of their own; a centre is for x and y")
    angle, length = table[:, 0] * ANGLES[first], scale * table[:, 1]
    if second.startswith("deviation"):
        length = length + radius
    return length * np.cos(angle), length * np.sin(angle), said, rows


def _columns(path: Path, row: int, header: list[str]) -> tuple[str, str, bool]:
    """The two columns of the place, and whether they are angle and radius."""
    for unit in MM:
        if f"x_{unit}" in header and f"y_{unit}" in header:
            return f"x_{unit}", f"y_{unit}", False
    lengths = [f"{what}_{unit}" for what in ("deviation", "radius") for unit in MM]
    angles, found = [a for a in ANGLES if a in header], [c for c in lengths if c in header]
    if angles and found:
        return angles[0], found[0], True
    if any(";" in name or "\t" in name for name in header):
        raise DataError(
            f"{path}, row {row}: {','.join(header)!r} is not separated by commas; expected commas, and dots in numbers"
        )
    bare = [n for n in header if n in ("x", "y", "angle", "radius", "deviation")]
    if bare:
        raise DataError(f"{path}, row {row}: the column {bare[0]!r} says no unit; expected for example {bare[0]}_"
                        f"{'deg' if bare[0] == 'angle' else 'mm'}")  # fmt: skip
    known = ["x_mm", "y_mm", *ANGLES, *lengths]
    near = next((f"; {n!r} is none of them{nearest(n, known)}" for n in header if n), "")
    raise DataError(
        f"{path}, row {row}: expected the columns x_mm and y_mm, or angle_deg and deviation_um or radius_mm{near}"
    )
