"""Where the loop of Table I crosses the negative real axis, and what has to be added to it for the paper's -0.4.

The printed ``G = C P`` is of relative degree 1 and never crosses. Extra dynamics multiply its response: a dead time, a
zero-order hold, a filtered derivative; or the loop is sampled.
"""

from __future__ import annotations

import math

import numpy as np

from leadscrew.analysis.stability.linear import Crossing, crossings_of, phase_crossings
from leadscrew.analysis.stability.loop import pid_polynomials
from leadscrew.studies.npid_xytable.reference_loops import PLANT, TABLE_I, table_i_sampled

PRINTED = -0.4
"""Section II.C: the Popov plot is *probably* intercepting the negative real axis at (-0.4, j0)."""

W = np.geomspace(10.0, 2e4, 800)
"""Where the first crossing is looked for, rad/s."""


def deepest(found: list[Crossing]) -> Crossing | None:
    """The crossing that limits the gain."""
    return min(found, key=lambda c: c.value, default=None)


def crossing(filter_s: float = 0.0, delay_s: float = 0.0, hold_s: float = 0.0) -> Crossing | None:
    """Deepest crossing of the continuous loop with a filtered derivative, a dead time and a zero-order hold."""
    num, den = (np.polymul(x, y) for x, y in zip(pid_polynomials(*TABLE_I, filter_s), PLANT, strict=True))

    def response(w: np.ndarray) -> np.ndarray:
        s = 1j * w
        held = np.exp(-0.5j * w * hold_s) * np.sinc(w * hold_s / (2.0 * math.pi))
        return np.asarray(np.polyval(num, s) / np.polyval(den, s) * held * np.exp(-s * delay_s))

    return deepest(crossings_of(response, W))


def sampled_crossing(delay_s: float, period: float = 0.5e-3) -> Crossing:
    """Deepest crossing of the sampled loop."""
    found = deepest(phase_crossings(table_i_sampled(delay_s, period)))
    assert found is not None
    return found
