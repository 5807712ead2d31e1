"""Rightmost poles of a linear system with one dead time: ``x'(t) = A x(t) + M x(t - h)``.

Its infinitesimal generator on ``[-h, 0]`` is replaced by a matrix on Chebyshev points, whose rightmost eigenvalues are
those of the system (D. Breda, S. Maset, R. Vermiglio, SIAM J. Sci. Comput. 27 (2005) 482); each is then refined by
Newton's method on the characteristic equation ``det(s I - A - M e^(-s h)) = 0``.
"""

from __future__ import annotations

import numpy as np

POINTS = 28
"""Chebyshev points on the dead time: more than twice what the loops of the tests need."""

STEPS = 8
"""Newton steps; from the matrix's eigenvalues two or three do."""


def delay_poles(a: np.ndarray, m: np.ndarray, h: float) -> np.ndarray:
    """The rightmost poles, those that the Newton refinement confirmed, from right to left."""
    n = len(a)
    slope = _chebyshev(POINTS, h)
    whole = np.kron(slope, np.eye(n))
    whole[:n] = 0.0
    whole[:n, :n] = a
    whole[:n, -n:] = m
    rough = np.linalg.eigvals(whole)
    rough = rough[np.argsort(-rough.real)][: 4 * n + 12]
    kept: list[complex] = []
    for s in rough:
        refined = _newton(a, m, h, complex(s))
        if refined is not None and all(abs(refined - k) > 1e-9 * (1.0 + abs(k)) for k in kept):
            kept.append(refined)
    return np.array(sorted(kept, key=lambda s: -s.real))


def _newton(a: np.ndarray, m: np.ndarray, h: float, s: complex) -> complex | None:
    eye = np.eye(len(a))
    start = s
    for _ in range(STEPS):
        late = m * np.exp(-s * h)
        matrix = s * eye - a - late
        try:
            # the derivative of log det is the trace of the matrix' inverse times its derivative
            change = 1.0 / np.trace(np.linalg.solve(matrix, eye + h * late))
        except np.linalg.LinAlgError:
            return s
        if not np.isfinite(change):
            return s
        s = s - change
        if abs(change) <= 1e-13 * (1.0 + abs(s)):
            return s if abs(s - start) <= 0.05 * (1.0 + abs(start)) else None
    return None


def _chebyshev(count: int, h: float) -> np.ndarray:
    """The matrix that differentiates on the Chebyshev points from 0 down to -h."""
    k = np.arange(count + 1)
    x = np.cos(np.pi * k / count)
    weight = np.where((k == 0) | (k == count), 2.0, 1.0) * (-1.0) ** k
    apart = x[:, None] - x[None, :]
    slope = np.outer(weight, 1.0 / weight) / (apart + np.eye(count + 1))
    slope -= np.diag(slope.sum(axis=1))
    return np.asarray(slope * 2.0 / h)
