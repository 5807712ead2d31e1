"""GM(1,1) and the predictors beside it over arrays: windows of any length from four on, all at once, in NumPy.

Every function takes windows of shape ``(..., N)``, oldest sample first, and gives arrays of shape ``(...)``. Where a
model cannot be fitted it gives the last sample, as the step functions of :mod:`leadscrew.grey.gm11` do; with N = 5 the
two agree to rounding. The equations are there; here N - 1 stands where 4 stands there. The steps are written out for
five samples, so they cannot serve the other lengths of ``leadscrew predict --window`` and of
:mod:`leadscrew.grey.filters`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from leadscrew.grey.gm11 import MOST, NEAR, SINGULAR
from leadscrew.grey.others import STEEPEST
from leadscrew.util.errors import NameUnknown, ValueRefused

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


def last(windows, horizon: float = 1.0) -> np.ndarray:
    """The last sample, whatever the horizon: persistence."""
    return checked(windows)[..., -1].copy()


def two_point(windows, horizon: float = 1.0) -> np.ndarray:
    """The line through the last two samples."""
    w = checked(windows)
    return w[..., -1] + horizon * (w[..., -1] - w[..., -2])


def line(windows, horizon: float = 1.0) -> np.ndarray:
    """The least squares line through all samples but the oldest, which is what GM(1,1) tends to at a large offset."""
    w = checked(windows)
    return w @ limit(w.shape[-1], horizon)


def fir(windows, horizon: float = 1.0) -> np.ndarray:
    """The fixed filter that GM(1,1) is near a set-point, one sample ahead whatever the horizon."""
    w = checked(windows)
    return w @ limit(w.shape[-1])


def limit(length: int, horizon: float = 1.0) -> np.ndarray:
    """Weights, oldest first, of the filter that GM(1,1) is where the offset is large and the variation small.

    They are those of the least squares line through the last ``length - 1`` samples, ``horizon`` after the newest: the
    oldest sample drops out. Five samples: 0, -1/2, 0, 1/2, 1.

    Raises:
        ValueRefused: fewer than four samples.
    """
    if length < SHORTEST:
        raise ValueRefused(f"a window of {length} samples: GM(1,1) needs at least {SHORTEST}")
    n = length - 1
    place = np.arange(n) - 0.5 * (n - 1)
    weights = 1.0 / n + place * (0.5 * (n - 1) + horizon) / (place @ place)
    return np.concatenate(([0.0], weights))


def dgm11(windows, horizon: float = 1.0) -> np.ndarray:
    """DGM(1,1): least squares of y1(j) = b y1(j-1) + d over the running sums."""
    w = checked(windows)
    sums = np.cumsum(w, axis=-1)
    slope, x_mean, y_mean, singular = regression(sums[..., :-1], w[..., 1:])
    fits = ~singular & (slope > -1.0)
    held = np.where(fits, slope, 0.0)
    grown = decay(-(w.shape[-1] - 2 + horizon) * np.log1p(held))
    return np.where(fits, (y_mean + held * (w[..., 0] - x_mean)) * grown, w[..., -1])


def verhulst(windows, horizon: float = 1.0) -> np.ndarray:
    """The grey Verhulst model of :func:`leadscrew.grey.others.verhulst`."""
    w = checked(windows)
    m, d = 0.5 * (w[..., 1:] + w[..., :-1]), np.diff(w, axis=-1)
    square = m * m
    weight = square.sum(axis=-1)
    nothing = weight <= 0.0
    over = 1.0 / np.where(nothing, 1.0, weight)
    m_mean, rate_mean = (square * m).sum(axis=-1) * over, (m * d).sum(axis=-1) * over
    e = m - m_mean[..., None]
    spread = (square * e * e).sum(axis=-1)
    singular = nothing | (spread <= SINGULAR * (square * square).sum(axis=-1))
    b = np.where(singular, 0.0, (e * m * d).sum(axis=-1) / np.where(singular, 1.0, spread))
    a = b * m_mean - rate_mean
    ratio = decay(-a * horizon) - b * w[..., -1] * horizon * phi(a * horizon)
    return w[..., -1] / np.where(~singular & (ratio >= STEEPEST), ratio, 1.0)


def gm11_residual(windows, horizon: float = 1.0) -> np.ndarray:
    """GM(1,1) plus GM(1,1) of its residuals, as :func:`leadscrew.grey.others.residual`."""
    w = checked(windows)
    fitted = fit(w)
    n = w.shape[-1]
    start = (fitted.u - fitted.c * w[..., 0]) * phi(fitted.c)
    errors = w[..., 1:] - start[..., None] * decay(fitted.c[..., None] * np.arange(1, n))
    sizes = np.abs(errors)
    again = _fit(sizes)
    size = np.clip(ahead(sizes, again, horizon), 0.0, sizes.max(axis=-1))
    added = np.where(again.singular, sizes[..., -1], size)
    return ahead(w, fitted, horizon) + added * np.where(errors[..., -1] >= 0.0, 1.0, -1.0)


MODELS: dict[str, Callable[..., np.ndarray]] = {
    "last": last,
    "gm11": gm11,
    "gm11_clamped": gm11_clamped,
    "gm11_guarded": gm11_guarded,
    "gm11_shifted": gm11_shifted,
    "line": line,
    "two_point": two_point,
    "dgm11": dgm11,
    "gm11_printed": gm11_printed,
    "verhulst": verhulst,
    "gm11_residual": gm11_residual,
    "fir": fir,
    "gm11_exponential": gm11_exponential,
    "gm11_off_by_one": gm11_off_by_one,
    "gm11_derivative": gm11_derivative,
}
"""By the names of :data:`leadscrew.grey.predictors.KINDS`."""


def predictions(signal, model: str, length: int = 5, horizon: float = 1.0, **options: float) -> np.ndarray:
    """For every sample of a signal what the model said then of the sample ``horizon`` later.

    The first ``length - 1`` values, before the window is full, are the samples themselves. Options: ``reference`` of
    ``gm11_clamped``, ``shift`` of ``gm11_shifted``, ``most`` of ``gm11_guarded``.

    Raises:
        NameUnknown: no such model.
        ValueRefused: a window below four samples, or a signal shorter than the window.
    """
    if model not in MODELS:
        raise NameUnknown(f"no grey model {model!r}; there are {', '.join(MODELS)}")
    y = np.array(signal, dtype=float)
    full = MODELS[model](sliding(y, length), horizon, **options)
    return np.concatenate((y[: length - 1], full))
