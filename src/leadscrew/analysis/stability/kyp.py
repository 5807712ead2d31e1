"""The matrix inequalities of the stability criteria, and the search for their solution by a Riccati equation.

The loop ``x+ = a x + b v, e = -(c x + d v)`` with ``v = phi(e)`` (or ``x' = ...``) is stable if a function
``V = x' P x`` (plus an integral of ``phi`` for the criteria with a multiplier) falls along every motion. Each
inequality below is ``V``'s change plus what the sector makes positive, as a quadratic form of state and ``v``; ``w = v
- k1 e`` and ``k = k2 - k1``:

==========  ===================================================================  ======================================
criterion   what is added, positive in the sector                                holds for
==========  ===================================================================  ======================================
circle      ``2 w (k e - w)``                                                    gains that vary, and every static map
Tsypkin     ``+ 2 k q w (g - g_last)``, ``g = e - w / m``                        static maps of slope in [k1, k1 + m]
Jury-Lee    ``+ k q (2 w (e_next - e) + m (e_next - e)^2)``                      static maps of slope up to k1 + m
Popov       ``+ 2 k q w de/dt`` (continuous)                                     static maps
==========  ===================================================================  ======================================

For Tsypkin ``m`` may be infinite (``g = e``): any map whose slope is at least ``k1``. A negative ``q`` stands for the
multiplier that looks the other way: Tsypkin's ``2 k |q| w_last (g_last - g)``, Jury and Lee's with ``e_last`` for
``e_next``; the integral of ``w`` then counts against ``V``, and ``P`` must make up for it. Without the multiplier the
first row alone is the discrete or continuous Kalman-Yakubovich-Popov inequality of the circle criterion.

Sources: Ya. Z. Tsypkin, *Doklady* 145, 1962; E. I. Jury, B. W. Lee, *IEEE Trans. Automatic Control* 9, 1964, and in
state space W. M. Haddad, D. S. Bernstein, *Int. J. Robust and Nonlinear Control* 4, 1994; H. K. Khalil, *Nonlinear
Systems*, 3rd ed., Prentice Hall 2002, section 7.1; the Riccati equation: J. C. Willems, *IEEE Trans. Automatic
Control* 16, 1971; the multipliers of negative ``q``: R. O'Shea, M. I. Younis, *ibid.* 12, 1967.
"""

from __future__ import annotations

import math
import warnings
from fractions import Fraction
from typing import Any

import numpy as np

from leadscrew.analysis.stability.exact import Inequality, Proof, proved, rational
from leadscrew.analysis.stability.linear import LinearLoop

ROUNDING = 2.0**-42
"""Rounding of a loop's matrices that a proof must cover, of each entry: a thousand roundings of double precision."""

STRICTNESS = tuple(10.0**-k for k in range(2, 14))
"""By how much the Riccati equation is made strict, in parts of the sector's own weight: the largest that solves is
best."""


def inequality(loop: LinearLoop, k1: float, k2: float) -> Inequality:
    """The circle criterion's, for the sector ``[k1, k2]``."""
    e, v = _signals(loop)
    z, y = rational(np.hstack([loop.a, loop.b])), np.vstack([e, v])
    return Inequality(z, y, _sector(k1, k2, 2), loop.sampled, abs(z), np.vstack([abs(e), 0 * v]))


def tsypkin_inequality(loop: LinearLoop, k1: float, k2: float, q: float, slope: float = math.inf) -> Inequality:
    """Tsypkin's with the multiplier ``1 + q (1 - 1/z)`` or ``1 + |q| (1 - z)``: maps of slope in ``[k1, slope]``."""
    z, y, bounds, floor = _remembering(loop, k2 - k1, min(q, 0.0))
    low, k = Fraction(k1), Fraction(k2) - Fraction(k1)
    inverse = Fraction(0) if math.isinf(slope) else 1 / (Fraction(slope) - low)
    w, w_last = _vector(-low, 1, 0, 0), _vector(0, 0, -low, 1)
    step = _vector(1, 0, -1, 0) - inverse * (w - w_last)
    more = _product(w, step) if q >= 0.0 else _product(w_last, -step)
    return Inequality(z, y, _sector(k1, k2, 4) + k * abs(Fraction(q)) * more, True, *bounds, floor)


def jury_lee_inequality(loop: LinearLoop, k1: float, k2: float, q: float, slope: float) -> Inequality:
    """Jury and Lee's with the multiplier ``1 + q (z - 1)`` or ``1 + |q| (1/z - 1)``, for maps of slope up to ``slope``.

    Needs a loop without direct feed-through where ``q > 0``.
    """
    low, k, part = Fraction(k1), Fraction(k2) - Fraction(k1), abs(Fraction(q))
    curved = (Fraction(slope) - low) / 2
    if q < 0.0:
        z, y, bounds, floor = _remembering(loop, k2 - k1, q)
        w, step = _vector(-low, 1, 0, 0), _vector(-1, 0, 1, 0)
    else:
        e, v = _signals(loop)
        z = rational(np.hstack([loop.a, loop.b]))
        y = np.vstack([e, v, e[:-1].dot(z)])
        bounds, floor = (abs(z), np.vstack([abs(e), 0 * v, 3 * abs(e[:-1]).dot(abs(z))])), None
        w, step = _vector(-low, 1, 0), _vector(-1, 0, 1)
    s = _sector(k1, k2, len(y)) + k * part * (_product(w, step) + curved * _product(step, step))
    return Inequality(z, y, s, True, *bounds, floor)


def _remembering(
    loop: LinearLoop, k: float, q: float
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray], Any]:
    """The loop with the last ``e`` and ``v`` as states: z, rows of ``e, v, e_last, v_last``, bounds, floor."""
    n = len(loop.a)
    e, v = (np.concatenate([row[:n], rational(np.zeros(2)), row[n:]]) for row in _signals(loop))
    z = np.vstack([_wide(rational(np.hstack([loop.a, loop.b])), n, 2), e, v])
    e_last, v_last = rational(np.eye(n + 3)[n]), rational(np.eye(n + 3)[n + 1])
    bounds = np.vstack([abs(z[:n]), abs(e), 0 * v]), np.vstack([abs(e), 0 * v, 0 * v, 0 * v])
    return z, np.vstack([e, v, e_last, v_last]), bounds, _floor(e_last, n + 2, Fraction(k), Fraction(q))


def popov_inequality(loop: LinearLoop, k1: float, k2: float, q: float) -> Inequality:
    """Popov's with the multiplier ``1 + q s``, either sign of ``q``, for a continuous loop without feed-through."""
    n = len(loop.a)
    e, v = _signals(loop)
    z = rational(np.hstack([loop.a, loop.b]))
    y = np.vstack([e, v, e[:n].dot(z)])
    y_bound = np.vstack([abs(e), 0 * v, 3 * abs(e[:n]).dot(abs(z))])
    low, k, part = Fraction(k1), Fraction(k2) - Fraction(k1), Fraction(q)
    s = _sector(k1, k2, 3) + k * part * _product(_vector(-low, 1, 0), _vector(0, 0, 1))
    return Inequality(z, y, s, False, abs(z), y_bound, _floor(e, n, k, part))


def solve(lmi: Inequality, k1: float, least: float = ROUNDING, positive: bool = True) -> Proof | None:
    """A verified solution with a tolerance of at least ``least``; ``None`` where none is found.

    The Riccati equation that belongs to the inequality, made strict by a little, is solved with states scaled by how
    far noise at ``v`` moves them while ``v = k1 e``; what it gives is only a proposal, :func:`proved` decides.
    """
    scale = _state_sizes(lmi, k1)
    if scale is None:
        return None
    n = lmi.order
    z, y = lmi.z.astype(float), lmi.y.astype(float)
    grown = np.append(scale, 1.0)
    a, b = z[:, :n] / scale[:, None] * scale, z[:, n:] / scale[:, None]
    weights = (y * grown).T @ lmi.s.astype(float) @ (y * grown)
    size = float(np.abs(np.diag(weights)).max())

    def proposal(strict: float) -> np.ndarray | None:
        q = -(weights[:n, :n] + strict * size * np.eye(n))
        x = _riccati(lmi.sampled, a, b, q, -weights[n:, n:], -weights[:n, n:])
        return None if x is None else -x

    if proposal(STRICTNESS[-1]) is None:
        return None
    for strict in STRICTNESS:
        p = proposal(strict)
        if p is None or _hopeless(lmi.sampled, a, b, weights, p):
            continue
        found = proved(lmi, p / scale[:, None] / scale, least, positive)
        if found is not None:
            return found
    return None


def _hopeless(sampled: bool, a: np.ndarray, b: np.ndarray, weights: np.ndarray, p: np.ndarray) -> bool:
    """Whether a proposal fails by far more than rounding, so that the exact look can be spared."""
    n = len(a)
    z, j = np.hstack([a, b]), np.eye(n, n + 1)
    minus = -weights - (z.T @ p @ z - j.T @ p @ j if sampled else z.T @ p @ j + j.T @ p @ z)
    diagonal = np.diag(minus)
    if not np.isfinite(minus).all() or (diagonal <= 0.0).any():
        return True
    unit = minus / np.sqrt(diagonal) / np.sqrt(diagonal)[:, None]
    return bool(np.linalg.eigvalsh(0.5 * (unit + unit.T))[0] < -1e-4)


def _riccati(sampled: bool, a: Any, b: Any, q: Any, r: Any, s: Any) -> np.ndarray | None:
    from scipy.linalg import LinAlgError, solve_continuous_are, solve_discrete_are

    solver = solve_discrete_are if sampled else solve_continuous_are
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return np.asarray(solver(a, b, q, r, s=s))
        except (LinAlgError, ValueError):
            return None


def _state_sizes(lmi: Inequality, k1: float) -> np.ndarray | None:
    """Standard deviation of every state under white noise at ``v``, powers of two; ``None`` where it grows."""
    from scipy.linalg import LinAlgError, matrix_balance, solve_continuous_lyapunov, solve_discrete_lyapunov

    n = lmi.order
    z, e = lmi.z.astype(float), lmi.y[0].astype(float)
    through = 1.0 - k1 * e[n]
    if through <= 0.0:
        return None
    a, b = z[:, :n] + k1 / through * np.outer(z[:, n], e[:n]), z[:, n:] / through
    poles = np.linalg.eigvals(a)
    if (np.abs(poles) >= 1.0).any() if lmi.sampled else (poles.real >= 0.0).any():
        return None
    a, (rough, _) = matrix_balance(a, permute=False, separate=True)
    b = b / rough[:, None]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            square = solve_discrete_lyapunov(a, b @ b.T) if lmi.sampled else solve_continuous_lyapunov(a, -b @ b.T)
        except (LinAlgError, ValueError):
            return None
    sizes = np.sqrt(np.maximum(np.diag(square), 0.0))
    top = float(sizes.max())
    if not np.isfinite(top) or top == 0.0:
        return None
    return np.asarray(2.0 ** np.round(np.log2(np.maximum(sizes, 1e-9 * top))) * rough)


def _signals(loop: LinearLoop) -> tuple[np.ndarray, np.ndarray]:
    """Rows of ``e`` and ``v`` over state and ``v``."""
    e = -rational(np.concatenate([loop.c.ravel(), loop.d.ravel()]))
    return e, rational(np.eye(len(e))[-1])


def _sector(k1: float, k2: float, signals: int) -> np.ndarray:
    """``2 (v - k1 e)(k2 e - v)`` over ``e, v, ...``."""
    rest = [0] * (signals - 2)
    return _product(_vector(-Fraction(k1), 1, *rest), _vector(Fraction(k2), -1, *rest))


def _vector(*entries: Fraction | int) -> np.ndarray:
    return np.array([Fraction(x) for x in entries], dtype=object)


def _product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The symmetric matrix of ``2 left right``."""
    return np.asarray(np.outer(left, right) + np.outer(right, left))


def _wide(z: np.ndarray, at: int, more: int) -> np.ndarray:
    return np.asarray(np.hstack([z[:, :at], rational(np.zeros((len(z), more))), z[:, at:]]))


def _floor(e: np.ndarray, n: int, k: Fraction, q: Fraction) -> np.ndarray | None:
    """Where ``q < 0`` the integral of ``w`` counts against ``V``: at most ``k e^2 / 2``, weighed with ``2 k |q|``."""
    return None if q >= 0 else np.asarray(-q * k * k * np.outer(e[:n], e[:n]))
