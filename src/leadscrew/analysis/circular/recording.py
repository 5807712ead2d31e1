"""The turns of a circle in a recording that was sampled in time: rows at rest, feed-in, ramps and overlap left out.

A control or a scope records from before the start until after the end. A row belongs to a turn where the path runs
along the circle in one direction:

1. **speed**: angle from ``i - w`` to ``i``, from ``i`` to ``i + w``, and both, a row. ``w`` is as small as noise
   allows: in ``w`` rows the path moves 20 times its noise.
2. **feed**: the median speed of the rows that move at more than half of the fastest speed, that of 40 rows.
3. **moving**: more than 5 % of the feed before and behind, less than 20 % across, and a radius within 5 % of the median
   of the fast rows. What does not is at rest, creeps, or is a feed-in.
4. **turn**: of the last stretch of moving rows in a direction that makes a full turn, the last 360 degrees: at 97 % of
   the feed or more where that makes a full turn, else with the ramps. From 355 degrees on it is a turn with a note.

Noise: from third differences along the path, ``MAD / sqrt(20)``, which a motion at constant feed does not reach.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CCW, CW, SHORTEST, TURN, Floats

MOVING, ACROSS, AT_FEED = 0.05, 0.2, 0.97
"""Parts of the feed."""
ON_CIRCLE = 0.05
"""Part of the radius."""
NOISES = 20.0
END = 6.0
"""Times the noise within which a row is at the end of a stretch."""
SCALED = 1.4826


class Stretch(NamedTuple):
    """Rows of one turn in their order, and what of the recording was left out."""

    direction: str
    rows: np.ndarray
    """Indices of the recording."""
    degrees: float
    """Covered, up to 360."""
    notes: tuple[str, ...]


def turns_of(x_mm: Floats, y_mm: Floats) -> list[Stretch]:
    """The turns of a recording, at most one in each direction, in the order of the recording.

    Where no stretch makes a turn, the longest is returned with what it covers.
    """
    angle = np.unwrap(np.arctan2(y_mm, x_mm))
    radius = np.hypot(x_mm, y_mm)
    w = window(angle)
    rate = speed(angle, w)
    size = np.abs(rate)
    fast = size > 0.5 * _fastest(size)
    feed = float(np.median(size[fast]))
    usual = float(np.median(radius[fast]))
    ahead = np.append((angle[w:] - angle[:-w]) / w, rate[-w:])
    behind = np.concatenate((rate[:w], ahead[:-w]))
    across = np.abs(speed(radius, w)) > ACROSS * feed * usual
    on = (np.abs(radius - usual) < ON_CIRCLE * usual) & ~across
    found = []
    for direction, sign in ((CCW, 1.0), (CW, -1.0)):
        moving = on & (sign * behind > MOVING * feed) & (sign * ahead > MOVING * feed)
        stretches = [_trimmed(sign * angle, s) for s in _stretches(angle, _filled(moving, 2 * w), sign) if s.size > 2]
        if stretches:
            found.append(_last(direction, sign, angle, sign * rate / feed, stretches))
    longest = max((s.degrees for s in found), default=0.0)
    kept = [s for s in found if s.degrees > 0.5 * longest]
    kept.sort(key=lambda s: int(s.rows[0]))
    return [s._replace(notes=_notes(s, x_mm.size, on, kept)) for s in kept]


def noise(angle: Floats) -> float:
    """Standard deviation of an angle's noise, rad, without the motion."""
    third = np.diff(angle, 3)
    return SCALED * float(np.median(np.abs(third - np.median(third)))) / math.sqrt(20.0) if third.size else 0.0


def window(angle: Floats) -> int:
    """Rows in which the path moves 20 times its noise."""
    sigma, w, most = noise(angle), 1, max(1, angle.size // 40)
    while w < most:
        moved = np.abs(angle[w:] - angle[:-w])
        if _fastest(moved) >= NOISES * sigma:
            break
        w = min(2 * w, most)
    return w


def _fastest(values: Floats) -> float:
    """What 40 values reach, or a tenth of them."""
    k = max(1, min(40, values.size // 10))
    return float(np.partition(values, -k)[-k])


def speed(angle: Floats, w: int) -> Floats:
    """Angle a row, from ``w`` rows before to ``w`` rows behind."""
    at = np.arange(angle.size)
    low, high = np.maximum(at - w, 0), np.minimum(at + w, angle.size - 1)
    return np.asarray((angle[high] - angle[low]) / (high - low))


def _filled(rows: np.ndarray, longest: int) -> np.ndarray:
    """With holes of up to ``longest`` rows filled: noise makes them."""
    at = np.flatnonzero(rows)
    filled = rows.copy()
    for i in np.flatnonzero((np.diff(at) > 1) & (np.diff(at) <= longest + 1)):
        filled[at[i] : at[i + 1]] = True
    return filled


def _stretches(angle: Floats, moving: np.ndarray, sign: float) -> list[np.ndarray]:
    """Runs of moving rows; two with a rest between them are one where the axis did not turn back or move on."""
    rows = np.flatnonzero(moving)
    if not rows.size:
        return []
    cuts = np.flatnonzero(np.diff(rows) > 1) + 1
    runs = np.split(rows, cuts)
    joined = [runs[0]]
    for run in runs[1:]:
        between = sign * float(angle[run[0]] - angle[joined[-1][-1]])
        if -math.radians(0.5) < between < math.radians(2.0):
            joined[-1] = np.concatenate((joined[-1], run))
        else:
            joined.append(run)
    return joined


def _trimmed(along: Floats, rows: np.ndarray) -> np.ndarray:
    """Without the rows at either end that lie within the noise of the end."""
    margin = END * noise(along)
    first = np.flatnonzero(along[rows] <= along[rows].min() + margin)[-1]
    last = np.flatnonzero(along[rows] >= along[rows].max() - margin)[0]
    return rows[first : last + 1] if first < last else rows


def _last(direction: str, sign: float, angle: Floats, share: Floats, stretches: list[np.ndarray]) -> Stretch:
    """Of the stretches the last that makes a turn, or the longest."""
    covered = [_covered(angle, s) for s in stretches]
    full = [i for i, c in enumerate(covered) if c >= SHORTEST]
    rows = stretches[full[-1] if full else int(np.argmax(covered))]
    fast = np.flatnonzero(share[rows] >= AT_FEED)
    steady = rows[fast[0] : fast[-1] + 1] if fast.size else rows[:0]
    ramps = steady.size < 3 or _covered(angle, steady) < TURN * (1.0 - 1e-9) - _spacing(angle, steady)
    if not ramps:
        rows = steady
    along = sign * angle[rows]
    inside = along > along.max() - TURN + 0.5 * _spacing(angle, rows)
    rows = rows[inside]
    notes = ("the turn includes a start or end ramp",) if ramps and share[rows].min() < AT_FEED else ()
    return Stretch(direction, rows, min(math.degrees(_covered(angle, rows) + _spacing(angle, rows)), 360.0), notes)


def _covered(angle: Floats, rows: np.ndarray) -> float:
    return float(np.ptp(angle[rows])) if rows.size else 0.0


def _spacing(angle: Floats, rows: np.ndarray) -> float:
    """Usual angle from row to row."""
    steps = np.abs(np.diff(angle[rows]))
    return float(np.median(steps)) if steps.size else 0.0


def _notes(stretch: Stretch, rows: int, on: np.ndarray, kept: list[Stretch]) -> tuple[str, ...]:
    """What was left out, once for the recording, on its first turn."""
    notes = list(stretch.notes)
    if stretch.degrees < 360.0 - 0.05:
        notes.append(f"the turn covers {stretch.degrees:.1f} degrees")
    if stretch is kept[0]:
        taken = np.concatenate([s.rows for s in kept])
        left = rows - taken.size
        away = int((~on).sum())
        if left:
            parts = [f"{left} of {rows} rows are at rest, on a ramp or before the last turn and are left out"]
            if away:
                parts.append(f"{away} of them lie beside the circle (feed-in)")
            notes.append("; ".join(parts))
    return tuple(notes)
