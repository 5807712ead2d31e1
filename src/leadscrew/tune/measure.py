"""Many runs, done: by a crew, kept in a journal, put together in their order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import Crew, Result
from leadscrew.tune.job import DIVERGED, Chunk, Job, chunks_of
from leadscrew.util.errors import NameUnknown

Progress = Callable[[int, int], None]
"""Takes the runs that are done and all of them."""


def done(
    job: Job,
    chunks: Sequence[Chunk],
    crew: Crew,
    journal: Journal | None = None,
    start: int = 0,
    progress: Progress | None = None,
) -> list[Result]:
    """The results of chunks, in their order; those that the journal has are not done again.

    ``start`` is the number of the first one in the journal: a question of several rounds counts on.
    """
    found: dict[int, Result] = {}
    if journal is not None:
        for i in range(len(chunks)):
            kept = journal.get(start + i)
            if kept is not None:
                found[i] = kept
    runs = sum(c.runs for c in chunks)
    finished = sum(chunks[i].runs for i in found)
    if progress is not None:
        progress(finished, runs)
    missing = [(i, chunk) for i, chunk in enumerate(chunks) if i not in found]
    for i, result in crew.results(job, missing) if missing else ():
        found[i] = result
        if journal is not None:
            journal.put(start + i, result)
        finished += chunks[i].runs
        if progress is not None:
            progress(finished, runs)
    return [found[i] for i in range(len(chunks))]


@dataclass
class Samples:
    """Many runs in one or several scenarios."""

    columns: dict[str, np.ndarray]
    """What varied, one value a run."""
    metrics: dict[str, dict[str, np.ndarray]]
    """By scenario and metric, one value a run; NaN where a run diverged or the metric could not judge."""
    diverged_at: dict[str, np.ndarray]
    """By scenario: seconds, NaN where a run did not diverge."""

    def __len__(self) -> int:
        return len(next(iter(self.diverged_at.values())))

    @property
    def scenarios(self) -> tuple[str, ...]:
        """The scenarios."""
        return tuple(self.metrics)

    def metric(self, name: str) -> np.ndarray:
        """A metric ``[scenario, run]``.

        Raises:
            NameUnknown: there is none; names the nearest.
        """
        for values in self.metrics.values():
            if name not in values:
                raise NameUnknown(f"there is no metric {name!r}{nearest(name, list(values))}")
        return np.array([values[name] for values in self.metrics.values()])

    def as_columns(self) -> dict[str, np.ndarray]:
        """A flat table, one row a run and scenario: what varied, scenario, metrics, when it diverged."""
        count = len(self.scenarios)
        table: dict[str, Any] = {
            "run": np.tile(np.arange(len(self)), count),
            "scenario": np.repeat(np.array(self.scenarios), len(self)),
        }
        table |= {k: np.tile(v, count) for k, v in self.columns.items()}
        names = next(iter(self.metrics.values()))
        table |= {m: self.metric(m).ravel() for m in names}
        return {**table, DIVERGED: np.concatenate(list(self.diverged_at.values()))}


def measure(
    job: Job,
    columns: Mapping[str, np.ndarray],
    crew: Crew,
    *,
    first: int = 0,
    journal: Journal | None = None,
    start: int = 0,
    progress: Progress | None = None,
) -> Samples:
    """All runs of a job: every set of values in every scenario."""
    chunks = chunks_of(job, columns, first)
    results = done(job, chunks, crew, journal, start, progress)
    metrics: dict[str, dict[str, np.ndarray]] = {}
    lost: dict[str, np.ndarray] = {}
    for scenario in job.where:
        parts = [r for c, r in zip(chunks, results, strict=True) if c.scenario == scenario]
        joined = {k: np.concatenate([p[k] for p in parts]) for k in parts[0]}
        lost[scenario] = joined.pop(DIVERGED)
        metrics[scenario] = joined
    return Samples({k: np.asarray(v) for k, v in columns.items()}, metrics, lost)


def identical(samples: Samples) -> bool:
    """Whether all runs gave the same bits in every scenario."""
    columns = [*samples.diverged_at.values(), *(v for found in samples.metrics.values() for v in found.values())]
    return all(bool((bits == bits[0]).all()) for bits in (np.asarray(c, np.float64).view(np.uint64) for c in columns))


def same_run(samples: Samples, varied: Sequence[str]) -> bool:
    """Whether several runs are the same run: no parameter that may vary did, and no noise reached a metric."""
    drawn = [samples.columns.get(k) for k in varied]
    return len(samples) > 1 and identical(samples) and all(v is not None and bool((v == v[0]).all()) for v in drawn)
