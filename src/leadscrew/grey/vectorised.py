"""GM(1,1) over arrays: windows of any length from four on, all at once, in NumPy.

Every function takes windows of shape ``(..., N)``, oldest sample first, and gives arrays of shape ``(...)``. Where a
model cannot be fitted it gives the last sample, as the step functions of :mod:`leadscrew.grey.gm11` do; with N = 5 the
two agree to rounding. The equations are there; here N - 1 stands where 4 stands there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.grey.gm11 import MOST, NEAR, SINGULAR
from leadscrew.kernel.errors import ValueRefused

SHORTEST = 4
"""Samples below which GM(1,1) has no spare equation."""


class Fitted(NamedTuple):
    """Models of many windows: arrays of shape ``(...)``."""

    c: np.ndarray
    """Development coefficients, 1/sample."""
    u: np.ndarray
    """Grey inputs, in the unit of the signal."""
    singular: np.ndarray
    """Where nothing could be fitted: there ``c`` is 0 and ``u`` the last sample."""


def checked(windows) -> np.ndarray:
    """Windows as an array of floats.

    Raises:
        ValueRefused: fewer than four samples a window.
    """
    w = np.asarray(windows, dtype=float)
    if w.ndim == 0 or w.shape[-1] < SHORTEST:
        shape = w.shape[-1] if w.ndim else 1
        raise ValueRefused(f"a window of {shape} samples: GM(1,1) needs at least {SHORTEST}")
    return w


def sliding(signal, length: int) -> np.ndarray:
    """The windows of a signal, shape ``(samples - length + 1, length)``; row i ends with sample i + length - 1.

    Raises:
        ValueRefused: a signal that is not one row, or shorter than one window.
    """
    y = np.asarray(signal, dtype=float)
    if y.ndim != 1 or y.size < length:
        raise ValueRefused(f"a signal of shape {y.shape} has no window of {length} samples")
    return np.lib.stride_tricks.sliding_window_view(y, length)


def phi(c) -> np.ndarray:
    """``(exp(c) - 1) / c`` without a singularity."""
    held = np.clip(np.asarray(c, dtype=float), -MOST, MOST)
    small = np.abs(held) < NEAR
    return np.where(small, 1.0 + 0.5 * held, np.expm1(held) / np.where(small, 1.0, held))


def decay(exponent) -> np.ndarray:
    """``exp(-exponent)``, the exponent held within :data:`~leadscrew.grey.gm11.MOST`."""
    return np.exp(-np.clip(exponent, -MOST, MOST))


def regression(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Slope, both means, and where ``x`` has no spread: the line of least squares along the last axis."""
    x_mean, y_mean = x.mean(axis=-1), y.mean(axis=-1)
    d = x - x_mean[..., None]
    spread = (d * d).sum(axis=-1)
    singular = spread <= SINGULAR * (x * x).sum(axis=-1)
    slope = (d * (y - y_mean[..., None])).sum(axis=-1) / np.where(singular, 1.0, spread)
    return np.where(singular, 0.0, slope), x_mean, y_mean, singular


def fit(windows) -> Fitted:
    """The models of windows of shape ``(..., N)``, N >= 4.

    Raises:
        ValueRefused: fewer than four samples a window.
    """
    return _fit(checked(windows))


def _fit(w: np.ndarray) -> Fitted:
    """The same without the check: residuals have one sample less."""
    sums = np.cumsum(w, axis=-1)
    slope, z_mean, y_mean, singular = regression(0.5 * (sums[..., 1:] + sums[..., :-1]), w[..., 1:])
    return Fitted(-slope, np.where(singular, w[..., -1], y_mean - slope * z_mean), singular)


def ahead(windows, fitted: Fitted, horizon: float = 1.0) -> np.ndarray:
    """What the models say ``horizon`` samples after the newest."""
    w = np.asarray(windows, dtype=float)
    start = (fitted.u - fitted.c * w[..., 0]) * phi(fitted.c)
    return start * decay(fitted.c * (w.shape[-1] - 1 + horizon))


def gm11(windows, horizon: float = 1.0) -> np.ndarray:
    """GM(1,1)."""
    w = checked(windows)
    return ahead(w, _fit(w), horizon)


def gm11_clamped(windows, horizon: float = 1.0, reference: float = 0.0) -> np.ndarray:
    """GM(1,1) held between 0 and twice the reference."""
    return np.clip(gm11(windows, horizon), min(0.0, 2.0 * reference), max(0.0, 2.0 * reference))


def gm11_guarded(windows, horizon: float = 1.0, most: float = 0.5) -> np.ndarray:
    """GM(1,1); the last sample where abs(c) is above ``most``."""
    w = checked(windows)
    fitted = _fit(w)
    return np.where(np.abs(fitted.c) > most, w[..., -1], ahead(w, fitted, horizon))


def gm11_shifted(windows, horizon: float = 1.0, shift: float = 0.0) -> np.ndarray:
    """GM(1,1) of the samples raised by ``shift``, which is taken off again."""
    return gm11(checked(windows) + shift, horizon) - shift


def gm11_exponential(windows, horizon: float = 1.0) -> np.ndarray:
    """GM(1,1) with the rate a = ln((2 + c) / (2 - c)): exact on exponentials."""
    w = checked(windows)
    fitted = _fit(w)
    fits = np.abs(fitted.c) < 2.0
    c = np.where(fits, fitted.c, 0.0)
    rate = np.log1p(2.0 * c / (2.0 - c))
    value = (fitted.u - c * w[..., 0]) * (2.0 / (2.0 - c)) * decay(rate * (w.shape[-1] - 1 + horizon))
    return np.where(fits, value, w[..., -1])


def gm11_printed(windows, horizon: float = 1.0) -> np.ndarray:
    """Equation (11) to the letter: minus GM(1,1). A documented error of the paper."""
    w = checked(windows)
    fitted = _fit(w)
    start = (fitted.c * w[..., 0] - fitted.u) * phi(-fitted.c)
    return np.where(fitted.singular, w[..., -1], start * decay(fitted.c * (w.shape[-1] - 2 + horizon)))


def gm11_off_by_one(windows, horizon: float = 1.0) -> np.ndarray:
    """GM(1,1) one sample late: for one sample ahead, the fit of the newest sample."""
    return gm11(windows, horizon - 1.0)


def gm11_derivative(windows, horizon: float = 1.0) -> np.ndarray:
    """The derivative of (9) at the sample, in place of the difference; ``horizon`` 0.5 is mid-interval."""
    w = checked(windows)
    fitted = _fit(w)
    return (fitted.u - fitted.c * w[..., 0]) * decay(fitted.c * (w.shape[-1] - 1 + horizon))
