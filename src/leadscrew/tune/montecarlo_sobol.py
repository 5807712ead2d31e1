"""Sobol indices of a loop: runs of their own, through the same crew."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.tune.crew import Crew
from leadscrew.tune.journal import Journal
from leadscrew.tune.measure import Progress, measure
from leadscrew.tune.montecarlo import MonteCarlo
from leadscrew.tune.sensitivity import SobolIndex, sobol


def sobol_indices(
    found: MonteCarlo,
    count: int,
    *,
    crew: Crew,
    journal: Journal | None = None,
    start: int = 0,
    progress: Progress | None = None,
) -> tuple[SobolIndex, ...]:
    """First-order and total indices of each varied parameter, from ``count (parameters + 2)`` runs in every scenario.

    ``start`` is the first number in the journal.

    Raises:
        ValueRefused: nothing varies, or ``count`` is no power of two.
        LeadscrewError: SALib is not installed.
    """

    def evaluate(unit: np.ndarray) -> Mapping[tuple[str, str], np.ndarray]:
        columns = found.space.values(unit)
        samples = measure(found.job, columns, crew, journal=journal, start=start, progress=progress)
        return {(m, s): samples.metrics[s][m] for m in found.metrics for s in samples.scenarios}

    return sobol(evaluate, found.space.keys, count, found.seed)
