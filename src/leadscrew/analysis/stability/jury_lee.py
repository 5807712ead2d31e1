"""The Jury-Lee criterion: a sampled loop with a static nonlinearity in a sector whose slope has an upper bound.

    Re[(1 + q (z - 1)) G1] + 1 / (k2 - k1) - (q s / 2) abs((z - 1) G1)^2 > 0      on abs(z) = 1, for one q >= 0
    Re[(1 + p (1/z - 1)) G1] + 1 / (k2 - k1) - (p s / 2) abs((z - 1) G1)^2 > 0    or for one q = -p < 0

``G1 = G / (1 + k1 G)`` stable, ``s = s2 - k1``, ``phi`` time-invariant with ``phi' <= s2``; the slope has no lower
bound. It rests on ``phi(a)(b - a) >= F(b) - F(a) - s/2 (b - a)^2`` with ``F = integral of phi``. Source: E. I. Jury,
B. W. Lee, IEEE Trans. Automatic Control 9 (1964) 51. With an integrator and ``k1 = 0``, ``q >= 0``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.criterion import Question, ask, limit_of, outcome
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.tsypkin import sided
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure

HALVINGS = 40


def jury_lee(
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    slope: float | None = None,
    q: float | None = None,
    nonlinearity: Lure | None = None,
    grid: Any = None,
) -> Certificate:
    """The Jury-Lee certificate of a sector, or the largest one from ``k1`` on where ``k2`` is not given.

    Arguments as of :func:`~leadscrew.analysis.stability.tsypkin.tsypkin`; ``slope`` is the upper bound ``s2`` of the
    slope, that of ``nonlinearity`` where not given, else ``k2`` (the slope keeps to the sector too).

    Raises:
        ValueRefused: a continuous loop; bounds out of order; a slope below ``k1``.
    """
    if not loop.sampled:
        raise ValueRefused(f"jury_lee: the loop {loop.name!r} is continuous; ask popov, which is its continuous kin")
    asked = ask("Jury-Lee", loop, k1, k2, nonlinearity, grid)
    slopes = None if nonlinearity is None else nonlinearity.slope_sector
    if slope is None:
        slope = asked.k2 if slopes is None else float(slopes[1])
    elif slopes is not None and slopes[1] > slope + 1e-9:
        asked.refusal = asked.refusal or (
            f"The slope of the nonlinearity reaches {slopes[1]:.4g}, above the bound of {slope:g} that was asked for."
        )
    if slope is not None and not slope >= asked.k1:
        raise ValueRefused(f"jury_lee: slope = {slope!r}: allowed from {asked.k1:g}, the sector's lower bound")
    if asked.critical and q is not None and q < 0.0:
        asked.refusal = asked.refusal or (
            f"q = {q:g}: with an integrator in the loop and a sector from 0 the multiplier must not be negative."
        )
    if asked.refusal:
        return asked.refused()
    bound = slope if slope is not None else _widest(asked, q)
    found, signed = sided(asked, q, _with(bound))
    sign = 1.0 if signed >= 0.0 else -1.0
    data = {"loop": loop, "slope": bound, "lines": (lambda w: _with(bound)(asked, w, sign)), "size": abs(signed)}
    return outcome(asked, found, f", time-invariant, with a slope of at most {bound:.4g}", signed, data, "condition")


def _with(slope: float) -> Any:
    def lines(asked: Question, w: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray]:
        g = asked.response(w)
        z = np.exp(1j * w * float(asked.loop.dt or 0.0))
        turned = z - 1.0 if sign > 0.0 else 1.0 / z - 1.0
        return -g.real, -(turned * g).real + 0.5 * (slope - asked.k1) * np.abs((z - 1.0) * g) ** 2

    return lines


def _widest(asked: Question, q: float | None) -> float:
    """The largest bound of sector and slope alike, by halving, on the grid as it is."""
    low, high = asked.k1, asked.nyquist if math.isfinite(asked.nyquist) else asked.k1 + 1e6
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if limit_of(asked.k1, sided(asked, q, _with(middle), rounds=1)[0].m) > middle:
            low = middle
        else:
            high = middle
        if high - low <= 1e-7 * high:
            break
    return low
