"""Predictors beside GM(1,1) over arrays: lines, DGM(1,1), Verhulst, residual correction; and all of them by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from leadscrew.grey import vectorised as grey
from leadscrew.grey.gm11 import SINGULAR
from leadscrew.grey.others import STEEPEST
from leadscrew.grey.vectorised import checked, decay, phi, regression
from leadscrew.kernel.errors import NameUnknown, ValueRefused


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
    if length < grey.SHORTEST:
        raise ValueRefused(f"a window of {length} samples: GM(1,1) needs at least {grey.SHORTEST}")
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
    fitted = grey.fit(w)
    n = w.shape[-1]
    start = (fitted.u - fitted.c * w[..., 0]) * phi(fitted.c)
    errors = w[..., 1:] - start[..., None] * decay(fitted.c[..., None] * np.arange(1, n))
    sizes = np.abs(errors)
    again = grey._fit(sizes)
    size = np.clip(grey.ahead(sizes, again, horizon), 0.0, sizes.max(axis=-1))
    added = np.where(again.singular, sizes[..., -1], size)
    return grey.ahead(w, fitted, horizon) + added * np.where(errors[..., -1] >= 0.0, 1.0, -1.0)


MODELS: dict[str, Callable[..., np.ndarray]] = {
    "last": last,
    "gm11": grey.gm11,
    "gm11_clamped": grey.gm11_clamped,
    "gm11_guarded": grey.gm11_guarded,
    "gm11_shifted": grey.gm11_shifted,
    "line": line,
    "two_point": two_point,
    "dgm11": dgm11,
    "gm11_printed": grey.gm11_printed,
    "verhulst": verhulst,
    "gm11_residual": gm11_residual,
    "fir": fir,
    "gm11_exponential": grey.gm11_exponential,
    "gm11_off_by_one": grey.gm11_off_by_one,
    "gm11_derivative": grey.gm11_derivative,
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
    full = MODELS[model](grey.sliding(y, length), horizon, **options)
    return np.concatenate((y[: length - 1], full))
