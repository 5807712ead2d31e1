"""From an output's set to a number.

Integral defuzzifiers work on ``mu``, the membership of the aggregated set at the nodes ``x`` of the rule of
integration (``mu`` and ``x`` are padded with zeros and the last node to a multiple of four, ``count`` nodes count):

- ``midpoint``: the centres of ``resolution`` cells, as fuzzylite has it;
- ``trapezoid``: the ``resolution + 1`` ends of the cells, as Octave and MATLAB have it.

Sums go over four interleaved parts that are added last: the same order on every engine, and one that vectorises.
An area of zero under rules that fire (a set outside its universe) gives NaN.
"""

from __future__ import annotations

from leadscrew.kernel.guards import unguarded
from leadscrew.kernel.portable import log, sqrt

NAN = float("nan")


@unguarded
def centroid(mu, x, count, low, high):
    """Centre of area by the midpoint rule."""
    a0, a1, a2, a3, m0, m1, m2, m3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(0, count, 4):
        a0 = a0 + mu[i]
        a1 = a1 + mu[i + 1]
        a2 = a2 + mu[i + 2]
        a3 = a3 + mu[i + 3]
        m0 = m0 + mu[i] * x[i]
        m1 = m1 + mu[i + 1] * x[i + 1]
        m2 = m2 + mu[i + 2] * x[i + 2]
        m3 = m3 + mu[i + 3] * x[i + 3]
    return ((m0 + m1) + (m2 + m3)) / ((a0 + a1) + (a2 + a3))


@unguarded
def centroid_trapezoid(mu, x, count, low, high):
    """Centre of area by the trapezoid rule: the first and the last node count half."""
    last = count - 1
    mu[0] = 0.5 * mu[0]
    mu[last] = 0.5 * mu[last]
    return centroid(mu, x, count, low, high)


@unguarded
def bisector(mu, x, count, low, high):
    """Where two areas meet that grow cell by cell from both ends, the smaller first; between their last cells."""
    left, right, at, end = 0.0, 0.0, 0, count - 1
    a, b = low, high
    for _ in range(count):
        if left <= right:
            a = x[at]
            left = left + mu[at]
            at = at + 1
        else:
            b = x[end]
            right = right + mu[end]
            end = end - 1
    return (left * b + right * a) / (left + right)


@unguarded
def bisector_trapezoid(mu, x, count, low, high):
    """Where the line through the nodes has half its area on either side."""
    area = 0.0
    for i in range(1, count):
        area = area + 0.5 * (mu[i - 1] + mu[i]) * (x[i] - x[i - 1])
    half, done, found = 0.5 * area, False, NAN
    for i in range(1, count):
        width = x[i] - x[i - 1]
        cell = 0.5 * (mu[i - 1] + mu[i]) * width
        if not done and half <= cell and cell > 0.0:
            # the root of mu0 t + (mu1 - mu0) t^2 / 2 = half / width that lies in the cell, without cancellation
            slope, want = mu[i] - mu[i - 1], half / width
            root = sqrt(mu[i - 1] * mu[i - 1] + 2.0 * slope * want)
            found = x[i - 1] + width * min(1.0, 2.0 * want / (mu[i - 1] + root))
            done = True
        half = half - cell
    return found


@unguarded
def smallest_of_maximum(mu, x, count, low, high):
    """The first node of the highest."""
    best, found = -1.0, NAN
    for i in range(count):
        found = x[i] if mu[i] > best else found
        best = mu[i] if mu[i] > best else best
    return found


@unguarded
def largest_of_maximum(mu, x, count, low, high):
    """The last node of the highest."""
    best, found = -1.0, NAN
    for i in range(count):
        found = x[i] if mu[i] >= best else found
        best = mu[i] if mu[i] >= best else best
    return found


@unguarded
def mean_of_maximum(mu, x, count, low, high):
    """The middle of the first plateau of the highest nodes, as fuzzylite has it."""
    best, first, last, level = -1.0, NAN, NAN, False
    for i in range(count):
        higher = mu[i] > best
        level = higher or (level and mu[i] == best)
        best = mu[i] if higher else best
        first = x[i] if higher else first
        last = x[i] if level else last
    return 0.5 * (first + last)


@unguarded
def mean_of_maximum_trapezoid(mu, x, count, low, high):
    """The mean of all the highest nodes, as Octave and MATLAB have it."""
    best, total, number = -1.0, 0.0, 0.0
    for i in range(count):
        higher, same = mu[i] > best, mu[i] == best
        best = mu[i] if higher else best
        total = x[i] if higher else (total + x[i] if same else total)
        number = 1.0 if higher else (number + 1.0 if same else number)
    return total / number


# ---- Tsukamoto: where a monotonic set has a membership
def ramp_inverse(start, end, low, high, w):
    """Where a ramp is ``w``."""
    return start + (end - start) * min(1.0, w)


def sigmoid_inverse(inflection, slope, low, high, w):
    """Where a sigmoid is ``w``; the end of the universe where that is nowhere."""
    end = high if slope > 0.0 else low
    other = low if slope > 0.0 else high
    inside = w > 0.0 and w < 1.0
    v = w if inside else 0.5
    return inflection - log(1.0 / v - 1.0) / slope if inside else (end if w >= 1.0 else other)


def s_inverse(start, end, low, high, w):
    """Where an s is ``w``."""
    v = min(1.0, w)
    rise = sqrt(0.5 * v) if v <= 0.5 else 1.0 - sqrt(0.5 * (1.0 - v))
    return start + (end - start) * rise


def z_inverse(start, end, low, high, w):
    """Where a z is ``w``."""
    return s_inverse(start, end, low, high, 1.0 - min(1.0, w))


def concave_inverse(inflection, end, low, high, w):
    """Where the hyperbola is ``w``."""
    v = min(1.0, w)
    return 2.0 * end - inflection - (end - inflection) / (v if v > 0.0 else 1.0)


INTEGRALS = {
    ("centroid", "midpoint"): centroid,
    ("centroid", "trapezoid"): centroid_trapezoid,
    ("bisector", "midpoint"): bisector,
    ("bisector", "trapezoid"): bisector_trapezoid,
    ("smallest_of_maximum", "midpoint"): smallest_of_maximum,
    ("smallest_of_maximum", "trapezoid"): smallest_of_maximum,
    ("mean_of_maximum", "midpoint"): mean_of_maximum,
    ("mean_of_maximum", "trapezoid"): mean_of_maximum_trapezoid,
    ("largest_of_maximum", "midpoint"): largest_of_maximum,
    ("largest_of_maximum", "trapezoid"): largest_of_maximum,
}
"""The step of each integral defuzzifier under each rule of integration."""
INVERSES = {
    "ramp": ramp_inverse,
    "sigmoid": sigmoid_inverse,
    "s_shape": s_inverse,
    "z_shape": z_inverse,
    "concave": concave_inverse,
}
"""The inverse of each monotonic shape."""
