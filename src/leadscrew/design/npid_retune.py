"""A PID retuned for small errors under force lines, at a given peak of sensitivity.

The sampled loop is ``C(z) P(z)`` with ``C = kp + ki T z/(z - 1) + kd (z - 1)/(T z)``, linear in the gains, so the plant
is computed once and a whole grid of gains is judged at all frequencies at once:

    minimise    mean over the lines of   abs(1 / (1 + C P)) / abs(1 / (1 + C0 P))         (C0: the old gains)
    subject to  max over w of abs(1 / (1 + C P)) <= Ms,    ki / kp <= 1 / ti,    closed loop stable

The ratio is the one of the disturbance responses, because both have the same path from force to position. A coarse
grid, then Nelder-Mead from its best point; closed-loop poles decide on stability. ``1 / ti`` bounds the integral: the
more of it, the smaller the slow errors and the larger the overshoot of a step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from leadscrew.design.npid_axis import Gains, TableAxis
from leadscrew.kernel.errors import ValueRefused

FASTEST_INTEGRAL = 150.0
"""Largest ki / kp, rad/s: that of the retuned PID of the study."""


@dataclass(frozen=True)
class Retuned:
    """New gains, and what they are worth."""

    gains: Gains
    ms: float
    """Peak of the sensitivity."""
    ratio: float
    """Mean of the disturbance response at the lines against that of the old gains."""
    asked: float


class _Judge:
    """Sensitivities of a grid of gains."""

    def __init__(self, axis: TableAxis, lines_hz: tuple[float, ...], old: Gains) -> None:
        self.t = axis.period_s
        self.axis = axis
        unit = axis.linear(Gains(1.0, 0.0, 0.0))
        self.w = np.concatenate([np.geomspace(1.0, 0.999 * math.pi / self.t, 500), [math.pi / self.t]])
        self.plant = unit.response(self.w)
        lines = 2.0 * np.pi * np.asarray(lines_hz)
        self.lines = lines
        self.at_lines = unit.response(lines)
        self.base = np.abs(1.0 / (1.0 + self._law(old, lines) * self.at_lines))

    def _law(self, g: Gains, w: np.ndarray) -> np.ndarray:
        z = np.exp(1j * w * self.t)
        return np.asarray(g.kp + g.ki * self.t * z / (z - 1.0) + g.kd * (z - 1.0) / (self.t * z))

    def ms(self, g: Gains) -> float:
        return float(np.abs(1.0 / (1.0 + self._law(g, self.w) * self.plant)).max())

    def ratio(self, g: Gains) -> float:
        return float((np.abs(1.0 / (1.0 + self._law(g, self.lines) * self.at_lines)) / self.base).mean())

    def stable(self, g: Gains) -> bool:
        return self.axis.linear(g).stable(1.0)


def retuned(
    axis: TableAxis, lines_hz: tuple[float, ...], ms: float, old: Gains | None = None, ti_rate: float = FASTEST_INTEGRAL
) -> Retuned:
    """The PID with the smallest response to the lines at a peak of sensitivity of at most ``ms``.

    Raises:
        ValueRefused: ``ms`` at or below 1, or so small that no gains reach it.
    """
    from scipy.optimize import minimize

    if not (math.isfinite(ms) and ms > 1.0):
        raise ValueRefused(f"--retune {ms!r}: a peak of sensitivity is above 1; 1.6 is careful, 2 is brisk")
    start = old or Gains()
    judge = _Judge(axis, lines_hz, start)

    def gains(x: np.ndarray) -> Gains:
        kp = math.exp(float(x[0]))
        return Gains(kp, min(math.exp(float(x[2])), ti_rate) * kp, kp * math.exp(float(x[1])))

    def cost(x: np.ndarray) -> float:
        g = gains(x)
        over = max(0.0, judge.ms(g) / ms - 1.0)
        return math.log(judge.ratio(g)) + 200.0 * over

    spans = (
        math.log(start.kp) + np.linspace(-2.0, 1.5, 15),
        math.log(max(start.kd, 1e-9) / start.kp) + np.linspace(-1.5, 1.5, 13),
        math.log(ti_rate) - np.array([3.0, 1.5, 0.5, 0.0]),
    )
    tried = [np.array([a, b, c]) for a in spans[0] for b in spans[1] for c in spans[2]]
    order = sorted(tried, key=cost)
    best = next((x for x in order[:50] if judge.stable(gains(x))), None)
    if best is None:
        raise ValueRefused(f"--retune {ms:g}: no stable PID was found near the old gains")
    done = minimize(cost, best, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-8, "maxiter": 600})
    found = gains(done.x if judge.stable(gains(done.x)) else best)
    if judge.ms(found) > 1.005 * ms:
        raise ValueRefused(
            f"--retune {ms:g}: the smallest peak of sensitivity found is {judge.ms(found):.3g}; ask for that at least"
        )
    return Retuned(found, judge.ms(found), judge.ratio(found), ms)
