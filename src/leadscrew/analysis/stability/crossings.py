"""Where a loop's Nyquist curve crosses the real axis or the unit circle, refined to the last digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from leadscrew.analysis.stability.grid import own_grid
from leadscrew.analysis.stability.linear import LinearLoop

Response = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Crossing:
    """A frequency in rad/s, and the real part there (phase crossover) or the phase margin in rad (gain crossover)."""

    w: float
    value: float


def phase_crossings(loop: LinearLoop, w: np.ndarray | None = None, positive: bool = False) -> list[Crossing]:
    """Every crossing of the negative real axis: ``Im G = 0``, ``Re G < 0``, by rising frequency.

    ``positive`` adds those of the positive one, where a negative gain makes the loop oscillate.

    A sampled loop is real at half its sampling rate; a crossing there counts, being where a gain makes a pole leave at
    ``z = -1``. At frequency 0, where a curve begins, a negative ``G(0)`` counts likewise.
    """
    w = own_grid(loop).w if w is None else w
    found = [c for c in crossings_of(loop.response, w, positive) if not _on_a_pole(loop, c.w)]
    if loop.dt is not None:
        last = complex(loop.response(np.array([loop.nyquist]))[0])
        if (last.real < 0.0 or positive) and all(abs(c.w - loop.nyquist) > 1e-9 * loop.nyquist for c in found):
            found.append(Crossing(loop.nyquist, last.real))
    at = 1.0 if loop.dt is not None else 0.0
    poles = np.linalg.eigvals(loop.a)
    if np.all(np.abs(poles - at) > 1e-12):
        rest = complex(loop.response(np.array([0.0]))[0]).real
        if rest < 0.0 or (positive and rest > 0.0):
            found.insert(0, Crossing(0.0, rest))
    return found


def crossings_of(response: Response, w: np.ndarray, positive: bool = False) -> list[Crossing]:
    """Crossings of the negative real axis of any response, bracketed on ``w`` and refined."""
    g = response(w)
    found = []
    near = positive | (np.minimum(g.real[:-1], g.real[1:]) < 0.0)
    for i in np.nonzero((np.sign(g.imag[:-1]) != np.sign(g.imag[1:])) & near)[0]:
        at = _root(lambda x: float(response(np.array([x]))[0].imag), float(w[i]), float(w[i + 1]))
        value = complex(response(np.array([at]))[0])
        if (value.real < 0.0 or (positive and value.real > 0.0)) and abs(value.imag) <= 1e-6 * abs(value):
            found.append(Crossing(at, value.real))
    return found


def gain_crossings(loop: LinearLoop, w: np.ndarray | None = None) -> list[Crossing]:
    """Every crossing of the unit circle, with the phase margin there in rad (0 .. 2 pi)."""
    w = own_grid(loop).w if w is None else w
    over = np.log(np.abs(loop.response(w)))
    found = []
    for i in np.nonzero(np.sign(over[:-1]) != np.sign(over[1:]))[0]:
        at = _root(lambda x: float(np.log(np.abs(loop.response(np.array([x]))[0]))), float(w[i]), float(w[i + 1]))
        angle = float(np.angle(loop.response(np.array([at]))[0]))
        found.append(Crossing(at, (angle + np.pi) % (2.0 * np.pi)))
    return found


def _on_a_pole(loop: LinearLoop, w: float) -> bool:
    """Whether the curve only changes sign there because it passes through infinity."""
    return any(abs(w - f) <= 1.001 * near for f, near in loop.undamped)


def _root(f: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    if f(low) == 0.0:
        return low
    if f(high) == 0.0:
        return high
    return float(brentq(f, low, high, xtol=1e-12 * high, rtol=1e-14))
