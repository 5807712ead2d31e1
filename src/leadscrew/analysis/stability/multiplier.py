"""The best multiplier of a frequency condition, on a grid that grows where the condition is tightest.

A criterion asks that ``h(w, q) = r(w) + q s(w)`` stays below ``1 / (k2 - k1)`` at all frequencies. As the largest of
straight lines in ``q``, ``max_w h`` is convex: its smallest value is at the sign change of the active line's slope,
and is the best that the criterion can give.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Lines = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Frequencies to intercepts ``r`` and slopes ``s``."""

ROUNDS = 20
HALVINGS = 200
SETTLED = 1e-9
"""Relative change of the condition's value at which refinement stops."""
WIDEST = 1e6
"""Largest multiplier tried, in units of the first step."""


@dataclass(frozen=True)
class Best:
    """The smallest ``m = max_w (r + q s)`` and where it is taken."""

    m: float
    q: float
    at: float
    """Frequency of the tightest point, rad/s; infinity for the limit at high frequency."""
    w: np.ndarray
    """The grid as it ended."""
    added: int
    settled: bool
    """Whether the maximum was bracketed: finer grids no longer change it."""


def best(
    lines: Lines,
    w: np.ndarray,
    q: float | None,
    low: float,
    high: float,
    unit: float,
    limits: tuple[tuple[float, float], ...] = (),
    rounds: int = ROUNDS,
) -> Best:
    """The best multiplier between ``low`` and ``high`` (or the given ``q``), on a grid refined around every maximum.

    ``limits`` are the ``(r, s)`` towards which the condition goes at infinite frequency; ``unit`` is the size of a
    multiplier that changes something, where the search starts; ``rounds`` of 1 leaves the grid as it is.
    """
    start = len(w)
    end_r, end_s = (np.array([x[k] for x in limits]) for k in (0, 1))
    r, s = lines(w)
    last = np.nan
    settled = False
    for left in range(rounds, 0, -1):
        every_r, every_s = np.append(r, end_r), np.append(s, end_s)
        chosen = q if q is not None else best_multiplier(every_r, every_s, low, high, unit)
        h = every_r + chosen * every_s
        m = float(h.max())
        if abs(m - last) <= SETTLED * max(abs(m), abs(last)):
            settled = True
            break
        if left == 1:
            break
        last = m
        new = _between(w, h[: len(w)])
        more_r, more_s = lines(new)
        w, r, s = np.append(w, new), np.append(r, more_r), np.append(s, more_s)
        order = np.argsort(w)
        w, r, s = w[order], r[order], s[order]
    k = int(np.argmax(h))
    return Best(m, float(chosen), float(w[k]) if k < len(w) else np.inf, w, len(w) - start, settled)


def best_multiplier(r: np.ndarray, s: np.ndarray, low: float, high: float, unit: float) -> float:
    """The ``q`` of the smallest ``max(r + q s)``, or one where that is already below 0."""

    def look(q: float) -> tuple[float, float]:
        h = r + q * s
        k = int(np.argmax(h))
        return float(h[k]), float(s[k])

    a = b = float(np.clip(0.0, low, high))
    value, slope = look(a)
    if value < 0.0 or slope == 0.0:
        return a
    step = unit if slope < 0.0 else -unit
    while True:
        b = float(np.clip(b + step, low, high))
        value, slope = look(b)
        if value < 0.0 or slope * step >= 0.0:
            break
        if b in (low, high) or abs(b) > WIDEST * unit:
            return b
        a, step = b, 2.0 * step
    if value < 0.0:
        return b
    for _ in range(HALVINGS):
        middle = 0.5 * (a + b)
        value, slope = look(middle)
        if value < 0.0 or slope == 0.0 or middle in (a, b):
            return middle
        if slope * step < 0.0:
            a = middle
        else:
            b = middle
    return 0.5 * (a + b)


def _between(w: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Points on both sides of every maximum that comes near the largest."""
    inner = np.arange(1, len(w) - 1)
    tops = inner[(h[inner] >= h[inner - 1]) & (h[inner] >= h[inner + 1])]
    span = float(h.max() - np.median(h)) + 1e-300
    tops = tops[h[tops] > h.max() - 0.1 * span]
    tops = np.unique(np.append(tops[np.argsort(-h[tops])][:40], int(np.argmax(h))))
    points = [np.zeros(0)]
    for k in tops:
        for i, j in ((max(k - 1, 0), k), (k, min(k + 1, len(w) - 1))):
            if w[j] > w[i]:
                points.append(w[i] + (w[j] - w[i]) * np.array([0.1, 0.25, 0.5, 0.75, 0.9]))
    return np.setdiff1d(np.concatenate(points), w)


def highest(f: Callable[[np.ndarray], np.ndarray], w: np.ndarray) -> tuple[float, float]:
    """The largest value of a function on a refined grid, and its frequency."""
    tightest = best(lambda x: (f(x), np.zeros(len(x))), w, 0.0, 0.0, 0.0, 1.0)
    return tightest.m, tightest.at


def limit_of(k1: float, m: float) -> float:
    """``k1 + 1/m``; infinite where ``m`` is not positive."""
    return k1 + 1.0 / m if m > 0.0 else math.inf
