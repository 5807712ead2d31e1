"""The controllers beyond the paper on the stairs of the depth, and what they make of wrong beliefs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from leadscrew.studies.grey_turning.readings import filtered
from leadscrew.studies.grey_turning.scenarios import FORCE_N
from leadscrew.studies.lab import Lab, measure

STAIR_SEEDS = 10
"""Noise seeds of one staircase."""
FIRST_S = 1.9
"""The entry is over: from here on the stairs are judged."""
TFC, TFC_FF, ALL = "corrected.tfc_stfc", "ours.tfc_ff", "ours.constant_force"


class Stairs(NamedTuple):
    """Largest deviations after the entry, percent of the command, mean of the seeds."""

    low: float
    high: float
    true_low: float
    true_high: float

    @property
    def worst(self) -> float:
        """Of the filtered force."""
        return max(-self.low, self.high)


class Staircase(NamedTuple):
    """The falling depth under variants of a controller, by variant and seed."""

    time: np.ndarray
    force: np.ndarray
    """Filtered."""
    true: np.ndarray
    output: np.ndarray

    def of(self, k: int) -> Stairs:
        """The readings of one variant."""
        late = self.time >= FIRST_S
        y, f = (100.0 * (v[k][:, late] / FORCE_N - 1.0) for v in (self.force, self.true))
        return Stairs(*(float(v.mean()) for v in (y.min(axis=1), y.max(axis=1), f.min(axis=1), f.max(axis=1))))


VARIED = ("preview_s", "exponent", "depth_error")
TRIED: dict[str, tuple[float, float, float]] = {
    "no preview": (0.0, 0.77, 0.0),
    "preview of 40 ms": (0.04, 0.77, 0.0),
    "preview of 65 ms": (0.065, 0.77, 0.0),
    "preview of 90 ms": (0.09, 0.77, 0.0),
    "65 ms, P believed 0.70": (0.065, 0.70, 0.0),
    "65 ms, P believed 0.85": (0.065, 0.85, 0.0),
    "65 ms, depth believed 0.05 mm larger": (0.065, 0.77, 0.05),
}
"""Depth feed-forward: preview, exponent and error of the depth."""
BEST = "preview of 65 ms"


@measure
def stairs(lab: Lab, name: str, tried: bool = False) -> Staircase:
    """The stairs from 1 to 0.4 mm; ``tried``: under each of :data:`TRIED`."""
    loop = lab.loop(name, "fig9_falling_depth")
    rows: Sequence[tuple[float, ...]] = list(TRIED.values()) if tried else []
    varied = {f"controller.{key}": np.repeat([row[i] for row in rows], STAIR_SEEDS) for i, key in enumerate(VARIED)}
    count = max(len(rows), 1)
    run = loop.batch(
        8.0, varied if tried else {}, runs=count * STAIR_SEEDS, record=("feedback", "actual.force", "output")
    )
    shape = (count, STAIR_SEEDS, -1)
    return Staircase(run.time, *(v.reshape(shape) for v in (filtered(run), run["actual.force"], run["output"])))
