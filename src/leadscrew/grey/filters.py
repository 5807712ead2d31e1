"""A predictor as a filter: its response, its noise gain, and what a grey model is near a level, by differences.

Weights stand oldest sample first, as in a window, and give the prediction as their product with it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from leadscrew.grey.vectorised import gm11
from leadscrew.util.errors import ValueRefused


def linearised(level: float, length: int = 5, horizon: float = 1.0, model: Callable[..., np.ndarray] = gm11,
               step: float = 1e-4) -> np.ndarray:  # fmt: skip
    """Weights of a model around windows that are constant at ``level``: central differences of relative ``step``.

    Raises:
        ValueRefused: a level of 0, where a grey model has no slope.
    """
    if not 0.0 < abs(level) < np.inf:
        raise ValueRefused(f"level = {level!r}: a grey model is linear only around a finite level that is not 0")
    by = step * abs(level)
    moved = by * np.eye(length)
    return (model(level + moved, horizon) - model(level - moved, horizon)) / (2.0 * by)


def response(weights, frequency) -> np.ndarray:
    """Complex response at frequencies in rad/sample; a phase above zero is a lead."""
    w = np.asarray(weights, dtype=float)
    lags = np.arange(w.size - 1, -1, -1.0)
    return np.exp(-1j * np.multiply.outer(np.asarray(frequency, dtype=float), lags)) @ w


def noise_gain(weights) -> float:
    """Standard deviation of the prediction over that of white noise in the samples."""
    return float(np.linalg.norm(np.asarray(weights, dtype=float)))


def lead(weights) -> float:
    """By how many samples the filter is ahead of a slow signal: its group delay at rest, with the sign turned."""
    w = np.asarray(weights, dtype=float)
    return float(-(w @ np.arange(w.size - 1, -1, -1.0)) / w.sum())
