"""Whether a residual is noise: the share of its autocorrelations that lie within their 95 % bounds.

Of white noise about 95 of 100 lie within ``+- 1.96 / sqrt(n)`` (G. Box and G. Jenkins, 1970). A filtered residual is
looked at once in a window's length, so that the filter itself does not colour it.
"""

from __future__ import annotations

import numpy as np

LAGS = 40
LEAST = 10
"""Pairs that an autocorrelation is taken of at least."""


def whiteness(residual: np.ndarray, lags: int = LAGS) -> float:
    """Percent of the first ``lags`` autocorrelations within their bounds; NaN in the residual marks what is left out.

    NaN where fewer than :data:`LEAST` pairs are there for every lag.
    """
    known = np.isfinite(residual)
    if known.sum() < LEAST:
        return float("nan")
    r = np.where(known, residual - np.mean(residual[known]), 0.0)
    power = float(np.mean(r[known] ** 2))
    if not power > 0.0:
        return float("nan")
    inside = []
    for lag in range(1, min(lags, len(r) - 1) + 1):
        pairs = int(np.sum(known[lag:] & known[:-lag]))
        if pairs >= LEAST:
            inside.append(abs(float(r[lag:] @ r[:-lag]) / pairs / power) <= 1.96 / np.sqrt(pairs))
    return 100.0 * float(np.mean(inside)) if inside else float("nan")
