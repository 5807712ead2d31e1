"""How sure a linear model is: covariance of its coefficients under noise of any colour.

With ``J`` the change of the simulated output by every coefficient, start and offset, and ``r`` the autocovariance of
what is left,

    Cov = (Z' J)^-1  Z' R Z  (J' Z)^-1,     R[i, j] = r(abs(i - j))

``Z = J`` for output error, or the instruments inside a closed loop (Soderstrom and Stoica, *System Identification*,
1989, complement C7.5 and section 8.2). ``r`` is that of an autoregression fitted to the residual, its order chosen by
BIC: quantisation and white noise need order 0, play of disturbances some. Quantities such as a pole follow to first
order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

ORDERS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Of the autoregression of the residual."""
FLAT = 1e-12
"""Share of the largest singular value below which a direction counts as this flat: its variance is huge, not none."""
LAGS = 25
"""Of the whiteness test."""
NORMAL = 1.959963984540054
"""Half of a 95 % interval, in standard deviations."""


class Interval(NamedTuple):
    """A quantity and its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str = ""
    told: bool = True
    """Whether the half width is below half of the value."""

    @property
    def percent(self) -> float:
        """Half of the interval as a share of the value, in percent."""
        return abs(50.0 * (self.high - self.low) / self.value) if self.value else float("inf")


def autocovariance(values: np.ndarray, lags: int) -> np.ndarray:
    """Of a residual, about zero, biased (divided by the number of samples), for 0 to ``lags``."""
    n = len(values)
    size = 1 << int(2 * n - 1).bit_length()
    power = np.abs(np.fft.rfft(values, size)) ** 2
    return np.asarray(np.fft.irfft(power, size)[: lags + 1] / n)


def autoregression(residual: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients ``1, a_1, ...`` and variance of the driving noise, by Yule and Walker, order by BIC."""
    from scipy.linalg import solve_toeplitz

    n = len(residual)
    r = autocovariance(residual, min(ORDERS[-1], n // 10))
    best = (np.inf, np.array([1.0]), float(r[0]))
    for order in ORDERS:
        if order >= len(r) or r[0] <= 0.0:
            break
        firm = r[:order] * (1.0 + 1e-9 * (np.arange(order) == 0))
        a = -solve_toeplitz(firm, r[1 : order + 1]) if order else np.array([])
        left = float(r[0] + a @ r[1 : order + 1])
        if left <= 0.0:
            break
        score = n * np.log(left) + order * np.log(n)
        if score < best[0]:
            best = (score, np.concatenate([[1.0], a]), left)
    return best[1], best[2]


def covariance(jacobian: np.ndarray, residual: np.ndarray, instruments: np.ndarray | None = None) -> np.ndarray:
    """Of all columns of ``jacobian`` (change of the simulated output), at consecutive samples."""
    z = jacobian if instruments is None else instruments
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    j, z = jacobian / scale, z / scale
    spare = max(1, len(residual) - j.shape[1])
    a, variance = autoregression(residual * np.sqrt(len(residual) / spare))
    size = 1 << int(2 * len(residual) - 1).bit_length()
    spectrum = variance / np.abs(np.fft.rfft(a, size)) ** 2
    basis = np.linalg.qr(z)[0]
    seen = np.fft.rfft(basis, size, axis=0)
    weight = np.full(len(spectrum), 2.0)
    weight[0] = weight[-1] = 1.0
    middle = (seen.conj().T @ (seen * (weight * spectrum)[:, None])).real / size
    left, values, right = np.linalg.svd(basis.T @ j)
    bread = (right.T / np.maximum(values, FLAT * values[0])) @ left.T
    return np.asarray(bread @ middle @ bread.T / np.outer(scale, scale))


def condition(jacobian: np.ndarray) -> float:
    """Of the columns, each scaled to length one."""
    size = np.linalg.norm(jacobian, axis=0)
    values = np.linalg.svd(np.linalg.qr(jacobian[:, size > 0.0] / size[size > 0.0])[1], compute_uv=False)
    return float(values[0] / values[-1]) if len(values) and values[-1] > 0.0 else float("inf")


def slopes(quantity: Callable[[np.ndarray], np.ndarray], at: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Change of some quantities by each coefficient, by central differences over a small share of its spread."""
    size = np.where(at == 0.0, 1.0, np.abs(at))
    step = np.clip(1e-3 * spread, 1e-7 * size, 1e-3 * size)
    rows = []
    for k in range(len(at)):
        away = np.zeros(len(at))
        away[k] = step[k]
        rows.append((quantity(at + away) - quantity(at - away)) / (2.0 * step[k]))
    return np.array(rows).T


def whiteness(residual: np.ndarray, lags: int = LAGS) -> tuple[float, np.ndarray]:
    """Share in percent of autocorrelations within the 95 % bounds of white noise, and the autocorrelations from 1."""
    r = autocovariance(residual - residual.mean(), min(lags, len(residual) // 4))
    if r[0] <= 0.0:
        return 100.0, np.zeros(len(r) - 1)
    rho = r[1:] / r[0]
    return float(100.0 * np.mean(np.abs(rho) < NORMAL / np.sqrt(len(residual)))), rho
