"""The camera loses the cut and finds it again: how far the offset moves in one sample then."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.lines import PERIOD_S
from leadscrew.studies.sofnn_tangent.runs import SEED, Loops

LOST_FOR_S = 1.0
LOST_FROM_S = tuple(1.0 + 0.5 * k for k in range(11))
"""One run each, all on the flower in foam."""
AFTER_S = 0.3
"""Watched from when the cut is seen again."""


class Step(NamedTuple):
    """Largest change of the offset from one sample to the next, deg."""

    seen_again: float
    """Within :data:`AFTER_S` after the loss."""
    plain: float
    """In the same runs without a loss, anywhere."""


def resight(loops: Loops, block: Block) -> Step:
    """The largest steps of all runs, with and without a loss."""
    return Step(moved(loops, block), float(changes(loops, block, np.full(len(LOST_FROM_S), 1e9)).max()))


def moved(loops: Loops, block: Block) -> float:
    """The largest step of all runs after the loss, deg."""
    lost = np.array(LOST_FROM_S)
    first = np.round((lost + LOST_FOR_S) / PERIOD_S).astype(int) - 2
    rows = changes(loops, block, lost)
    return max(float(row[k : k + round(AFTER_S / PERIOD_S)].max()) for row, k in zip(rows, first, strict=True))


def changes(loops: Loops, block: Block, lost_from: np.ndarray) -> np.ndarray:
    """Size of the change of the offset from sample to sample, deg, one row a run."""
    scenario = loops.asked("flower_foam")
    loop = loops.get(block, scenario).using(seed=SEED)
    columns = {"sensor.lost_from_s": lost_from, "sensor.lost_for_s": np.full(lost_from.size, LOST_FOR_S)}
    batch = loop.batch(scenario.duration_s, columns, record=("output",))
    return np.asarray(np.abs(np.diff(batch["output"], axis=1)))
