"""The Tsypkin criterion: a sampled loop with a static monotone nonlinearity in a sector.

    Re[(1 + q (1 - 1/z)) G1] + 1 / (k2 - k1) > 0,    q >= 0        on abs(z) = 1,    G1 = G / (1 + k1 G) stable
    Re[(1 + p (1 - z)) G1] + 1 / (k2 - k1) > 0,      q = -p < 0

For every time-invariant ``phi`` in ``[k1, k2]`` whose slope is nowhere below ``k1``; the slope has no upper bound.
For ``q >= 0`` the proof rests on ``F(e_k) - F(e_(k-1)) <= phi(e_k) (e_k - e_(k-1))`` with the convex
``F = integral of phi``: Y. Z. Tsypkin, *Automatika i Telemekhanika* 1964; state-space proof: V. Kapila, W. M. Haddad,
IEEE Trans. Automatic Control 41 (1996) 149. For ``q < 0`` it is the multiplier of R. O'Shea and M. I. Younis, IEEE
Trans. Automatic Control 12 (1967) 725. With an integrator and ``k1 = 0``, ``q >= 0``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.criterion import ROUNDS, Question, ask, best, limit_of, outcome
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.criterion import Best
    from leadscrew.analysis.stability.lure import Lure


def tsypkin(
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    q: float | None = None,
    nonlinearity: Lure | None = None,
    grid: Any = None,
) -> Certificate:
    """The Tsypkin certificate of a sector, or the largest one from ``k1`` on where ``k2`` is not given.

    Arguments as of :func:`~leadscrew.analysis.stability.circle.circle`; ``q`` is the multiplier, the best one where not
    given.

    Raises:
        ValueRefused: a continuous loop; bounds out of order.
    """
    if not loop.sampled:
        raise ValueRefused(f"tsypkin: the loop {loop.name!r} is continuous; ask popov, which is its continuous kin")
    asked = ask("Tsypkin", loop, k1, k2, nonlinearity, grid)
    slopes = None if nonlinearity is None else nonlinearity.slope_sector
    if not asked.refusal and slopes is not None and slopes[0] < asked.k1 - 1e-9:
        asked.refusal = (
            f"The slope of the nonlinearity falls to {slopes[0]:.4g}, below the sector's lower bound of {asked.k1:g}: "
            "Tsypkin's criterion asks for a slope nowhere below it."
        )
    if asked.critical and q is not None and q < 0.0:
        asked.refusal = asked.refusal or (
            f"q = {q:g}: with an integrator in the loop and a sector from 0 the multiplier must not be negative."
        )
    if asked.refusal:
        return asked.refused()
    found, signed = sided(asked, q, _lines)
    data = {"loop": loop, "lines": (lambda w: _lines(asked, w, 1.0 if signed >= 0.0 else -1.0)), "size": abs(signed)}
    which = f", time-invariant, with a slope nowhere below {asked.k1:g}"
    return outcome(asked, found, which, signed, data, "condition")


def _lines(asked: Question, w: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray]:
    g = asked.response(w)
    z = np.exp(1j * w * float(asked.loop.dt or 0.0))
    return -g.real, -((1.0 - (1.0 / z if sign > 0.0 else z)) * g).real


def sided(asked: Question, q: float | None, lines: Any, rounds: int = ROUNDS) -> tuple[Best, float]:
    """The better of the multipliers of both signs, each searched by its size; the best and its ``q`` with sign."""
    signs = (1.0, -1.0) if q is None else (1.0 if q >= 0.0 else -1.0,)
    if asked.critical:
        signs = (1.0,)
    found = []
    for sign in signs:
        size = None if q is None else abs(q)
        one = best(lambda w, s=sign: lines(asked, w, s), asked.grid.w, size, 0.0, math.inf, 1.0, (), rounds)  # type: ignore[misc]
        found.append((one, sign * one.q))
    return max(found, key=lambda f: limit_of(asked.k1, f[0].m))
