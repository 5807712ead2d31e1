"""Output error of one candidate: only poles and delay are searched, all else follows by linear least squares.

For given poles and delay the simulated output is linear in the rest,

    y[k] = sum_i b_i x_i[k] + (e_0 Phi^k) x(0) + c t[k]^q

``x_i`` are the states of ``1 / D`` under the logged input, ``x(0)`` the unknown start and ``c`` an offset: of the
output where no pole is zero, of the input with ``q`` poles at zero. So the search is over few numbers, and the rest is
exact at every step of it (variable projection: Golub and Pereyra, *SIAM J. Numer. Anal.* 10, 1973, 413).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.identify.linear.response import Step, forced, free, step_of
from leadscrew.identify.linear.structure import DAMPING, Structure

RANK = 1e-11
"""Singular values below this share of the largest are left out: a start of a mode that has long decayed."""


class Solved(NamedTuple):
    """The best linear part for some poles and a delay."""

    denominator: np.ndarray
    delay_s: float
    numerator: np.ndarray
    """Of ``s^m`` down to ``s^0``."""
    start: np.ndarray
    """Of the scaled states, at the first sample."""
    offset: float
    """Of the output (no pole at zero), or the coefficient of ``t^q``."""
    residual: np.ndarray
    """Measured less simulated, at the rows used."""


class Problem:
    """One record and one structure; ``theta`` is as in :class:`Structure`, with the delay in periods last if fitted."""

    def __init__(
        self, u: np.ndarray, y: np.ndarray, period: float, structure: Structure, delay: float | None,
        longest: float, rows: np.ndarray,
    ) -> None:  # fmt: skip
        self.u, self.y, self.period, self.structure, self.delay = u, y, period, structure, delay
        self.longest, self.rows = longest, rows
        self.time = period * np.arange(len(u))

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Of ``theta``: from a twentieth of what the record's length shows to three times the sampling rate."""
        low, high = np.log(0.05 / self.time[-1]), np.log(3.0 / self.period)
        lows, highs = [], []
        for k in range(self.structure.free):
            pair = k < self.structure.free // 2 * 2
            lows.append(np.log(DAMPING[0]) if pair and k % 2 else low)
            highs.append(np.log(DAMPING[1]) if pair and k % 2 else high)
        if self.delay is None:
            lows.append(0.0)
            highs.append(self.longest / self.period)
        return np.array(lows), np.array(highs)

    def system(self, theta: np.ndarray) -> tuple[np.ndarray, float, Step]:
        """Denominator, delay and step."""
        delay_s = float(theta[-1]) * self.period if self.delay is None else self.delay
        denominator = self.structure.denominator(theta)
        return denominator, delay_s, step_of(denominator, delay_s, self.period)

    def columns(self, step: Step) -> np.ndarray:
        """``[row, column]``: states under the input, free responses, the offset's."""
        count = self.structure.zeros + 1
        ramp = (self.time[self.rows] / self.time[-1]) ** self.structure.integrators
        under = forced(step, self.u, count)[self.rows]
        return np.concatenate([under, free(step, len(self.u))[self.rows], ramp[:, None]], axis=1)

    def residual(self, theta: np.ndarray) -> np.ndarray:
        """What the best linear part leaves."""
        return self.project(self.columns(self.system(theta)[2]))[1]

    def project(self, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients and residual of linear least squares."""
        measured = self.y[self.rows]
        size = np.linalg.norm(columns, axis=0)
        size[size == 0.0] = 1.0
        q, r = np.linalg.qr(columns / size)
        left, values, right = np.linalg.svd(r)
        kept = values > RANK * values[0]
        shares = left[:, kept].T @ (q.T @ measured)
        coefficients = right[kept].T @ (shares / values[kept]) / size
        return coefficients, measured - q @ (left[:, kept] @ shares)

    def solve(self, theta: np.ndarray) -> Solved:
        """Everything at ``theta``."""
        denominator, delay_s, step = self.system(theta)
        found, residual = self.project(self.columns(step))
        m, n = self.structure.zeros, self.structure.order
        numerator = found[: m + 1] * step.rate ** (n - np.arange(m + 1.0))
        offset = float(found[-1]) / self.time[-1] ** self.structure.integrators
        return Solved(denominator, delay_s, numerator[::-1].copy(), found[m + 1 : -1], offset, residual)

    def search(self, start: np.ndarray, evaluations: int = 60, tolerance: float = 1e-10) -> tuple[np.ndarray, float]:
        """The nearest minimum, and its sum of squares."""
        from scipy.optimize import least_squares

        if not len(start):
            return start, float(np.sum(self.residual(start) ** 2))
        low, high = self.bounds()
        margin = 1e-6 * (high - low)
        inside = np.clip(start, low + margin, high - margin)
        scale = float(np.std(self.y[self.rows])) or 1.0
        found = least_squares(
            lambda x: self.residual(x) / scale, inside, bounds=(low, high), max_nfev=evaluations, ftol=tolerance,
            xtol=1e-9, gtol=1e-12, diff_step=1e-5,
        )  # fmt: skip
        return found.x, float(2.0 * found.cost * scale**2)
