"""The Popov criterion: a continuous loop with a static, time-invariant nonlinearity in a sector.

    Re[(1 + j w q) G1(jw)] + 1 / (k2 - k1) > 0 for all w >= 0,        G1 = G / (1 + k1 G) stable

for one real ``q`` of either sign: then ``e = -G phi(e)`` is absolutely stable in the sector ``[k1, k2]``. The largest
``k2`` is ``k1 + 1/m`` with ``m = min_q max_w -Re[(1 + j w q) G1]``; it is infinite where ``m <= 0``. Source: V. M.
Popov, Automation and Remote Control 22 (1961) 857; both signs and any sector: M. A. Aizerman, F. R. Gantmacher,
*Absolute Stability of Regulator Systems*, Holden-Day 1964. With an integrator and ``k1 = 0`` (the critical case) phi
must not vanish and ``q >= 0``. The limits of ``w Im G1`` at infinite frequency are part of the condition: with a dead
time and one pole more than zeros it never dies out.

It is a criterion for continuous loops. Asked of a sampled one it is answered for the continuous model of that loop, and
says so.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.envelope import best
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.outcome import outcome
from leadscrew.analysis.stability.question import ask

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure

NAME = "Popov"


def popov(
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    q: float | None = None,
    nonlinearity: Lure | None = None,
    grid: Any = None,
) -> Certificate:
    """The Popov certificate of a sector, or the largest one from ``k1`` on where ``k2`` is not given.

    Args:
        loop: cut at the error; a sampled one is replaced by its continuous model.
        k1: lower bound of the sector; that of ``nonlinearity`` where not given, else 0.
        k2: upper bound; that of ``nonlinearity`` where not given, else as large as can be proved.
        q: multiplier in s; the best one where not given.
        nonlinearity: checked against the sector.
        grid: frequencies in rad/s; the loop's own where not given.

    Raises:
        ValueRefused: bounds out of order; a sampled loop that has no continuous model.
    """
    notes: list[str] = []
    if loop.sampled:
        from leadscrew.analysis.stability.continuous_model import continuous_model

        name, loop = loop.name, continuous_model(loop)
        notes.append(
            "Popov is a criterion for continuous loops: what is proved is proved for the continuous model of "
            f"{name!r}, not for the loop as it is sampled; for that one ask circle, tsypkin or jury_lee."
        )
    asked = ask(NAME, loop, k1, k2, nonlinearity, grid)
    asked.warnings = [*notes, *asked.warnings]
    if asked.critical and q is not None and q < 0.0:
        asked.refusal = asked.refusal or (
            f"q = {q:g} s: with an integrator in the loop and a sector from 0 the multiplier must not be negative."
        )
    if asked.refusal:
        return asked.refused()

    def lines(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        g = asked.response(w)
        return -g.real, w * g.imag

    lead = float((loop.c @ loop.b)[0, 0])
    ends = [(-float(loop.d[0, 0]) / (1.0 + asked.k1 * float(loop.d[0, 0])), -lead)]
    if loop.dead_time:
        ends.append((0.0, lead))
    poles = np.abs(loop.closed_poles(asked.k1 if asked.k1 else 1.0))
    unit = 1.0 / float(poles.max())
    found = best(lines, asked.grid.w, q, 0.0 if asked.critical else -math.inf, math.inf, unit, tuple(ends))
    from leadscrew.analysis.stability.plot import popov_plot

    data = {"q_s": found.q, "response": asked.response, "loop": loop}
    return outcome(asked, found, " that does not change with time", found.q, data, popov_plot)
