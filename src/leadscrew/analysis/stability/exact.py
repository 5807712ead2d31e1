"""Exact proofs that a matrix inequality holds: rational arithmetic, no rounding, no solver to trust.

A number of double precision is a fraction with a power of two below it, so a matrix of such numbers is a matrix of
fractions, and whether it is positive definite is decided exactly: by Sylvester's criterion every leading principal
minor is positive. The minors are the pivots of E. H. Bareiss's fraction-free elimination (*Mathematics of Computation*
22, 1968), in integers.

:class:`Inequality` is the matrix inequality of a stability proof in the form that all of them share, with the matrices
of the loop in ``z`` and ``y``:

    sampled:     M(P) = z' P z - j' P j + y' s y < 0,        continuous:  M(P) = z' P j + j' P z + y' s y < 0,    j = [I
    0]

and :func:`proved` says whether ``P > 0`` and ``M(P) < 0``, for the matrices as they are *and* for every loop whose
matrices differ from them by at most ``tolerance`` of each entry: the tolerance must be above the rounding of the
matrices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

FINEST, COARSEST = 60, 20
"""Tolerances that are tried: ``2**-COARSEST`` down to ``2**-FINEST``."""


def rational(matrix: np.ndarray) -> np.ndarray:
    """The matrix in fractions, each exactly the double that it was."""
    return np.asarray(np.frompyfunc(Fraction, 1, 1)(np.asarray(matrix, dtype=object)), dtype=object)


def positive_definite(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix of fractions (or integers) is positive definite: exact.

    Raises:
        ValueError: the matrix is not symmetric.
    """
    n = len(matrix)
    if any(matrix[i, j] != matrix[j, i] for i in range(n) for j in range(i)):
        raise ValueError("the matrix is not symmetric")
    common = math.lcm(*(Fraction(x).denominator for x in matrix.ravel()))
    rows = [[int(x * common) for x in row] for row in matrix]
    last = 1
    for k in range(n):
        pivot = rows[k][k]
        if pivot <= 0:
            return False
        for i in range(k + 1, n):
            for j in range(i, n):
                rows[i][j] = (rows[i][j] * pivot - rows[k][i] * rows[k][j]) // last
        last = pivot
    return True


@dataclass(frozen=True)
class Inequality:
    """``M(P) < 0`` of the module's table, and ``P > floor``; every matrix holds doubles or fractions."""

    z: np.ndarray
    """``[a b]`` of the (augmented) loop: n by n + 1."""
    y: np.ndarray
    """Signals that the sector speaks of, each a row over state and input: m by n + 1."""
    s: np.ndarray
    """Symmetric weights of the signals, m by m."""
    sampled: bool
    z_bound: np.ndarray
    """By how much an entry of ``z`` moves where every entry of the loop's matrices moves by its ``tolerance``-th
    part."""
    y_bound: np.ndarray
    floor: np.ndarray | None = None
    """What ``P`` must exceed; ``None`` for zero."""

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.z)

    def value(self, p: np.ndarray) -> np.ndarray:
        """``M(P)`` in fractions, from ``P`` in fractions."""
        n = self.order
        found = _product(self.y.T, self.s, self.y)
        if self.sampled:
            found = found + _product(self.z.T, p, self.z)
            found[:n, :n] = found[:n, :n] - p
        else:
            pz = _product(p, self.z)
            found[:n, :] = found[:n, :] + pz
            found[:, :n] = found[:, :n] + pz.T
        return found

    def moved(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of ``|M|``'s change by the tolerance: what goes with it, and what with its square."""
        z, y, zb, yb, p, s = (abs(m) for m in (self.z, self.y, self.z_bound, self.y_bound, p, self.s))
        n = self.order
        first, second = _product(yb.T, s, y), _product(yb.T, s, yb)
        if self.sampled:
            first = first + _product(zb.T, p, z)
            second = second + _product(zb.T, p, zb)
        else:
            first[:n, :] = first[:n, :] + _product(p, zb)
        return first + first.T, second


def _product(*matrices: np.ndarray) -> np.ndarray:
    """The matrix product, in integers over one denominator and back to fractions."""
    whole, below = _integers(matrices[0])
    for matrix in matrices[1:]:
        more, under = _integers(matrix)
        whole, below = whole.dot(more), below * under
    return np.asarray(np.frompyfunc(lambda x: Fraction(x, below), 1, 1)(whole), dtype=object)


def _integers(matrix: np.ndarray) -> tuple[np.ndarray, int]:
    """The matrix of fractions as integers, and their common denominator."""
    exact = rational(matrix)
    common = math.lcm(*(x.denominator for x in exact.ravel()))
    whole = np.frompyfunc(lambda x: x.numerator * (common // x.denominator), 1, 1)(exact)
    return np.asarray(whole, dtype=object), common


@dataclass(frozen=True)
class Proof:
    """A matrix inequality that holds, exactly."""

    p: np.ndarray
    """The matrix of the Lyapunov function ``x' P x``, in doubles; the proof is of exactly these."""
    tolerance: float
    """Relative change of every entry of the loop's matrices that the proof covers, a power of two."""
    order: int


def _above(p: np.ndarray, floor: np.ndarray | None) -> bool:
    """``P > floor``, also where the floor's entries move by four times the coarsest tolerance."""
    if floor is None:
        return True
    room = [4 * Fraction(1, 2**COARSEST) * sum(abs(x) for x in row) for row in floor]
    return positive_definite(p - floor - np.diag(np.array(room, dtype=object)))


def proved(lmi: Inequality, p: np.ndarray, least: float = 0.0, positive: bool = True) -> Proof | None:
    """The proof that ``P`` is one, with the largest tolerance found; ``None`` where it is none or its tolerance <
    ``least``.

    Without ``positive``, ``P`` may be any symmetric matrix: then ``M < 0`` proves the frequency condition only, at
    every frequency.

    A change of the matrix by ``E`` (entry by entry, at most) is covered where ``-M - diag(sum_j E_ij r_j / r_i)`` is
    positive definite, for any positive ``r``: here about the diagonal's root.
    """
    p = 0.5 * (p + p.T)
    exact = rational(p)
    if not np.isfinite(p).all():
        return None
    if positive and not (positive_definite(exact) and _above(exact, lmi.floor)):
        return None
    minus = -lmi.value(exact)
    if not positive_definite(minus):
        return None
    n = len(minus)
    scale = [Fraction(2) ** round(-0.5 * np.log2(float(minus[i, i]))) for i in range(n)]
    first, second = lmi.moved(exact)
    linear, square = ([sum(e[i, j] * scale[j] for j in range(n)) / scale[i] for i in range(n)] for e in (first, second))

    def covered(bits: int) -> bool:
        part = Fraction(1, 2**bits)
        tried = minus.copy()
        for i in range(n):
            tried[i, i] = minus[i, i] - part * linear[i] - part * part * square[i]
        return positive_definite(tried)

    low, high = COARSEST, FINEST
    if not covered(high):
        return Proof(p, 0.0, lmi.order) if least <= 0.0 else None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if covered(middle) else (middle + 1, high)
    tolerance = 2.0**-high
    return Proof(p, tolerance, lmi.order) if tolerance >= least else None
