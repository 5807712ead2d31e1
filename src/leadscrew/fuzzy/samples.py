"""The door for samples to learn from: rows of finite numbers, each with what it is called in errors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from leadscrew.kernel.errors import ValueRefused


def names_of(names: Sequence[str] | None, inputs: int) -> tuple[str, ...]:
    """Names of the inputs, and of the output last: those given, or ``x1``, ``x2``, ..., ``y``."""
    if inputs < 1:
        raise ValueRefused("rules need at least one input")
    called = tuple(names) if names is not None else (*(f"x{k + 1}" for k in range(inputs)), "y")
    if len(called) != inputs + 1 or len(set(called)) != len(called):
        raise ValueRefused(f"names = {list(called)}: expected {inputs + 1} different ones, the output's last")
    return called


def rows_of(samples: Any, names: tuple[str, ...], numbers: Any) -> tuple[np.ndarray, np.ndarray]:
    """The samples as an array, empty where there are none, and their numbers."""
    wanted = f"expected rows of {len(names)} numbers ({', '.join(names)})"
    given = list(samples) if isinstance(samples, Iterable) and not isinstance(samples, np.ndarray) else samples
    try:
        rows = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueRefused(f"samples: {wanted}") from None
    rows = np.empty((0, len(names))) if rows.size == 0 else rows
    if rows.ndim != 2 or rows.shape[1] != len(names):
        raise ValueRefused(f"samples of shape {rows.shape}: {wanted}")
    number = np.arange(len(rows)) if numbers is None else np.asarray(numbers)
    if number.shape != (len(rows),):
        raise ValueRefused(f"numbers of shape {number.shape} for {len(rows)} samples")
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        row, column = bad[0].tolist()
        raise ValueRefused(
            f"samples, row {number[row]} (from 0): {names[column]} = {rows[row, column]}: must be finite"
        )
    return rows, number


def weights_of(weights: Any, number: np.ndarray) -> np.ndarray | None:
    """One weight in (0, 1] for each of the samples with these numbers."""
    if weights is None:
        return None
    given = np.asarray(weights, dtype=float)
    if given.shape != number.shape:
        raise ValueRefused(f"weights of shape {given.shape} for {len(number)} samples")
    bad = np.flatnonzero(~((given > 0.0) & (given <= 1.0)))
    if len(bad):
        raise ValueRefused(f"weights, row {number[bad[0]]} (from 0): {given[bad[0]]}: allowed is above 0 to 1")
    return given
