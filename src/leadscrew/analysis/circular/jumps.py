"""Encoder jumps of a measured turn: a discontinuity that noise, play, glitches and speed do not make.

    J_i = mean(v_(i+1) ... v_(i+m)) - mean(v_i ... v_(i-m+1))      of the radius, and of the path along the circle

Along the circle ``v`` is the path less that at the local speed; points that are missing or measured twice, steps that
are multiples of the usual one, do not count. ``m`` rows are half a degree, 3 to 12. A jump is

    sqrt((J_r / s_r)^2 + (J_t / s_t)^2) > 6.5,     and |J| > 1 um

with ``s`` the scaled median absolute deviation of the turn's own ``J``, and at least 0.1 um. Single points that lie
beside their neighbours (second differences beyond 30 of their scatter) are jumps there and back.

Play, stick motion and slips at the reversal of an axis move the radius: within 3 degrees of a reversal (and ``m`` rows)
it does not count, within 15 degrees the limit is ten times as high. Along the circle only rows within 2 % of the usual
speed count, because a ramp bends the path in time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import Floats, Turn
from leadscrew.analysis.circular.recording import noise, speed, window

LIMIT = 6.5
SPIKE, BESIDE = 30.0, 0.75
LEAST_UM = 1.0
FINEST_UM = 0.1
SHARP = 0.6
"""Part of a step that lies between two neighbours."""
NEAR, AT = math.radians(15.0), math.radians(3.0)
FACTOR = 10.0
"""How much more a change of the radius may be near a reversal."""
SCALED = 1.4826
STEADY = 0.02
"""Part of the usual speed by which that around a point may differ."""
CLEAR = 14.0
"""Times the noise that a step must have, so that noise makes no missing point."""
WIDE = 50
"""Points to each side of which the local speed is the median."""


class Jump(NamedTuple):
    """Where a turn jumps."""

    point: int
    """The first point behind it."""
    um: float
    angle: float
    """rad, in [0, 2 pi)."""
    radial: bool
    scatter_um: float
    """Of the turn's own changes."""


def first_jump(turn: Turn) -> Jump | None:
    """The largest jump of a turn."""
    if turn.x_mm.size < 12:
        return None
    m = int(np.clip(round(math.radians(0.5) / turn.spacing), 3, 12))
    angle = turn.angle
    radius = 1000.0 * np.hypot(turn.x_mm, turn.y_mm)
    path, steady = _along(turn.sign * angle, float(np.median(radius)))
    away = np.abs(np.mod(angle + 0.25 * math.pi, 0.5 * math.pi) - 0.25 * math.pi)
    spike = _spike(turn, radius, away)
    if spike is not None:
        return spike
    clear = _least(away, m)
    across, along = _steps(radius, m), _steps(path, m)
    r_counts = clear > AT
    t_counts = _least(steady.astype(float), m) > 0.0
    s_r, s_t = (max(_scatter(v[c]), FINEST_UM) for v, c in ((across, r_counts), (along, t_counts)))
    across, along = np.where(r_counts, across, 0.0), np.where(t_counts, along, 0.0)
    size, um = np.hypot(across / s_r, along / s_t), np.hypot(across, along)
    events = _events(np.flatnonzero((size > LIMIT) & (um > LEAST_UM)), size, 2 * m)
    events = [i for i in events if _sharp(i + m, um[i], radius * r_counts[i], path * t_counts[i])]
    near = [i for i in events if clear[i] < NEAR and abs(across[i]) / s_r > abs(along[i]) / s_t]
    if len(near) > 1:
        events = [i for i in events if i not in near or size[i] > FACTOR * LIMIT]
    if events:
        i = max(events, key=lambda i: float(size[i]))
        radial = abs(across[i]) / s_r >= abs(along[i]) / s_t
        value, s = (across[i], s_r) if radial else (along[i], s_t)
        return Jump(i + m, float(value), float(np.mod(angle[i + m], 2.0 * math.pi)), bool(radial), s)
    return None


def _events(rows: np.ndarray, size: Floats, width: int) -> list[int]:
    """Of neighbours that are beyond the limit, the one farthest beyond."""
    if not rows.size:
        return []
    groups = np.split(rows, np.flatnonzero(np.diff(rows) > width) + 1)
    return [int(g[np.argmax(size[g])]) for g in groups]


def _sharp(point: int, um: float, across: Floats, along: Floats) -> bool:
    """Whether most of a step lies between two neighbours: a glitch and a cyclic error take longer."""
    low, high = max(point - 2, 0), point + 2
    between = np.hypot(np.diff(across[low:high]), np.diff(along[low:high]))
    return bool(between.size) and float(between.max()) > SHARP * um


def _spike(turn: Turn, radius: Floats, away: Floats) -> Jump | None:
    """A point beside its neighbours: a second difference twice as large as the next to it; a step's are equal."""
    second = np.diff(radius, 2)
    here = away[1:-1]
    scatter = _scatter(second)
    limit = max(SPIKE * scatter, LEAST_UM)
    limits = np.where(here < AT, np.inf, np.where(here < NEAR, FACTOR * limit, limit))
    beyond = np.flatnonzero(np.abs(second) > limits)
    if not beyond.size:
        return None
    at = int(beyond[np.argmax(np.abs(second[beyond]))])
    beside = np.abs(second[max(at - 1, 0) : at + 2 : 2]) if at else np.abs(second[1:2])
    if beside.max() > BESIDE * abs(second[at]):
        return None
    return Jump(at + 1, float(-0.5 * second[at]), float(np.mod(turn.angle[at + 1], 2.0 * math.pi)), True, scatter)


def _steps(values: Floats, m: int) -> Floats:
    """Mean of the next ``m`` less mean of the last ``m``, between all neighbours that have so many."""
    sums = np.concatenate(([0.0], np.cumsum(values - values[0])))
    return np.asarray((sums[2 * m :] - 2.0 * sums[m:-m] + sums[: -2 * m]) / m)


def _least(values: Floats, m: int) -> Floats:
    """The least of the ``2 m`` values around each place of :func:`_steps`."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(values, 2 * m).min(axis=1))


def _along(angle: Floats, radius_um: float) -> tuple[Floats, np.ndarray]:
    """The path along the circle less that at the local speed, um, and which points are at the usual speed."""
    from scipy.ndimage import median_filter, minimum_filter1d, uniform_filter1d

    step = np.diff(angle)
    half = min(max(WIDE, 25 * window(angle)), step.size // 16)
    local = median_filter(step, size=2 * half + 1, mode="nearest")
    many = np.round(step / np.where(local > 0.0, local, np.inf))
    sigma = noise(angle)
    whole = (many != 1.0) & (np.abs(step - many * local) < 0.25 * local) & (local > CLEAR * sigma)
    path = np.concatenate(([0.0], np.cumsum(np.where(whole, local, step))))
    rate = speed(path, max(half // 2, 1))
    usual = float(np.median(rate))
    even = (np.abs(rate / usual - 1.0) < STEADY).astype(float)
    steady = minimum_filter1d(even, 2 * half + 1, mode="constant")
    return radius_um * (path - uniform_filter1d(path, 2 * half + 1, mode="nearest")), steady > 0.0


def _scatter(values: Floats) -> float:
    return SCALED * float(np.median(np.abs(values - np.median(values)))) if values.size else 0.0


def gap_um(turn: Turn) -> float:
    """By how much the radius of the last point differs from the first; 0 where that is no more than between neighbours.

    Where a turn starts at a reversal, play makes a step of it: ten times as much is then allowed.
    """
    radii = 1000.0 * np.hypot(turn.x_mm, turn.y_mm)
    limit = max(SPIKE * _scatter(np.diff(radii)), LEAST_UM)
    start = abs(math.remainder(float(turn.angle[0]), 0.5 * math.pi))
    gap = abs(float(radii[-1] - radii[0]))
    return gap if gap > (FACTOR * limit if start < NEAR else limit) else 0.0
