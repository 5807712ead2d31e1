"""How coarsely a column of a log was written: fixed decimals, significant digits, or both.

A position that was written with three digits has a step of 1 mm at 141 mm and of 0.1 mm at 72.4 mm. An error between
two such columns is known to that step only, whatever the encoder resolves.
"""

from __future__ import annotations

import numpy as np

MOST_DIGITS = 7
MOST_DECIMALS = 9


def digits(values: np.ndarray) -> int | None:
    """The least number of significant digits, up to 7, that all values are written with; None where more are used."""
    return next((d for d in range(1, MOST_DIGITS + 1) if _same(values, _to_digits(values, d))), None)


def decimals(values: np.ndarray) -> int | None:
    """The least number of decimals, up to 9, that all values are written with; None where more are used."""
    return next((d for d in range(MOST_DECIMALS + 1) if _same(values, np.round(values, d))), None)


def steps(values: np.ndarray) -> np.ndarray:
    """The step of each value: the coarser of its last significant digit and the column's last decimal; 0: unknown.

    Each is a grid that all values lie on, so the coarser one holds.
    """
    held = np.abs(np.asarray(values, float))
    found = np.zeros(held.shape)
    count, places = digits(held), decimals(held)
    if count is not None:
        found = np.where(held > 0.0, 10.0 ** (_decade(held) - count + 1), 0.0)
    return found if places is None else np.maximum(found, 10.0**-places)


def _decade(held: np.ndarray) -> np.ndarray:
    return np.floor(np.log10(np.where(held > 0.0, held, 1.0)) + 1e-12)


def _to_digits(values: np.ndarray, count: int) -> np.ndarray:
    step = 10.0 ** (_decade(np.abs(values)) - count + 1)
    return np.round(values / step) * step


def _same(values: np.ndarray, rounded: np.ndarray) -> bool:
    return bool(np.all(np.abs(values - rounded) <= 1e-9 * np.maximum(np.abs(values), 1e-30)))
