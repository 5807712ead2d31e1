"""The centroid in closed form, of sets with straight sides that are cut off (minimum) or scaled (product) and united
by the maximum.

**A triangular partition** on exactly its universe: between two neighbouring peaks only their two sets stand, and the
larger of two is their sum less the smaller. With ``t`` from 0 to 1 between the peaks and degrees ``h`` and ``k``

    cut off:  area of min(h, 1 - t) = h - h^2/2,  moment about the peak = h (3 - 3 h + h^2)/6,
              min of both = min(m, t, 1 - t) with m = min(h, k, 1/2): area m (1 - m), centre 1/2
    scaled:   area h/2,  moment h/6,
              min of both: a triangle, area h k/(2 (h + k)), centre (1 + h/(h + k))/3

**Anything else**: the universe is split where a side begins or ends; in each part the sets are lines, and the walk goes
along the uppermost from crossing to crossing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadscrew.fuzzy.shapes import STRAIGHT, membership, prepared
from leadscrew.fuzzy.system import Output, Term
from leadscrew.kernel.guards import unguarded

NEAR = 1e-11
"""Crossings closer together than this part of an interval are one."""


# ---- steps
def cut_area(h):
    """Area of one side of a set that is cut off, as a part of the side's width."""
    return h - 0.5 * h * h


def cut_moment(h):
    """Moment of one side about its peak, as a part of the width squared."""
    return h * (3.0 - 3.0 * h + h * h) * 0.16666666666666666


def shared_cut(h, k):
    """Area under both of two neighbours that are cut off."""
    low = h if h < k else k
    m = low if low < 0.5 else 0.5
    return m * (1.0 - m)


def shared_scaled(h, k):
    """Area under both of two neighbours that are scaled."""
    both = h + k
    return 0.5 * h * k / (both if both > 0.0 else 1.0)


def centre_scaled(h, k):
    """Where the centre of that area lies between the two peaks."""
    both = h + k
    return (1.0 + h / (both if both > 0.0 else 1.0)) * 0.3333333333333333


@unguarded
def along(breaks, left, right, rows, degrees, cut):
    """Area and moment under the uppermost of several sets; ``cut``: 1 where they are cut off, 0 where scaled."""
    area, moment = 0.0, 0.0
    for k in range(breaks.shape[0] - 1):
        width, t = breaks[k + 1] - breaks[k], 0.0
        for _ in range(6 * degrees.shape[0] + 4):
            if t < 1.0:
                best, top, slope, value = -1.0, 0, 0.0, 0.0
                for i in range(degrees.shape[0]):
                    y, s = height_at(left[rows[i], k], right[rows[i], k], degrees[i], cut, t)
                    higher = y + NEAR * s > best
                    top = i if higher else top
                    slope = s if higher else slope
                    value = y if higher else value
                    best = y + NEAR * s if higher else best
                step = 1.0 - t
                for i in range(degrees.shape[0]):
                    y, s = height_at(left[rows[i], k], right[rows[i], k], degrees[i], cut, t)
                    line = left[rows[i], k] + (right[rows[i], k] - left[rows[i], k]) * t
                    rise = right[rows[i], k] - left[rows[i], k]
                    # where this one's line meets its cut, and where it comes up from below
                    bend = (degrees[i] - line) / (rise if rise != 0.0 else 1.0)
                    step = bend if cut == 1 and rise != 0.0 and NEAR < bend < step else step
                    faster = s - slope
                    meet = (value - y) / (faster if faster > 0.0 else 1.0)
                    step = meet if faster > 0.0 and NEAR < meet < step else step
                end = value + slope * step
                part = 0.5 * (value + end) * step
                area = area + width * part
                inner = step * step * (value + 2.0 * end) * 0.16666666666666666
                moment = moment + width * (part * (breaks[k] + width * t) + width * inner)
                t = t + step if 1.0 - t - step > NEAR else 1.0
    return area, moment


def height_at(a, b, degree, cut, t):
    """Height at ``t``, and slope from there on, of a line from ``a`` to ``b`` under a degree."""
    line, rise = a + (b - a) * t, b - a
    over = line + NEAR * rise > degree
    y = (degree if line > degree else line) if cut == 1 else degree * line
    s = (0.0 if over else rise) if cut == 1 else degree * rise
    return y, s


# ---- preparation
def is_straight(term: Term) -> bool:
    """Whether a set has straight sides only."""
    return term.shape in (*STRAIGHT, "discrete")


def corners(term: Term) -> list[float]:
    """Where the sides of a set begin and end."""
    if term.shape == "discrete":
        return list(term.parameters[::2])
    return list(prepared(term.shape, term.parameters)[:4])


def prepare_lines(output: Output, terms: Sequence[Term]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The ends of the intervals on which all sets are lines, and each set at the two ends of each, from inside."""
    low, high = output.low, output.high
    inner = {x for t in terms if is_straight(t) for x in corners(t) if low < x < high}
    breaks = np.array(sorted({low, high} | inner))
    left, right = np.zeros((len(terms), len(breaks) - 1)), np.zeros((len(terms), len(breaks) - 1))
    for row, term in enumerate(terms):
        for k in range(len(breaks) - 1):
            width = breaks[k + 1] - breaks[k]
            a, b = (membership(term, breaks[k] + width * f) for f in (1.0 / 3.0, 2.0 / 3.0))
            left[row, k], right[row, k] = 2.0 * a - b, 2.0 * b - a
    return breaks, left, right


def prepare_partition(output: Output, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Numbers of each set and each interval of a partition that just fills its universe; ``None`` where it does not.

    A set: width of its sides, that times its peak, difference of their squares, width of its level part, that times
    its middle. An interval: width, that times its middle, lower peak, width squared.
    """
    starts, ends = sides[0], sides[2]
    peaks = [*starts[1:-1], ends[-2]]
    count = len(peaks)
    left, right = peaks[0] - output.low, output.high - peaks[-1]
    level = [starts[0] == -np.inf or ends[0] < peaks[0], starts[-1] == np.inf or starts[-1] > peaks[-1]]
    if left < 0.0 or right < 0.0:
        return None
    for width, flat, foot, end in (
        (left, starts[0] == -np.inf, starts[0], output.low),
        (right, starts[-1] == np.inf, ends[-1], output.high),
    ):
        if width > 0.0 and not flat and foot != end:
            return None
    if (level[0] and starts[0] != -np.inf) or (level[1] and starts[-1] != np.inf):
        return None
    widths = np.diff(peaks)
    outer = [0.0 if level[0] else left, *widths, 0.0 if level[1] else right]
    sets, between = np.zeros((count, 5)), np.zeros((count - 1, 4))
    for i, c in enumerate(peaks):
        both = outer[i] + outer[i + 1]
        sets[i, :3] = both, both * c, outer[i + 1] ** 2 - outer[i] ** 2
    if level[0]:
        sets[0, 3:] = left, left * 0.5 * (output.low + peaks[0])
    if level[1]:
        sets[-1, 3:] += right, right * 0.5 * (output.high + peaks[-1])
    for k, w in enumerate(widths):
        between[k] = w, w * 0.5 * (peaks[k] + peaks[k + 1]), peaks[k], w * w
    return sets, between
