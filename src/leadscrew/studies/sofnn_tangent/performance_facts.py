"""What can be counted and computed on a performance table: symmetry, monotony, signs, the nearest plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.neural.performance import LEVELS, MOST


class Pair(NamedTuple):
    """Two cells that an odd table would have of opposite sign."""

    ec: int
    e: int
    value: float
    mirror: float
    """At ``-E``, ``-EC``."""


def mirrored(table: np.ndarray) -> np.ndarray:
    """The table at ``-E``, ``-EC``."""
    return table[::-1, ::-1]


def odd_part(table: np.ndarray) -> np.ndarray:
    """What an odd network can know of it."""
    return 0.5 * (table - mirrored(table))


def even_part(table: np.ndarray) -> np.ndarray:
    """What no odd network can know of it."""
    return 0.5 * (table + mirrored(table))


def uneven_pairs(table: np.ndarray) -> list[Pair]:
    """Pairs of cells that do not cancel; one of each pair, ``EC > 0`` or ``EC = 0`` and ``E > 0``."""
    found = []
    for i in range(6, 13):
        for j in range(13):
            ec, e = i - 6, j - 6
            if (ec > 0 or e > 0) and table[i, j] + table[12 - i, 12 - j] != 0.0:
                found.append(Pair(ec, e, float(table[i, j]), float(table[12 - i, 12 - j])))
    return found


def rises(table: np.ndarray, axis: int) -> int:
    """How often the correction rises from one cell to the next along EC (0) or E (1); a monotone one never does."""
    return int(np.count_nonzero(np.diff(table, axis=axis) > 0.0))


def rows_with_humps(table: np.ndarray) -> list[int]:
    """The EC of rows in which a larger deviation gets a smaller correction."""
    return [int(LEVELS[i]) for i in range(13) if np.any(np.diff(table[i]) > 0.0)]


def wrong_signs(table: np.ndarray, ec_weight: float) -> int:
    """Cells whose correction has the sign of ``E + ec_weight EC``."""
    return int(np.count_nonzero(table * (LEVELS[None, :] + ec_weight * LEVELS[:, None]) > 0.0))


class Plane(NamedTuple):
    """``P = -(a E + b EC)`` held to -6 .. 6."""

    a: float
    b: float
    rmse: float


def nearest_plane(table: np.ndarray) -> Plane:
    """The held plane of the smallest RMSE (SciPy, from several starts)."""
    from scipy.optimize import minimize

    def rmse(at: np.ndarray) -> float:
        plane = np.clip(-(at[0] * LEVELS[None, :] + at[1] * LEVELS[:, None]), -MOST, MOST)
        return float(np.sqrt(np.mean((plane - table) ** 2)))

    starts = [(a, b) for a in (0.5, 1.0) for b in (0.3, 0.8)]
    best = min((minimize(rmse, at, method="Nelder-Mead") for at in starts), key=lambda r: float(r.fun))
    return Plane(float(best.x[0]), float(best.x[1]), float(best.fun))


def membership(level: float, centre: float) -> float:
    """How much a level belongs to the triangle around a centre, 2 levels to either side."""
    return max(0.0, 1.0 - abs(level - centre) / 2.0)
