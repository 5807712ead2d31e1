"""The loop that equation (3) closes: where it is stable by its roots, linear near its rest, and by simulation.

Where the rule at zero alone fires, with ``K = k_d k_e g`` (``g``: turn of the cut by a turn of the blade), the slope
``c`` of the rules and ``s`` of the performance table there, and the steady gain ``kappa`` of the Kalman filter:

    D(k) = w(k) - c E(k),      w(k) = (1 - kappa) w(k-1) + kappa (w(k - m_c) + s kg (-E(k)))      stored, equation (3)
                               w(k) = w(k-1) + kappa s kg (-E(k))                                 accumulate
    E(k) = k_e g x(k - m - 1),     x(k) = a x(k-1) + (1 - a) d(k-1) of the axis,     a = exp(-T / tau_s)

With ``C(z) = 1 - (1 - kappa) / z - kappa / z^m_c``, or ``1 - 1/z``, the characteristic equation is

    C(z) (1 - a / z) + K (1 - a) z^-(m+1) (kappa s kg + c C(z)) = 0.

At the teeth ``w = 2 pi n / m_c`` of this comb ``abs(C) = 2 (1 - kappa) sin(w / 2)``: a gain that ``kappa = 1``, so the
replacement that equation (3) prints, makes infinite, and the filter leaves finite. Where it leaves the loop below 1 at
every tooth, no delay can make it unstable; where it does not, the phase between the delay assumed and the true one has
to fit.

``kappa`` follows from the Riccati equation of one rule, ``p^2 = q (p + r)``: ``kappa = p / (p + r)``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.controllers._sofnn.network import sofnn
from leadscrew.neural.inference_net import W0
from leadscrew.neural.performance import TABLE as TABLE_1
from leadscrew.plants._flexible_cut import flexible_cut
from leadscrew.studies.lab import measure
from leadscrew.studies.sofnn_tangent.cuts import TABLE, deviations, rms
from leadscrew.studies.sofnn_tangent.scenarios import PERIOD_S

if TYPE_CHECKING:
    from leadscrew.studies.lab import Lab

AXIS_KEEP = math.exp(-PERIOD_S / flexible_cut.params.axis_lag_s)
"""What the tangential axis keeps of its offset in a sample, a."""

RULE_SLOPE = float(W0[24 - 1] - W0[24 + 1]) / 4.0
"""Fall of the trained rules per level of E at zero, c; the rules stand two levels apart."""

TABLE_SLOPE = float(TABLE_1[6, 5] - TABLE_1[6, 7]) / 2.0
"""Fall of the performance table per level of E at zero, s."""


def kalman_gain(r: float = sofnn.params.r, q: float = sofnn.params.q) -> float:
    """Steady gain of one rule that fires alone in every sample, kappa."""
    p = 0.5 * (q + math.sqrt(q * q + 4.0 * q * r))
    return p / (p + r)


def at(power: int, value: float = 1.0) -> np.ndarray:
    """``value / z^power`` as coefficients of falling powers of z."""
    row = np.zeros(power + 1)
    row[power] = value
    return row


def added(*rows: np.ndarray) -> np.ndarray:
    """Sum of such polynomials."""
    total = np.zeros(max(map(len, rows)))
    for row in rows:
        total[: len(row)] += row
    return total


def characteristic(
    assumed: int,
    late: int,
    k_e: float,
    kg: float = 1.0,
    gain: float = 0.95,
    accumulate: bool = False,
    kappa: float | None = None,
) -> np.ndarray:
    """Coefficients of the characteristic polynomial, falling powers of z.

    Args:
        assumed: the delay that the learning refers to, m_c, samples.
        late: samples that the camera is late, m.
        k_e: levels per deg.
        kg: strength of the correction.
        gain: turn of the cut by a turn of the blade, g.
        accumulate: the other target.
        kappa: gain of the update; the steady one of the filter unless given. 1: the target is reached at once.
    """
    kappa = kalman_gain() if kappa is None else kappa
    comb = added(at(0), at(1, -1.0)) if accumulate else added(at(0), at(1, kappa - 1.0), at(assumed, -kappa))
    loop = added(at(0, kappa * TABLE_SLOPE * kg), RULE_SLOPE * comb)
    forward = sofnn.params.k_d * k_e * gain * (1.0 - AXIS_KEEP)
    return added(np.convolve(comb, [1.0, -AXIS_KEEP]), np.convolve(at(late + 1, forward), loop))


def radius(assumed: int, late: int, k_e: float, **options: float | bool) -> float:
    """Largest size of a root: below 1 the loop settles."""
    return float(np.abs(np.roots(characteristic(assumed, late, k_e, **options))).max())  # type: ignore[arg-type]


# ---- simulated
K_E = {"6/90": 6.0 / 90.0, "6/30": 6.0 / 30.0, "6/15": 6.0 / 15.0}
"""Levels per degree: as printed, and with three and six times the gain."""
TEXTURES = 4
ASSUMED, TRUE = tuple(range(2, 17, 2)), tuple(range(0, 17, 2))
"""Assumed and true delays of the map, samples."""
SETTLED_DEG = 0.15
"""A loop whose deviation has a smaller RMS in the last two of nine seconds has settled."""


@measure
def on_the_wave(lab: Lab, controller: str, late: int, **values: float) -> float:
    """RMS on the wave in fabric with a camera that is ``late`` samples late, deg, mean of four textures."""
    changes = {"sensor.trailing_s": late * PERIOD_S} | {f"controller.{k}": v for k, v in values.items()}
    loop = lab.loop(controller, "wave_fabric").using(changes)
    return float(np.mean([rms(deviations(loop.start(replicate=k), 923)) for k in range(TEXTURES)]))


class Map(NamedTuple):
    """Whether the loop settles ``[assumed, true]``: by the simulation of a step of 5 deg, by the roots."""

    settled: np.ndarray
    stable: np.ndarray

    @property
    def same(self) -> int:
        """Points where both say the same."""
        return int((self.settled == self.stable).sum())


@measure
def delay_map(lab: Lab, k_e: float) -> Map:
    """The map at a scale of the deviation."""
    loop = lab.loop(TABLE, "step").using({"controller.k_e": k_e, "disturbance.step_at": 0.0})
    settled = np.zeros((len(ASSUMED), len(TRUE)), dtype=bool)
    stable = np.zeros_like(settled)
    for i, assumed in enumerate(ASSUMED):
        for j, late in enumerate(TRUE):
            live = loop.using({"controller.delay": assumed, "sensor.trailing_s": late * PERIOD_S}).start()
            settled[i, j] = rms(deviations(live, 900)[-200:]) < SETTLED_DEG
            stable[i, j] = radius(assumed, late, k_e) < 1.0
    return Map(settled, stable)
