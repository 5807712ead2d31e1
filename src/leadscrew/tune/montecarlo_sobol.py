"""Sobol indices of a loop: runs of their own, through the same crew."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from leadscrew.tune.crew import Crew, Threads
from leadscrew.tune.journal import Journal
from leadscrew.tune.measure import Progress, measure
from leadscrew.tune.montecarlo import MonteCarlo, asked_of, opened
from leadscrew.tune.sensitivity import SobolIndex, check, sobol


def sobol_indices(
    found: MonteCarlo,
    count: int,
    *,
    crew: Crew | None = None,
    journal: Journal | str | Path | None = None,
    resume: bool = False,
    start: int = 0,
    progress: Progress | None = None,
) -> tuple[SobolIndex, ...]:
    """First-order and total indices of each varied parameter, from ``count (parameters + 2)`` runs in every scenario.

    ``crew``, ``journal`` and ``resume`` are those of :func:`~leadscrew.tune.montecarlo.montecarlo`; ``start`` is the
    first number in a journal of several rounds.

    Raises:
        ValueRefused: nothing varies, or ``count`` is no power of two.
        LeadscrewError: SALib is not installed.
    """
    check(len(found.space), count)
    kept = opened(journal, asked_of(found, sobol=count), resume)

    def evaluate(unit: np.ndarray) -> Mapping[tuple[str, str], np.ndarray]:
        columns = found.space.values(unit)
        samples = measure(found.job, columns, crew or Threads(), journal=kept, start=start, progress=progress)
        return {(m, s): samples.metrics[s][m] for m in found.metrics for s in samples.scenarios}

    return sobol(evaluate, found.space.keys, count, found.seed)
