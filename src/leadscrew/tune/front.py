"""Pareto fronts: which settings no other one beats in every goal, and which of them to take."""

from __future__ import annotations

import numpy as np


def front(objectives: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Indices of the points that no other allowed point beats or equals everywhere; of equal points the first.

    They are sorted by the first goal.
    """
    at = np.flatnonzero(allowed)
    order = at[np.lexsort((at, *objectives[at].T[::-1]))]
    kept: list[int] = []
    for i in order:
        if not kept or not (objectives[kept] <= objectives[i]).all(axis=1).any():
            kept.append(int(i))
    return np.array(kept, dtype=int)


def scaled(objectives: np.ndarray) -> np.ndarray:
    """Each goal from 0, its best on the front, to 1, its worst."""
    low, high = objectives.min(axis=0), objectives.max(axis=0)
    return np.asarray((objectives - low) / np.where(high > low, high - low, 1.0))


def compromise(objectives: np.ndarray) -> int:
    """The point of a front nearest to the best of every goal, goals scaled to the extent of the front."""
    return int(np.argmin((scaled(objectives) ** 2).sum(axis=1)))


def thinned(objectives: np.ndarray, most: int) -> np.ndarray:
    """Indices of at most ``most`` points of a front, spread along it: its ends, the compromise, and even steps."""
    count = len(objectives)
    if count <= most:
        return np.arange(count)
    steps = np.linalg.norm(np.diff(scaled(objectives), axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, way[-1], most - 1)
    near = np.searchsorted(way, wanted - 1e-12 * way[-1]).clip(0, count - 1)
    return np.unique([*near, compromise(objectives)])
