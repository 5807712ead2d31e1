"""Covariance of a least-squares fit whose residuals are correlated within windows, with small-sample corrections.

With the rows ``X_g, r_g`` of window ``g``, ``M = (X'X)^-1`` and ``A_g = (I - X_g M X_g')^(-1/2)``

    V = M sum_g (X_g' A_g r_g)(X_g' A_g r_g)' M        ("CR2")

It is unbiased where the residuals are white, and consistent whatever their correlation within a window and their size
from window to window. The interval takes the quantile of Student's t with the degrees of freedom of Bell and McCaffrey,
by parameter: few where few windows tell it. R. Bell, D. McCaffrey, *Bias reduction in standard errors for linear
regression with multi-stage samples*, Survey Methodology 28 (2002) 169; J. Pustejovsky, E. Tipton, J. Business &
Economic Statistics 36 (2018) 672.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

WEAK = 1e-12
"""Share of the largest singular value below which a direction counts as not told at all."""
SHORT_S = 0.02
"""Over which a force is averaged for a look at what disturbs."""
LEVERAGE = 1e-3
"""A window's own weight in its fit is taken to be at most one less this."""


class Spread(NamedTuple):
    """How far to trust the variables of a fit."""

    covariance: np.ndarray
    degrees: np.ndarray
    """Of freedom of Student's t, by variable."""
    condition: float
    """Largest over smallest singular value, columns scaled to the same length."""


def clustered(jacobian: np.ndarray, left: np.ndarray, cluster: np.ndarray) -> Spread:
    """CR2 covariance by window; a direction that is not told has infinite variance."""
    inverse, condition = _inverse(jacobian)
    values, vectors = np.linalg.eigh(inverse)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    edges = np.flatnonzero(np.diff(cluster)) + 1
    scores, sizes, crosses = [], [], []
    for rows, r in zip(np.split(jacobian, edges), np.split(left, edges), strict=True):
        u, s, _ = np.linalg.svd(rows @ root, full_matrices=False)
        gain = 1.0 / np.sqrt(np.maximum(1.0 - s * s, LEVERAGE)) - 1.0
        scores.append(rows.T @ (r + u @ (gain * (u.T @ r))))
        own = rows @ inverse
        own = own + u @ (gain[:, None] * (u.T @ own))
        sizes.append(np.sum(own * own, axis=0))
        crosses.append(rows.T @ own)
    score = np.array(scores)
    covariance = inverse @ (score.T @ score) @ inverse
    return Spread(covariance, _degrees(np.array(sizes), np.array(crosses), inverse), condition)


def _degrees(sizes: np.ndarray, crosses: np.ndarray, inverse: np.ndarray) -> np.ndarray:
    """Bell and McCaffrey's, for white residuals."""
    found = []
    for i in range(sizes.shape[1]):
        b = crosses[:, :, i]
        gram = np.diag(sizes[:, i]) - b @ inverse @ b.T
        found.append(float(np.trace(gram)) ** 2 / max(float(np.sum(gram * gram)), 1e-300))
    return np.maximum(np.array(found), 1.0)


def by_force(jacobian: np.ndarray, left: np.ndarray, period: float, rate: float, block_s: float) -> Spread:
    """Covariance of an open-loop fit, whose residual is a disturbing force integrated twice.

    ``rate`` is viscous friction over mass. The residual is taken back to the force that makes it, ``left = G w`` with
    ``G`` the mass under viscous friction, so that ``X' left = (G' X)' w``: what adds up are blocks of time in ``w``,
    which are independent where those of ``left`` are not.
    """
    from scipy.signal import lfilter

    inverse, condition = _inverse(jacobian)
    kept = float(np.exp(-rate * period))
    a = np.array([1.0, -1.0 - kept, kept])
    force, turned = lfilter(a, [1.0], left), lfilter(a, [1.0], jacobian, axis=0)
    # what the fit itself is off by is in the force too, and would be counted as noise: least squares takes it out
    some = np.arange(0, len(left), max(1, round(SHORT_S / period)))
    off, *_ = np.linalg.lstsq(np.add.reduceat(turned, some, axis=0), np.add.reduceat(force, some), rcond=None)
    force = force - turned @ off
    adjoint = lfilter([1.0], a, jacobian[::-1], axis=0)[::-1]
    block = max(1, round(block_s / period))
    score = np.add.reduceat(adjoint * force[:, None], np.arange(0, len(left), block), axis=0)
    spare = max(1.0, len(score) - jacobian.shape[1] - 2.0)
    covariance = inverse @ (score.T @ score) @ inverse * len(score) / spare
    return Spread(covariance, np.full(jacobian.shape[1], spare), condition)


def _inverse(jacobian: np.ndarray) -> tuple[np.ndarray, float]:
    size = np.linalg.norm(jacobian, axis=0)
    safe = np.where(size > 0.0, size, 1.0)
    _, s, v = np.linalg.svd(jacobian / safe, full_matrices=False)
    usable = np.maximum(s, WEAK * s[0])
    inverse = (v.T / usable**2) @ v / np.outer(safe, safe)
    condition = float(s[0] / s[-1]) if s[-1] > 0.0 else float("inf")
    return inverse, condition
