"""The Zames-Falb criterion: a sampled loop with a static, odd nonlinearity of bounded slope in a sector.

    Re[(1 + M(z)) G1] + 1 / (k2 - k1) + Re M(z) / s > 0     on abs(z) = 1,      G1 = G / (1 + k1 G) stable
    M(z) = sum_i [q_i (1 - z^-i) + p_i (1 + z^-i)],         q_i, p_i >= 0,   i = -taps .. -1, 1 .. taps

For every time-invariant odd ``phi`` in ``[k1, k2]`` with ``k1 <= phi' <= s2``, ``s = s2 - k1`` (no last term where the
slope has no upper bound). It rests on ``sum_k f_k g_k >= |sum_k f_k g_(k-i)|`` for ``f`` an odd monotone function of
``g``: R. O'Shea, M. I. Younis, IEEE Trans. Automatic Control 12 (1967) 725; J. C. Willems, R. W. Brockett, IEEE Trans.
Automatic Control 13 (1968) 503. Tsypkin's criterion is the case of one tap. The multiplier of most reach is a linear
program: at each frequency the left side is linear in the ``q_i``, ``p_i`` and ``1 / (k2 - k1)``. It is solved on a few
frequencies, checked on the loop's grid, and solved again with the worst of those, until none is left.

The limit is the largest ``k2`` that is proved for slopes of at most ``max(s2, k2)``: with the slope as it is up to
``k2 = s2``; beyond, where a map of slope ``s2`` has no such ``k2``, the slope is taken to grow with the sector. It is
then what the map may be multiplied by, never less than the limit of the circle.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.criterion import Question, ask, best, limit_of, outcome
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure

TAPS = 10
"""Delays of the multiplier to either side, in periods: twice as many gain 0.2 % on the loop L* of the XY table."""
FIRST = 200
WORST = 20
ROUNDS = 30
EDGE = 1e-6
"""Below the Nyquist limit by this, relative: at it no condition holds."""
NEAR = 1e-4
"""How exactly a limit beyond the slope is searched, relative."""
LARGEST = 1e4
"""Bound of the multiplier's coefficients: beyond it their differences are rounding."""
SMALL = 1e-6
"""What a coefficient costs, against ``1 / (k2 - k1)``: of multipliers of the same reach the smallest."""


def zames_falb(
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    slope: float = math.inf,
    nonlinearity: Lure | None = None,
    grid: Any = None,
    taps: int = TAPS,
) -> Certificate:
    """The Zames-Falb certificate of a sector, or the largest one from ``k1`` on where ``k2`` is not given.

    Args:
        loop: sampled, cut at the error.
        k1: lower bound of the sector and of the slope; that of ``nonlinearity`` where not given, else 0.
        k2: upper bound; that of ``nonlinearity`` where not given, else as large as can be proved.
        slope: upper bound of the slope; that of ``nonlinearity`` where given. A limit beyond it lets the slope grow
            with the sector.
        nonlinearity: checked against the sector and the slopes.
        grid: frequencies in rad/s; the loop's own where not given.
        taps: delays of the multiplier to either side.

    Raises:
        ValueRefused: a continuous loop; bounds out of order; a slope that is not above ``k1``; no taps.
    """
    if not loop.sampled:
        raise ValueRefused(f"zames_falb: the loop {loop.name!r} is continuous; ask popov")
    if taps < 1:
        raise ValueRefused(f"zames_falb: taps = {taps!r}; allowed from 1")
    asked = ask("Zames-Falb", loop, k1, k2, nonlinearity, grid)
    if nonlinearity is not None and nonlinearity.slope_sector is not None and not asked.refusal:
        lowest, slope = (float(x) for x in nonlinearity.slope_sector)
        e = np.geomspace(1e-9, 1e3, 241)
        if lowest < asked.k1 - 1e-9:
            asked.refusal = (
                f"The slope of the nonlinearity falls to {lowest:.4g}, below the sector's lower bound of {asked.k1:g}, "
                "which the criterion asks the slope to keep to."
            )
        elif not np.allclose(nonlinearity.curve(-e), -np.asarray(nonlinearity.curve(e)), rtol=1e-9, atol=0.0):
            asked.refusal = "The nonlinearity is not odd, which the multiplier of Zames and Falb asks for."
    if not slope > asked.k1:
        raise ValueRefused(f"zames_falb: slope = {slope!r}: allowed above {asked.k1:g}, the sector's lower bound")
    if asked.critical:
        asked.refusal = asked.refusal or (
            "With an integrator in the loop the sector has to start above 0 for the multiplier of Zames and Falb."
        )
    if asked.refusal:
        return asked.refused()
    steepest = _steepest(asked, slope, taps)
    weights = _solved(asked, steepest, taps)

    def lines(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, columns = _condition(asked, w, steepest, taps)
        return r + columns @ weights, np.zeros(len(w))

    found = best(lines, asked.grid.w, 0.0, 0.0, 0.0, 1.0)
    if steepest > slope and limit_of(asked.k1, found.m) > steepest:
        found = replace(found, m=1.0 / (steepest - asked.k1))
    bound = "" if math.isinf(slope) else f" and at most {steepest if asked.k2 is None else slope:.4g}"
    which = f", time-invariant and odd, with a slope of at least {asked.k1:g}{bound}"
    data = {"loop": loop, "lines": lines, "size": 0.0, "taps": taps, "weights": weights, "slope": steepest}
    return outcome(asked, found, which, None, data, "condition")


def _steepest(asked: Question, slope: float, taps: int) -> float:
    """The slope to prove the limit with: ``slope``, or the largest proved for sector and slope alike, if more."""
    if slope >= asked.nyquist or not _reaches(asked, slope, taps):
        return slope
    low, high = slope, asked.nyquist
    if math.isinf(high):
        return slope
    if _reaches(asked, high * (1.0 - EDGE), taps):
        return high * (1.0 - EDGE)
    while high - low > NEAR * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _reaches(asked, middle, taps) else (low, middle)
    return low


def _reaches(asked: Question, slope: float, taps: int) -> bool:
    """Whether the sector is proved up to the slope, on the grid as it is."""
    r, columns = _condition(asked, asked.grid.w, slope, taps)
    m = float((r + columns @ _solved(asked, slope, taps)).max())
    return limit_of(asked.k1, m) >= slope * (1.0 - 1e-9)


def _condition(asked: Question, w: np.ndarray, slope: float, taps: int) -> tuple[np.ndarray, np.ndarray]:
    """``-Re G1``, and what each of the multiplier's coefficients adds to it."""
    g = asked.response(w)
    late = np.concatenate([np.arange(-taps, 0), np.arange(1, taps + 1)])
    turned = np.exp(-1j * np.outer(w * float(asked.loop.dt or 0.0), late))
    seen = (g + (0.0 if math.isinf(slope) else 1.0 / (slope - asked.k1)))[:, None]
    return -g.real, -np.hstack([((1.0 - turned) * seen).real, ((1.0 + turned) * seen).real])


def _solved(asked: Question, slope: float, taps: int) -> np.ndarray:
    """The coefficients of the linear program's multiplier."""
    from scipy.optimize import linprog

    w = asked.grid.w
    r, columns = _condition(asked, w, slope, taps)
    count = columns.shape[1]
    used = np.unique(np.linspace(0, len(w) - 1, FIRST).astype(int))
    weights = np.zeros(count)
    # no sector reaches beyond the Nyquist limit, nor beyond the largest slope
    least = 1.0 / (min(asked.nyquist, slope) - asked.k1)
    bounds = [(0.0, LARGEST)] * count + [(least, None)]
    for _ in range(ROUNDS):
        rows = np.hstack([columns[used], -np.ones((len(used), 1))])
        cost = np.append(np.full(count, SMALL), 1.0)
        solved = linprog(cost, A_ub=rows, b_ub=-r[used], bounds=bounds, method="highs")
        if solved.x is None:
            break
        weights, m = solved.x[:count], float(solved.x[count])
        h = r + columns @ weights
        if h.max() <= m + 1e-9 * (1.0 + abs(m)):
            break
        used = np.union1d(used, np.argsort(-h)[:WORST])
    return np.asarray(weights)
