"""Comparison: several controllers, each tuned with the same budget, on the same plants that none of them saw.

Each contender that has something to vary is tuned by the same optimiser on the same training plants with the same
seed; one that has not is taken as it is. All are then run on the same unseen plants with the same noise, so that
differences are paired by plant. Per plant a metric is its worst over the scenarios (for goals that ask for the mean:
the mean over them).

A contender is better than another if it has fewer plants on which it fails or misses a worst-case constraint; where
these are as many, if its first goal is smaller in the mean over the plants that it was judged on. Intervals and the
probability of an order are those of a bootstrap over plants with a fixed seed, the same plants for all contenders in
each resample. Of the worst plant seen there is no interval: a bootstrap has none for a maximum.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from leadscrew.kernel import door
from leadscrew.kernel.errors import LeadscrewError, NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest
from leadscrew.tune.compare_result import Comparison, Result
from leadscrew.tune.compare_statistics import bad_plants, paired, per_plant, plain, standing
from leadscrew.tune.crew import Crew, Threads
from leadscrew.tune.job import Job, held
from leadscrew.tune.journal import Journal
from leadscrew.tune.measure import Progress, Samples, same_run
from leadscrew.tune.objective import Constraint, Goal, constraint, contradiction, goal
from leadscrew.tune.space import Space
from leadscrew.tune.tuned import Tuned, marks
from leadscrew.tune.tuner import Rounds, done
from leadscrew.tune.tuner_plan import BUDGET, Given, Plan, held_out_plants, plan

UNSEEN = 200
"""Plants of a comparison unless given."""
UNSEEN_NOISE = 2_000_000
"""Number of the first unseen run: its noise."""
PART = 3
"""Which seed of a tuning draws the unseen plants."""


@dataclass(frozen=True)
class Contender:
    """A controller in a comparison."""

    name: str
    job: Job
    plan: Plan | None
    """How it is tuned; none where it is taken as it is."""


@dataclass(frozen=True)
class Contest:
    """A comparison before it is done: everything checked."""

    contenders: tuple[Contender, ...]
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    over: Space
    unseen: int
    seed: int
    budget: int
    plants: int
    optimiser: str

    def question(self) -> dict[str, Any]:
        """What a journal of this comparison answers."""
        each = [{"name": c.name, "job": c.job.mark, "plan": c.plan.question() if c.plan else None}
                for c in self.contenders]  # fmt: skip
        return {"what": "compare", "contenders": each, "unseen": self.unseen, "seed": self.seed,
                "over": {k: repr(d) for k, d in self.over.items}}  # fmt: skip

    @property
    def runs(self) -> int:
        """Runs of all searches and scores, at most."""
        tuning = sum(c.plan.runs for c in self.contenders if c.plan)
        return tuning + sum(self.unseen * len(c.job.where) for c in self.contenders)


def contest(
    job: Job,
    controllers: Sequence[str],
    goals: Sequence[str | Goal],
    constraints: Sequence[str | Constraint] = (),
    *,
    vary: Mapping[str, Given] | None = None,
    over: Given | None = None,
    plants: int | None = None,
    unseen: int = UNSEEN,
    budget: int = BUDGET,
    optimiser: str | None = None,
    seed: int = 0,
) -> Contest:
    """Checks what a comparison is asked for; see :func:`compare`.

    Raises:
        LeadscrewError: one sentence about what cannot be.
    """
    if len(controllers) < 2:
        raise ValueRefused("a comparison needs two controllers or more: -c A -c B")
    for name in controllers:
        if list(controllers).count(name) > 1:
            raise ValueRefused(f"{name}: given twice")
    spaces = dict(vary or {})
    for name in spaces:
        if name not in controllers:
            raise NameUnknown(f"--vary: no contender is called {name!r}{nearest(name, list(controllers))}")
    wanted, kept = tuple(map(goal, goals)), tuple(map(constraint, constraints))
    if not wanted:
        raise ValueRefused("--minimise is missing: say by which metric to rank")
    if clash := contradiction(kept):
        raise ValueRefused(clash)
    other = Space.of(over or {})
    made = []
    for name in controllers:
        one = replace(job, experiment=replace(job.experiment, controller=name))
        with of(name):
            for w in (*wanted, *kept):
                w.check(one)
            other = other.checked(one.sheet(), "--over")
            asked = plan(
                one, spaces[name], wanted, kept, over=over, plants=plants, budget=budget, optimiser=optimiser, seed=seed
            ) if name in spaces else None  # fmt: skip
        made.append(Contender(name, one, asked))
    planned = next((c.plan for c in made if c.plan), None)
    return Contest(
        tuple(made), wanted, kept, other, door.whole("unseen", unseen, 2, 10**6),
        door.whole("seed", seed, 0, 2**31 - 1), budget, planned.plants if planned else 0,
        planned.optimiser if planned else "",
    )  # fmt: skip


@contextmanager
def of(name: str) -> Iterator[None]:
    """Errors inside say whose they are."""
    try:
        yield
    except LeadscrewError as error:
        raise type(error)(f"{name}: {error}") from None


def run(
    asked: Contest, crew: Crew | None = None, journal: Journal | None = None, progress: Progress | None = None
) -> Comparison:
    """Does what was planned; see :func:`compare`."""
    began = time.perf_counter()
    workers = crew or Threads()
    plants = held_out_plants(asked.over, asked.unseen, asked.seed, PART)
    measured: list[tuple[Contender, Tuned | None, Samples]] = []
    start = finished = 0
    for one in asked.contenders:
        rounds = Rounds(one.job, workers, journal, progress, asked.runs)
        rounds.start, rounds.finished = start, finished
        with of(one.name):
            tuned = done(one.plan, rounds) if one.plan else None
        settings = tuned.values if tuned else {}
        sheet = one.job.sheet() if settings else {}
        fixed = {k: np.full(asked.unseen, float(sheet[k].stored(v))) for k, v in settings.items()}
        columns = (fixed or held(one.job, asked.unseen)) | plants
        measured.append((one, tuned, rounds.measure(columns, first=UNSEEN_NOISE)))
        start, finished = rounds.start, rounds.finished
    return judged(asked, measured, workers.name, time.perf_counter() - began)


def judged(
    asked: Contest, measured: Sequence[tuple[Contender, Tuned | None, Samples]], crew: str, wall_s: float
) -> Comparison:
    """The ranking of what was measured."""
    from leadscrew.report.tables import metric_unit

    same = all(same_run(samples, asked.over.keys) for _, _, samples in measured)
    results, firsts, bads = [], {}, {}
    for one, tuned, samples in measured:
        found = marks(samples, asked.goals, asked.constraints)
        bad = bad_plants(samples, asked.goals, asked.constraints)
        wanted = {plain(w): w for w in (*asked.goals, *asked.constraints)}
        values = {k: per_plant(w, samples) for k, w in wanted.items()}
        firsts[one.name], bads[one.name] = values[plain(asked.goals[0])], bad
        standings = {k: standing(v, asked.seed, wanted[k].upper, same) for k, v in values.items()}
        results.append(Result(one.name, tuned, found, standings, int(bad.sum()), samples))
    first = plain(asked.goals[0])
    results.sort(key=lambda r: (r.bad, np.nan_to_num(r.standings[first].mean.value, nan=np.inf)))
    pairs = [
        paired(a.name, b.name, firsts[a.name], firsts[b.name], bads[a.name], bads[b.name], asked.seed, same)
        for a, b in pairwise(results)
    ]
    one = asked.contenders[0]
    loop = one.job.loop(one.job.where[0])
    units = {plain(w): metric_unit(loop, loop.metrics[w.metric]) for w in (*asked.goals, *asked.constraints)}
    units = {k: "" if u == "1" else u for k, u in units.items()}
    return Comparison(
        tuple(results), tuple(pairs), asked.goals, asked.constraints, {k: str(d) for k, d in asked.over.items},
        one.job.where, asked.unseen, asked.seed, units[first], asked.budget, asked.plants,
        asked.optimiser, crew, wall_s, units, {c.name: c.job.integration for c in asked.contenders}, same,
    )  # fmt: skip


def compare(
    job: Job,
    controllers: Sequence[str],
    goals: Sequence[str | Goal],
    constraints: Sequence[str | Constraint] = (),
    *,
    crew: Crew | None = None,
    journal: Journal | None = None,
    progress: Progress | None = None,
    **more: Any,
) -> Comparison:
    """Compares controllers on plants that no tuning saw.

    Args:
        job: study, scenarios and changes; its controller does not count.
        controllers: names, as ``Experiment`` takes them.
        goals: what each is tuned for; the first one ranks.
        constraints: what is to be kept.
        crew: who does the work; all cores unless given.
        journal: results as they come, for :meth:`Contest.question`.
        progress: takes the runs done and all of them.
        more: ``vary`` by contender, ``over``, ``plants``, ``unseen``, ``budget``, ``optimiser``, ``seed``; as for
            :func:`leadscrew.tune.tuner.tune`.

    Raises:
        LeadscrewError: one sentence about what cannot be.
    """
    return run(contest(job, controllers, goals, constraints, **more), crew, journal, progress)
