"""The monotone values nearest to given ones, on points of any number of dimensions.

    minimise  sum_i w_i (f_i - y_i)^2   subject to   f_i <= f_j  wherever  p_i comes before p_j

``p_i`` comes before ``p_j`` where it does so or is equal in every rising coordinate, the other way round in every
falling one, and equal in every other (:func:`before`). With one row of ``A`` for every neighbouring pair of that order,
``(A f)_k = f_j - f_i >= 0``, the solution is ``f = y + A' lambda / w`` with the ``lambda >= 0`` of least
``|A' lambda / sqrt(w) + sqrt(w) y|``: a non-negative least-squares problem, solved exactly by its active set.

Source: R. E. Barlow et al., Statistical Inference under Order Restrictions, 1972; C. L. Lawson, R. J. Hanson, Solving
Least Squares Problems, 1974, chapter 23.
"""

from __future__ import annotations

import numpy as np

from leadscrew.kernel.errors import ValueRefused

MOST = 1500
"""Points up to which data that is not monotone is fitted: the work grows with the cube."""


def before(first: np.ndarray, second: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Whether each of ``first`` comes before or is equal to each of ``second``; points as rows.

    ``directions``: 1 rising, -1 falling, 0 only comparable where equal; one a coordinate.
    """
    out = np.ones((len(first), len(second)), dtype=bool)
    for k, way in enumerate(directions.tolist()):
        a, b = first[:, None, k], second[None, :, k]
        out &= (a == b) if way == 0 else (way * a <= way * b)
    return out


def violations(points: np.ndarray, values: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Pairs of indices ``(i, j)``: point ``i`` comes before ``j`` and has the larger value."""
    pairs: np.ndarray = np.argwhere(before(points, points, directions) & (values[:, None] > values[None, :]))
    return pairs


def isotonic(points: np.ndarray, values: np.ndarray, weights: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The nearest monotone values, one a point; ``values`` themselves where they are monotone already.

    Points must differ. Errors of the result are those of rounding.

    Raises:
        ValueRefused: more than :data:`MOST` points that are not monotone.
    """
    if not len(violations(points, values, directions)):
        return values.astype(float)
    if len(points) > MOST:
        raise ValueRefused(f"{len(points)} covered cells are not monotone; a monotone fit goes up to {MOST}")
    from scipy.optimize import nnls

    pairs = _neighbours(before(points, points, directions))
    root = np.sqrt(weights)
    matrix = np.zeros((len(points), len(pairs)))
    matrix[pairs[:, 1], np.arange(len(pairs))] = 1.0
    matrix[pairs[:, 0], np.arange(len(pairs))] -= 1.0
    force, _ = nnls(matrix / root[:, None], -root * values, maxiter=30 * max(10, len(pairs)))
    fitted: np.ndarray = values + matrix @ force / weights
    # Rounding may leave neighbours out of order by an ulp: each takes the largest before it, from the start.
    comes = before(points, points, directions)
    for i in np.argsort(comes.sum(axis=0), kind="stable"):
        fitted[i] = fitted[comes[:, i]].max()
    return fitted


def _neighbours(comes: np.ndarray) -> np.ndarray:
    """The pairs of a partial order between which no third point lies."""
    strict = comes & ~np.eye(len(comes), dtype=bool)
    number = strict.astype(np.float32)
    pairs: np.ndarray = np.argwhere(strict & (number @ number < 0.5))
    return pairs
