"""Logs of an axis with known parameters, moved by a force of its own in open loop, and exact between stops."""

from __future__ import annotations

import numpy as np

from leadscrew.identify.axis.record import Record, record
from tests.identify.axis_oracle import Axis, open_loop

AXIS = Axis(mass=50.0, viscous=120.0, coulomb=15.0, offset=-2.0)
DT = 1e-3


def shove(seconds: float = 8.0, size: float = 60.0, seed: int = 0) -> np.ndarray:
    """A force that jumps every 50 to 250 ms, as often one way as the other, and pushes through all friction."""
    rng = np.random.default_rng(seed)
    parts: list[np.ndarray] = []
    side = 1.0
    while sum(len(p) for p in parts) < seconds / DT:
        parts.append(np.full(int(rng.uniform(50, 250)), side * size * rng.uniform(0.6, 1.4)))
        side = -side
    return np.concatenate(parts)[: int(seconds / DT)]


def run(
    axis: Axis = AXIS, force: np.ndarray | None = None, count: float = 1e-7, delay: int = 0, v: float = 0.0
) -> Record:
    """The log of it, on counts."""
    force = shove() if force is None else force
    x = open_loop(axis, force, DT, 0.0, v, delay)
    return record(DT, np.round(x / count) * count, force)
