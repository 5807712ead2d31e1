"""The circle criterion: a nonlinearity in a sector, static or varying with time, in a continuous or a sampled loop.

    Re G1 + 1 / (k2 - k1) > 0 at all frequencies,        G1 = G / (1 + k1 G) stable

In the Nyquist plane: the curve of ``G`` keeps out of the circle over the diameter from ``-1/k1`` to ``-1/k2`` (and goes
round it as often as it must). Source: G. Zames, IEEE Trans. Automatic Control 11 (1966) 465; sampled: Y. Z. Tsypkin,
Automation and Remote Control 24 (1963). On the sector of the *slope* it is a proof for the loop under load and on the
move, see :mod:`leadscrew.analysis.stability.driven`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.criterion import ask, best, outcome
from leadscrew.analysis.stability.linear import LinearLoop

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure


def circle(
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    nonlinearity: Lure | None = None,
    grid: Any = None,
) -> Certificate:
    """The circle certificate of a sector, or the largest one from ``k1`` on where ``k2`` is not given.

    Args:
        loop: cut at the error, continuous or sampled.
        k1: lower bound of the sector; that of ``nonlinearity`` where not given, else 0.
        k2: upper bound; that of ``nonlinearity`` where not given, else as large as can be proved.
        nonlinearity: checked against the sector.
        grid: frequencies in rad/s; the loop's own where not given.

    Raises:
        ValueRefused: bounds out of order.
    """
    asked = ask("circle", loop, k1, k2, nonlinearity, grid, static=False)
    if asked.refusal:
        return asked.refused()

    def lines(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return -asked.response(w).real, np.zeros(len(w))

    d = float(loop.d[0, 0])
    ends = () if loop.sampled else ((-d / (1.0 + asked.k1 * d), 0.0),)
    found = best(lines, asked.grid.w, 0.0, 0.0, 0.0, 1.0, ends)
    return outcome(asked, found, ", also one that varies with time", None, {"loop": loop}, "circle")
