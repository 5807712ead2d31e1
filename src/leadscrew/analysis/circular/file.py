"""The door for measured circles: a CSV file with one line for each point, in the order in which they were measured.

    angle_deg,deviation_um,direction          or        x_mm,y_mm
    0.0,1.2,ccw                                         100.0012,0.0
    ...                                                 ...

- place: ``x`` and ``y``, each with its unit (``_mm``, ``_um``, ``_in``); or the angle (``angle_deg``, ``angle_rad``,
  from +x towards +y) with ``radius`` or ``deviation`` (radius less the nominal one; ``_mm``, ``_um``, ``_in``);
- ``direction``, if there: ``ccw`` or ``cw``. Without it the points say it: one direction, or one and then the other.

Of several turns in a direction the last full one counts, and of a recording in time what belongs to it
(:mod:`leadscrew.analysis.circular.recording`). A turn with a jump is refused
(:mod:`leadscrew.analysis.circular.jumps`), because every quantity here is made of the largest and the smallest radius.
Other columns are ignored, lines that start with ``#`` skipped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from leadscrew.analysis.circular.jumps import first_jump, gap_um
from leadscrew.analysis.circular.paths import (
    CCW,
    CW,
    FARTHEST,
    FEWEST,
    USUAL,
    CircularTest,
    Floats,
    Turn,
    least_squares_circle,
    positive,
)  # fmt: skip
from leadscrew.analysis.circular.recording import Stretch, turns_of
from leadscrew.kernel.parameters import nearest
from leadscrew.util.csv_lines import number, read_lines
from leadscrew.util.errors import DataError

WIDEST_GAP = math.radians(2.0)


def refuse_gaps(path: Path, turn: Turn, rows: Sequence[int]) -> None:
    """Nothing, where the points of the turn lie close to one another.

    Raises:
        DataError: they do not; names the row and the angle.
    """
    step = turn.sign * np.diff(turn.angle)
    usual = turn.spacing
    gaps = np.flatnonzero(step > max(5.0 * usual, WIDEST_GAP))
    if gaps.size:
        at = int(gaps[0])
        raise DataError(
            f"{path}, row {rows[at + 1]}: {math.degrees(float(step[at])):.3g} degrees without a point before "
            f"{math.degrees(float(turn.angle[at + 1])) % 360.0:.1f} degrees; {math.degrees(usual):.3g} degrees are "
            "usual here"
        )


def refuse_jumps(path: Path, turn: Turn, rows: Sequence[int]) -> None:
    """Nothing, where the turn has no jump.

    Raises:
        DataError: it has; names the row, the size and the angle.
    """
    found = first_jump(turn)
    if found is not None:
        what = "the radius jumps" if found.radial else "the path jumps along itself"
        raise DataError(
            f"{path}, row {rows[found.point]}: {what} by {found.um:.1f} um at {math.degrees(found.angle):.1f} degrees, "
            f"where neighbours scatter by {found.scatter_um:.2g} um: an encoder jump? measure the turn again"
        )


MM = {"mm": 1.0, "um": 1e-3, "in": 25.4}
ANGLES = {"angle_deg": math.pi / 180.0, "angle_rad": 1.0}
WORDS = {"ccw": CCW, "+": CCW, "counter-clockwise": CCW, "cw": CW, "-": CW, "clockwise": CW}


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
    _refuse_another_centre(path, x, y, radius_mm, centre_mm)
    turns: dict[str, Turn] = {}
    notes: list[str] = []
    for stretch in _stretches(x, y, said):
        kept = [rows[i] for i in stretch.rows]
        try:
            turn = Turn(stretch.direction, x[stretch.rows], y[stretch.rows], even=False)
        except DataError as error:
            raise DataError(f"{path}: {error}") from None
        refuse_gaps(path, turn, kept)
        refuse_jumps(path, turn, kept)
        turns[stretch.direction] = turn
        notes += stretch.notes
    each = ", ".join(f"{turn.x_mm.size} points {d}" for d, turn in turns.items())
    try:
        return CircularTest(
            radius_mm, turns.get(CCW), turns.get(CW), feed_mm_min=feed_mm_min, source=source, name=path.name,
            start_deg=math.degrees(float(next(iter(turns.values())).angle[0])) % 360.0, sampling=f"{each}, as measured",
            open_um=max(map(gap_um, turns.values())), recorded=tuple(notes),
        )  # fmt: skip
    except DataError as error:
        raise DataError(f"{path}: {error}") from None


def _stretches(x: Floats, y: Floats, said: list[str]) -> list[Stretch]:
    """The turn of each direction that the file says, or that the points say."""
    if not said:
        return turns_of(x, y)
    found = []
    for direction in (CCW, CW):
        here = np.flatnonzero([d == direction for d in said])
        if here.size:
            stretches = turns_of(x[here], y[here])
            mine = next((s for s in stretches if s.direction == direction), stretches[0])
            found.append(mine._replace(direction=direction, rows=here[mine.rows]))
    return found


def _refuse_another_centre(path: Path, x: Floats, y: Floats, radius: float, centre: tuple[float, float]) -> None:
    """Before an angle is taken: about a point outside of the circle there is no turn."""
    try:
        circle = least_squares_circle(x, y)
    except DataError as error:
        raise DataError(f"{path}: {error}") from None
    if math.hypot(circle.x, circle.y) > FARTHEST * radius:
        at = ",".join(f"{a + b:.6g}" for a, b in zip(centre, (circle.x, circle.y), strict=True))
        raise DataError(
            f"{path}: the circle lies around ({at}) mm, not within {FARTHEST * radius:g} mm of the nominal centre "
            f"({centre[0]:g},{centre[1]:g}): give the nominal one, as --centre {at}"
        )


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
