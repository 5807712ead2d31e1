"""Which measured line is which stroke, from its plunge on and in its direction; and what is plainly wrong with it.

Where a scanned piece lay: the turn and shift that bring its points back to the programmed line.

Least squares over pairs of points (Kabsch), without scale: a piece does not grow, and a wrong unit is to be seen.

What a scan cannot tell. A cut whose tangent is off by the same angle everywhere is the right piece, turned. Laid on the
programmed line by its own shape (``shape``), that angle is gone and is not compensated. Two marks on the sheet, pricked
by the machine at known places (``marks``), tell where the sheet lay, and so keep it.

Measured points before they are believed: strays are taken out, points closer than a scan can tell are put together.

**Strays.** A point that lies further from the median of its seven neighbours (x and y each, itself among them) than
8 standard deviations of that distance, 0.2 mm, and the usual step. On a line that runs on, points *are* the median.
More than two in a row are no strays but a part of the line that lies elsewhere.

**Dense points.** ``k`` neighbours become their mean, for ``k`` steps as long as ``span``: white noise is then less by
``sqrt(k)`` on points ``k`` times as far apart, which leaves the cut-off of the smoothing as it is. The ends are those
of the line through the first two and the last two means.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.paths.curve import Array
from leadscrew.tangent.deviation import STRETCH
from leadscrew.tangent.measurement import Trace
from leadscrew.tangent.settings import MM_PER_INCH
from leadscrew.tangent.stroke import Stroke
from leadscrew.util.errors import DataError, ValueRefused

LEAST_MM = 20.0
"""Two marks stand at least so far apart."""
MOST_MISS_MM = 1.0
"""Distances between marks agree to this."""


class Placing(NamedTuple):
    """A turn about the origin, then a shift: from scanned to programmed coordinates."""

    turn_deg: float
    dx: float
    dy: float

    def of(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Points in programmed coordinates, mm."""
        c, s = math.cos(math.radians(self.turn_deg)), math.sin(math.radians(self.turn_deg))
        return c * x - s * y + self.dx, s * x + c * y + self.dy


AS_IT_IS = Placing(0.0, 0.0, 0.0)


def fitted(scanned: Array, programmed: Array) -> Placing:
    """The placing that brings points (n, 2) closest to others."""
    a, b = scanned.mean(axis=0), programmed.mean(axis=0)
    p, q = scanned - a, programmed - b
    turn = math.atan2(float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()), float((p * q).sum()))
    c, s = math.cos(turn), math.sin(turn)
    return Placing(math.degrees(turn), float(b[0] - c * a[0] + s * a[1]), float(b[1] - s * a[0] - c * a[1]))


def by_marks(pairs: Sequence[tuple[float, float, float, float]]) -> Placing:
    """The placing by marks: programmed X, Y and scanned X, Y of each, mm.

    Raises:
        ValueRefused: fewer than two, too close together, or distances that do not agree.
    """
    rows = np.array(pairs, dtype=np.float64).reshape(-1, 4)
    if len(rows) < 2:
        raise ValueRefused(f"{len(rows)} mark: a turn takes two or more")
    programmed, scanned = rows[:, :2], rows[:, 2:]
    spread = max(math.dist(a, b) for a in programmed for b in programmed)
    if spread < LEAST_MM:
        raise ValueRefused(f"the marks are {spread:.3g} mm apart: expected {LEAST_MM:g} mm or more, to tell a turn")
    placing = fitted(scanned, programmed)
    x, y = placing.of(scanned[:, 0], scanned[:, 1])
    miss = float(np.hypot(x - programmed[:, 0], y - programmed[:, 1]).max())
    if miss > MOST_MISS_MM:
        raise ValueRefused(
            f"the scanned marks do not lie to each other as the programmed ones do: {miss:.3g} mm are left over; "
            "expected the same order, and the scan's true scale"
        )
    return placing


NEIGHBOURS = 7
IN_A_ROW = 2
SIGMAS = 8.0
LEAST_STRAY_MM = 0.2
FEW = 0.01
"""Share of points up to which they are strays; more of them are how the scan is."""
HELD = 6.0
"""Means lie at most so many spans apart, or fewer points are put together."""


def strays(x: Array, y: Array) -> tuple[NDArray[np.int64], float]:
    """Indices of the points that lie off the line of their neighbours, and how far the furthest does, mm."""
    from scipy.ndimage import median_filter

    off = np.hypot(x - median_filter(x, NEIGHBOURS, mode="nearest"), y - median_filter(y, NEIGHBOURS, mode="nearest"))
    step = float(np.median(np.hypot(np.diff(x), np.diff(y))))
    far = off > max(SIGMAS * 1.4826 * float(np.median(off)), LEAST_STRAY_MM, step)
    rows = np.split(np.flatnonzero(far), np.flatnonzero(np.diff(np.flatnonzero(far)) > 1) + 1)
    found = np.concatenate([row for row in rows if row.size <= IN_A_ROW] or [np.empty(0, dtype=np.int64)])
    return found.astype(np.int64), float(off[found].max(initial=0.0))


def thinned(x: Array, y: Array, length: float, span: float) -> tuple[Array, Array, int]:
    """Means of points, and how many each is of; the points themselves where they are not closer than ``span``."""
    count = int(span * (x.size - 1) / length)
    while count > 1:
        edges = np.round(np.linspace(0.0, x.size, x.size // count + 1)).astype(np.int64)
        sizes = np.diff(edges)
        means = np.column_stack([np.add.reduceat(v, edges[:-1]) / sizes for v in (x, y)])
        if np.hypot(*np.diff(means, axis=0).T).max() <= HELD * span:
            # Half a mean's points, but for half a step, lie beyond it.
            share = 0.5 - 0.5 / count
            first = means[0] - share * (means[1] - means[0])
            last = means[-1] + share * (means[-1] - means[-2])
            u, v = np.vstack([first, means, last]).T
            return u, v, count
        count //= 2
    return x, y, 1


ALIGN = ("none", "shape", "marks")
LEAST_POINTS = 12
SHORT_MM = 5.0
"""On a shorter stroke no angle can be told from points."""
LOOKS = 200
"""Points at which a line is compared with a stroke."""
STARTS = 90
"""Starts that are tried on a closed line."""
FAR_SHARE, FAR_MM = 0.05, 10.0
"""Further away than this (of the length, or in mm) a line that is not aligned lies somewhere else."""
TANGLED = 3.0
"""A line of points longer than so many strokes is not in order."""
COARSE = 0.3
"""Distance of points, of the smallest radius."""
COARSE_MM = (0.5, 5.0)
SPAN_MM = 0.1
"""Points closer than this tell nothing more: a fortieth of the shortest automatic cut-off."""
JUMP = 12.0
"""A step that is so many times the usual one."""


class Matched(NamedTuple):
    """Points of the cut of a stroke in its order: as scanned, and then in its coordinates."""

    number: int
    """Of the stroke, from 1."""
    trace: Trace
    x: Array
    y: Array
    each: int = 1
    """Scanned points of which each of these is the mean."""


class Matching(NamedTuple):
    """All of them."""

    found: list[Matched]
    placing: Placing
    notes: list[str]


def matched(
    strokes: Sequence[Stroke],
    traces: Sequence[Trace],
    align: str = "none",
    marks: Sequence[tuple[float, float, float, float]] = (),
    span: float = SPAN_MM,
) -> Matching:
    """Measured lines by stroke; points closer than ``span`` (mm) are put together.

    Raises:
        DataError: lines that are none of these strokes, too coarse, not in order, in another unit.
        ValueRefused: marks without ``align`` marks, or the other way round.
    """
    if align not in ALIGN:
        raise ValueRefused(f"align = {align!r}: expected {', '.join(ALIGN)}")
    if bool(marks) != (align == "marks"):
        raise ValueRefused("marks and align = marks belong together: expected both or neither")
    points = [t for t in traces if t.points]
    if not points:
        return Matching([Matched(n, t, t.x, t.y) for n, t in _numbered(strokes, traces)], AS_IT_IS, [])
    named = [strokes[t.stroke - 1] for t in points if 0 < t.stroke <= len(strokes)]
    _same_unit(named or strokes, points)
    placing = by_marks(marks) if align == "marks" else AS_IT_IS
    if align == "shape":
        placing = _by_centre(strokes, points)
    pairs = _numbered(strokes, points) if any(t.stroke for t in points) else _paired(strokes, points, placing)
    notes: list[str] = []
    short = [n for n, _ in pairs if strokes[n - 1].length < SHORT_MM]
    if short:
        notes.append(f"too short to be matched, kept as they were: stroke {', '.join(map(str, short[:8]))}")
        pairs = [(n, t) for n, t in pairs if n not in short]
    for _, trace in pairs:
        if trace.x.size < LEAST_POINTS:
            raise DataError(f"{trace.where}: {trace.x.size} points are too few: expected {LEAST_POINTS} or more")
    if not pairs:
        raise DataError(f"{points[0].where}: no stroke is {SHORT_MM:g} mm long or longer, so none can be matched")
    found = [_turned(n, strokes[n - 1], t, placing, align, notes, span) for n, t in pairs]
    if align == "shape":
        placing = _by_shape(strokes, found)
    placed = []
    for m in found:
        x, y = placing.of(m.x, m.y)
        placed.append(m._replace(x=x, y=y))
    for m in placed:
        _judged(m, strokes[m.number - 1], align)
    return Matching(placed, placing, notes)


def _numbered(strokes: Sequence[Stroke], traces: Sequence[Trace]) -> list[tuple[int, Trace]]:
    if len(traces) == 1 and not traces[0].stroke:
        if len(strokes) > 1:
            raise DataError(
                f"{traces[0].where}: the program has {len(strokes)} strokes: expected a column stroke that says which "
                "row is of which, 1 for the first"
            )
        return [(1, traces[0])]
    for trace in traces:
        if trace.stroke > len(strokes):
            raise DataError(f"{trace.where}: the program has {len(strokes)} stroke{'s' * (len(strokes) > 1)} only")
    return [(t.stroke, t) for t in traces]


def _paired(strokes: Sequence[Stroke], traces: Sequence[Trace], placing: Placing) -> list[tuple[int, Trace]]:
    """Lines without a number: each is the stroke that lies closest."""
    from scipy.optimize import linear_sum_assignment

    if len(traces) == 1 and len(strokes) == 1:
        return [(1, traces[0])]
    if len(traces) != len(strokes):
        raise DataError(
            f"{traces[0].where}: {_several(len(traces), 'line')} measured, the program has "
            f"{_several(len(strokes), 'stroke')}"
        )
    centres = []
    for stroke in strokes:
        at = stroke.at(np.linspace(0.0, stroke.length, LOOKS))
        centres.append((at.x.mean(), at.y.mean(), 0.1 * stroke.length))
    seen = []
    for t in traces:
        x, y = placing.of(t.x, t.y)
        seen.append((x.mean(), y.mean(), 0.1 * float(np.hypot(np.diff(x), np.diff(y)).sum())))
    cost = [[math.dist(a, b) for b in seen] for a in centres]
    return [(int(a) + 1, traces[int(b)]) for a, b in zip(*linear_sum_assignment(np.array(cost)), strict=True)]


def _several(count: int, what: str) -> str:
    return f"{count} {what}{'s' * (count != 1)}"


def _size(x: Array, y: Array) -> float:
    return math.hypot(float(np.ptp(x)), float(np.ptp(y)))


def _all(strokes: Sequence[Stroke]) -> Array:
    places = [s.at(np.linspace(0.0, s.length, LOOKS)) for s in strokes]
    return np.column_stack([np.concatenate([p.x for p in places]), np.concatenate([p.y for p in places])])


def _same_unit(strokes: Sequence[Stroke], traces: Sequence[Trace]) -> None:
    """Whether the size of it all is that of the program, whatever the order."""
    whole = _all(strokes)
    size = _size(whole[:, 0], whole[:, 1])
    seen = _size(np.concatenate([t.x for t in traces]), np.concatenate([t.y for t in traces]))
    count = sum(t.x.size for t in traces)
    if count == 1:
        raise DataError(f"{traces[0].where}: 1 point is too few: expected {LEAST_POINTS} or more")
    if seen == 0.0:
        raise DataError(f"{traces[0].where}: all points are the same")
    for factor, what in ((MM_PER_INCH, "mm read as inches"), (1.0 / MM_PER_INCH, "inches read as mm")):
        if 0.8 < seen / size / factor < 1.25:
            raise DataError(
                f"{traces[0].where}: is {seen / size:.3g} times as large as the program's line: {what}? Say the unit "
                "in the header (x_inch, x_mm) or with --unit"
            )


def _at(stroke: Stroke, closed: bool = False) -> Array:
    p = stroke.at(np.linspace(0.0, stroke.length, LOOKS, endpoint=not closed))
    return np.column_stack((p.x, p.y))


def _even(x: Array, y: Array, closed: bool) -> tuple[Array, Array]:
    """Points at even distances, and the place of each scanned point in units of them."""
    if closed:
        x, y = np.append(x, x[0]), np.append(y, y[0])
    q = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    even = np.linspace(0.0, q[-1], LOOKS, endpoint=not closed)
    return np.column_stack((np.interp(even, q, x), np.interp(even, q, y))), q / q[-1]


def _by_centre(strokes: Sequence[Stroke], traces: Sequence[Trace]) -> Placing:
    """Centre on centre: a first guess of where a piece lay, good enough to tell lines apart."""
    a = _all(strokes).mean(axis=0)
    seen = np.concatenate([_even(t.x, t.y, t.closed)[0] for t in traces]).mean(axis=0)
    return Placing(0.0, float(a[0] - seen[0]), float(a[1] - seen[1]))


def _cleaned(number: int, stroke: Stroke, trace: Trace, notes: list[str], span: float) -> tuple[Array, Array, int]:
    """The points without strays, and put together where they are dense."""
    keep = np.append(True, np.hypot(np.diff(trace.x), np.diff(trace.y)) > 0.0)
    x, y = trace.x[keep], trace.y[keep]
    if x.size < LEAST_POINTS:
        return x, y, 1
    astray, far = strays(x, y)
    if astray.size:
        clean = np.delete(x, astray), np.delete(y, astray)
        if _jump(*clean) is not None:
            return x, y, 1
        few = astray.size <= max(FEW * x.size, 1.0)
        who = f"{_several(astray.size, 'point')} of stroke {number} (near {x[astray[0]]:.1f}, {y[astray[0]]:.1f})"
        notes.append(
            f"{trace.where}: {who} up to {far:.2g} mm off the line of the others"
            + (": left out" if few else "; so many are not left out: the error is uncertain there")
        )
        if few:
            x, y = clean
    return thinned(x, y, stroke.length, span)


def _turned(
    number: int, stroke: Stroke, trace: Trace, placing: Placing, align: str, notes: list[str], span: float
) -> Matched:
    """The points as scanned, begun at the plunge and in the direction of the cut."""
    x, y, each = _cleaned(number, stroke, trace, notes, span)
    length = float(np.hypot(np.diff(x), np.diff(y)).sum())
    grown = _size(x, y) / max(_size(*_at(stroke).T), 1e-9)
    if length > TANGLED * stroke.length and grown > 0.7 * length / stroke.length:
        raise DataError(
            f"{trace.where}: is {grown:.3g} times as large as stroke {number}: another unit or scale? Say the unit in "
            "the header (x_cm, x_mm) or with --unit"
        )
    if length > TANGLED * stroke.length:
        raise DataError(
            f"{trace.where}: the length along its points is {length:.0f} mm, the path's {stroke.length:.0f} mm: its "
            "points are not in order; expected that of the cut"
        )
    whole = length + (math.hypot(x[0] - x[-1], y[0] - y[-1]) if trace.closed else 0.0)
    if whole < (1.0 - STRETCH) * stroke.length:
        raise DataError(
            f"{trace.where}: does not cover the path: it is {whole:.1f} mm long, stroke {number} {stroke.length:.1f}; "
            "expected the whole cut, from plunge to lift"
        )
    _no_jump(x, y, trace)
    closed = trace.closed or (stroke.path.closed and math.hypot(x[0] - x[-1], y[0] - y[-1]) < 1e-9)
    wanted = _at(stroke, closed)
    best: tuple[float, int, bool] | None = None
    for back in (False, True):
        u, v = (x[::-1], y[::-1]) if back else (x, y)
        even, _ = _even(*placing.of(u, v), closed)
        for start in range(0, LOOKS, max(LOOKS // STARTS, 1)) if closed else (0,):
            rolled = np.roll(even, -start, axis=0)
            if align == "shape":
                p = fitted(rolled, wanted)
                rolled = np.column_stack(p.of(rolled[:, 0], rolled[:, 1]))
            miss = float(np.sqrt(np.mean(np.sum((rolled - wanted) ** 2, axis=1))))
            if best is None or miss < best[0] - 1e-9:
                best = (miss, start, back)
    assert best is not None
    _, start, back = best
    if back:
        notes.append(f"{trace.where}: runs against the cut; it was turned round")
        x, y = x[::-1], y[::-1]
    if closed:
        x, y = _begun(x, y, start, stroke, placing, align)
    return Matched(number, trace, x, y, each)


def _begun(x: Array, y: Array, start: int, stroke: Stroke, placing: Placing, align: str) -> tuple[Array, Array]:
    """A closed line, begun where the knife plunged: at the place nearest to it."""
    if math.hypot(x[0] - x[-1], y[0] - y[-1]) < 1e-9:
        x, y = x[:-1], y[:-1]
    even, share = _even(x, y, True)
    if align == "shape":
        placing = fitted(np.roll(even, -start, axis=0), _at(stroke, True))
    u, v = placing.of(x, y)
    first = stroke.at(0.0)
    near = np.abs((share[:-1] - start / LOOKS + 0.5) % 1.0 - 0.5) < 2.5 / STARTS
    away = np.where(near, np.hypot(u - float(first.x), v - float(first.y)), np.inf)
    k = int(np.argmin(away))
    x, y = np.roll(x, -k), np.roll(y, -k)
    return np.append(x, x[0]), np.append(y, y[0])


def _jump(x: Array, y: Array) -> int | None:
    """The point after which the line jumps."""
    steps = np.hypot(np.diff(x), np.diff(y))
    k = int(np.argmax(steps))
    return k if steps[k] > max(JUMP * float(np.median(steps)), 3.0) else None


def _no_jump(x: Array, y: Array, trace: Trace) -> None:
    k = _jump(x, y)
    if k is not None:
        steps = np.hypot(np.diff(x), np.diff(y))
        usual = float(np.median(steps))
        raise DataError(
            f"{trace.where}: from point {k + 1} to point {k + 2} it jumps by {steps[k]:.3g} mm, {usual:.3g} mm being "
            "usual: a part is missing, or the points are not in order"
        )


def _by_shape(strokes: Sequence[Stroke], found: Sequence[Matched]) -> Placing:
    """The placing that brings all lines closest to their strokes, at equal shares of their lengths."""
    scanned = np.concatenate([_even(m.x, m.y, False)[0] for m in found])
    return fitted(scanned, np.concatenate([_at(strokes[m.number - 1]) for m in found]))


def _judged(m: Matched, stroke: Stroke, align: str) -> None:
    """Close enough to the stroke, and its points close enough to each other."""
    even, _ = _even(m.x, m.y, False)
    away = float(np.median(np.hypot(*(even - _at(stroke)).T)))
    limit = max(FAR_MM, FAR_SHARE * stroke.length)
    if away > limit:
        hint = "; a piece that was placed otherwise takes --align" if align == "none" else ""
        raise DataError(
            f"{m.trace.where}: lies {away:.0f} mm from where stroke {m.number} was programmed (expected up to "
            f"{limit:.0f} mm): this is another line{hint}"
        )
    spacing = float(np.median(np.hypot(np.diff(m.x), np.diff(m.y))))
    sharpest = float(np.abs(stroke.at(stroke.grid(0.25)).curvature).max())
    coarse = min(max(COARSE / max(sharpest, 1e-9), COARSE_MM[0]), COARSE_MM[1])
    if spacing > coarse:
        raise DataError(
            f"{m.trace.where}: too coarse: a point every {spacing:.3g} mm, and stroke {m.number} bends with a radius "
            f"of {1.0 / max(sharpest, 1e-9):.3g} mm; expected a point every {coarse:.2g} mm or closer"
        )
