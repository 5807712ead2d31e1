"""Monte Carlo: many runs of a loop whose parameters are distributed; what its metrics then are.

Run ``k`` has the parameters of sample ``k`` and the noise of run ``k``: it is
``loop.using({key: columns[key][k]}).run(duration, replicate=k)``, wherever it was done.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel import door
from leadscrew.tune.crew import Crew, Threads
from leadscrew.tune.failures import Separation, separations
from leadscrew.tune.job import Job, chunks_of, held
from leadscrew.tune.journal import Journal
from leadscrew.tune.measure import Progress, Samples, measure, same_run
from leadscrew.tune.montecarlo_tolerances import Tolerance, tolerances
from leadscrew.tune.sensitivity import RankCorrelation, rank_correlations
from leadscrew.tune.space import Given, Method, Space, check_method
from leadscrew.tune.statistics import Spread, Yield, spread, without_intervals, yielded

LARGEST = 2**31 - 1
"""Most runs: the noise has no more numbers."""


class WithoutValue(NamedTuple):
    """A metric that some runs of a scenario give no value for."""

    scenario: str
    metric: str
    runs: int
    """How many did not diverge and gave none."""
    first: int
    """Number of the first such run."""
    reason: str
    """Why it gave none in that run."""


@dataclass
class MonteCarlo:
    """The runs and what follows from them."""

    job: Job
    space: Space
    method: Method
    seed: int
    tolerances: tuple[Tolerance, ...]
    samples: Samples
    wall_s: float = 0.0
    """Seconds that the runs took, without those that a journal had already."""

    def __len__(self) -> int:
        return len(self.samples)

    @cached_property
    def spreads(self) -> tuple[Spread, ...]:
        """Percentiles of every metric in every scenario, metric by metric."""
        rows = spreads(self.samples, self.metrics)
        return tuple(map(without_intervals, rows)) if self.alike else rows

    @property
    def metrics(self) -> tuple[str, ...]:
        """The metrics that all scenarios have."""
        return self.job.metrics()

    @cached_property
    def yields(self) -> dict[str, Yield]:
        """The yield of each tolerance by its text."""
        return {str(t): yielded(t.passes(self.samples), alike=self.alike) for t in self.tolerances}

    @cached_property
    def passes(self) -> np.ndarray:
        """Which runs keep every tolerance and diverge nowhere."""
        return passes(self.samples, self.tolerances)

    @cached_property
    def joint(self) -> Yield:
        """The yield against all tolerances together; without any, of runs that did not diverge."""
        return yielded(self.passes, alike=self.alike)

    @cached_property
    def alike(self) -> bool:
        """Whether all runs are the same run: nothing drawn differs, and no noise made one bit of a difference."""
        return same_run(self.samples, self.space.keys)

    @cached_property
    def without_value(self) -> tuple[WithoutValue, ...]:
        """Metrics without a value in runs that did not diverge, each with the reason in the first such run."""
        found = []
        for scenario, metrics in self.samples.metrics.items():
            ran = np.isnan(self.samples.diverged_at[scenario])
            lost = {m: np.flatnonzero(np.isnan(v) & ran) for m, v in metrics.items()}
            firsts = {int(runs[0]) for runs in lost.values() if len(runs)}
            reasons = {
                k: self.job.reasons(scenario, {n: v[k] for n, v in self.samples.columns.items()}, k) for k in firsts
            }
            found += [
                WithoutValue(scenario, m, len(runs), int(runs[0]), reasons[int(runs[0])].get(m, ""))
                for m, runs in lost.items()
                if len(runs)
            ]
        return tuple(found)

    @cached_property
    def diverged(self) -> np.ndarray:
        """Which runs diverged in some scenario."""
        return ~kept_on(self.samples)

    @cached_property
    def correlations(self) -> tuple[RankCorrelation, ...]:
        """Of each parameter with each metric."""
        columns = self.samples.columns
        return tuple(
            row
            for m in self.metrics
            for s in self.samples.scenarios
            for row in rank_correlations(columns, self.samples.metrics[s][m], m, s)
        )

    @cached_property
    def failures(self) -> tuple[Separation, ...]:
        """How each parameter separates failed from passed runs, tolerance by tolerance."""
        return separations(self)


def spreads(samples: Samples, metrics: Sequence[str]) -> tuple[Spread, ...]:
    """Percentiles of metrics in every scenario, metric by metric."""
    found, lost = samples.metrics, samples.diverged_at
    return tuple(spread(s, m, found[s][m], lost[s]) for m in metrics for s in samples.scenarios)


def kept_on(samples: Samples) -> np.ndarray:
    """Which runs diverged in no scenario."""
    return np.all([np.isnan(at) for at in samples.diverged_at.values()], axis=0)


def passes(samples: Samples, wanted: Sequence[Tolerance]) -> np.ndarray:
    """Which runs keep every tolerance and diverge nowhere."""
    return np.all([kept_on(samples), *(t.passes(samples) for t in wanted)], axis=0)


def montecarlo(
    job: Job,
    over: Given | Space | None,
    runs: int,
    *,
    seed: int = 0,
    method: Method = "lhs",
    tolerances: Sequence[str | Tolerance] = (),
    crew: Crew | None = None,
    journal: Journal | str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> MonteCarlo:
    """Runs of a job with its parameters drawn from distributions; of the noise alone where none is given.

    Args:
        job: what runs.
        over: what varies: ``{key: (low, high)}``, distributions, or texts as on the command line.
        runs: how many, in every scenario.
        seed: of the samples; the noise has the seed of the job's experiment.
        method: ``lhs``, ``sobol`` or ``random``.
        tolerances: what a run must keep, see :func:`~leadscrew.tune.montecarlo_tolerances.tolerance`.
        crew: who does the work; all cores unless given.
        journal: a folder for results as they come.
        resume: what the journal holds is not done again.
        progress: takes the runs that are done and all of them.

    Raises:
        LeadscrewError: a name that does not exist, a value that is refused, tolerances that contradict each other.
    """
    space = Space.of(over)
    wanted = check(job, space, runs, tolerances)
    check_method(method)
    kept = opened(journal, question(job, space, runs, seed, method), resume)
    began = time.perf_counter()
    columns = drawn(job, space, runs, seed, method)
    samples = measure(job, columns, crew or Threads(), journal=kept, progress=progress)
    samples.columns = {k: samples.columns[k] for k in space.keys}
    return MonteCarlo(job, space, method, seed, wanted, samples, time.perf_counter() - began)


def opened(journal: Journal | str | Path | None, asked: dict[str, Any], resume: bool) -> Journal | None:
    """The journal of a question, where a folder is given for it."""
    return Journal(journal, asked, resume) if isinstance(journal, str | Path) else journal


def check(job: Job, space: Space, runs: int, given: Sequence[str | Tolerance] = ()) -> tuple[Tolerance, ...]:
    """The tolerances, after everything was looked at that can be refused before the first run."""
    door.whole("runs", runs, 1, LARGEST)
    space.check(job.sheet(), "--over")
    for scenario in job.where:
        job.loop(scenario).periods(job.seconds(scenario))
    return tolerances(given, job)


def drawn(job: Job, space: Space, runs: int, seed: int, method: Method) -> dict[str, np.ndarray]:
    """What varies, one value a run; where nothing does, a parameter that stays at its own value."""
    return space.sample(runs, seed, method) if len(space) else held(job, runs)


def question(job: Job, space: Space, runs: int, seed: int, method: Method, **more: Any) -> dict[str, Any]:
    """What a journal of a Monte Carlo is about."""
    asked = {"kind": "montecarlo", "job": job.mark, "runs": runs, "seed": seed, "sampling": method}
    return {**asked, "over": [f"{k}={d!r}" for k, d in space.items], **more}


def asked_of(found: MonteCarlo, **more: Any) -> dict[str, Any]:
    """What a journal of further runs of a Monte Carlo is about."""
    return question(found.job, found.space, len(found), found.seed, found.method, **more)


def pieces(job: Job, columns: dict[str, np.ndarray]) -> int:
    """How many numbers of a journal some runs take."""
    return len(chunks_of(job, columns))
