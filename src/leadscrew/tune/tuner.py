"""Tuning: the best setting of a loop's parameters over many plants and scenarios, found by whole populations.

A generation is one set of runs: every setting of the population on every training plant in every scenario. Held-out
plants are drawn from the same ranges with another seed, and are run once, when the search is over. Run ``k`` of a
generation has the noise number ``k`` in every generation; scores of single settings all use the same noise.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.kernel import validate
from leadscrew.tune import optimisers
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import Crew, Threads
from leadscrew.tune.job import Job, chunks_of
from leadscrew.tune.measure import Progress, Samples, measure
from leadscrew.tune.objective import Constraint, Goal, constraint, contradiction, goal, score
from leadscrew.tune.space import Choice, Distribution, Given, Range, Space, cube
from leadscrew.tune.tuned import Generation, Marks, Member, Tuned, marks
from leadscrew.util.errors import Diverged, LeadscrewError, ValueRefused, entry_point

PLANTS, HELD_OUT, BUDGET = 16, 64, 400
"""What is taken unless given."""
CORNERS = 3
"""Ranges up to which the corners of their box are training plants."""

END = 0.02
"""Part of a range that counts as its end."""


def seed_of(seed: int, part: int) -> int:
    """A seed of one part of a tuning: 1 training plants, 2 held-out plants, 3 unseen plants of a comparison."""
    return int(np.random.SeedSequence([seed, part]).generate_state(1)[0])


def training(over: Space, count: int, seed: int) -> dict[str, np.ndarray]:
    """Training plants: the corners of the ranges where these are few, and a Latin hypercube."""
    points = np.zeros((0, len(over)))
    plain = all(isinstance(d, Range | Choice) for _, d in over.items)
    if 0 < len(over) <= CORNERS and plain and count > 2 ** len(over):
        points = np.array(list(product((0.0, 1.0), repeat=len(over))))
    rest = cube(count - len(points), len(over), seed_of(seed, 1))
    return over.values(np.vstack([points, rest]))


def held_out_plants(over: Space, count: int, seed: int, part: int = 2) -> dict[str, np.ndarray]:
    """Plants that no search sees: a Latin hypercube of another seed."""
    return over.values(cube(count, len(over), seed_of(seed, part)))


def at_ends(vary: Space, values: Mapping[str, float]) -> tuple[str, ...]:
    """A sentence for each value at an end of its range: there the best may lie beyond. Of a choice there is no end."""
    found = []
    for key, dist in vary.items:
        if not isinstance(dist, Range) or (dist.whole and dist.high - dist.low < 2.0):
            continue
        unit = dist.unit(values[key])
        near = END if not dist.whole else 0.75 / (dist.high - dist.low + 1.0)
        end = "lower" if unit <= near else "upper" if unit >= 1.0 - near else ""
        if end:
            found.append(
                f"{key} = {values[key]:.6g} is at the {end} end of its range {dist}: the best may lie beyond it"
            )
    return tuple(found)


@dataclass(frozen=True)
class Plan:
    """A tuning before it is done: everything checked."""

    job: Job
    vary: Space
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    over: Space
    plants: int
    held_out: int
    budget: int
    optimiser: str
    seed: int

    def question(self) -> dict[str, Any]:
        """What a journal of this tuning answers: all that decides its numbers."""
        return {
            "what": "tune", "job": self.job.mark, "scenarios": list(self.job.where),
            "vary": {k: repr(d) for k, d in self.vary.items}, "over": {k: repr(d) for k, d in self.over.items},
            "goals": [str(g) for g in self.goals], "constraints": [repr(c) for c in self.constraints],
            "plants": self.plants, "held_out": self.held_out, "budget": self.budget, "optimiser": self.optimiser,
            "seed": self.seed, "versions": optimisers.versions(self.optimiser),
        }  # fmt: skip

    @property
    def runs(self) -> int:
        """Runs of the search and of the scores, at most; scores of a front come on top."""
        scored = 2 * (self.plants + self.held_out)
        return (self.budget * self.plants + scored) * len(self.job.where)


def plan(
    job: Job,
    vary: Given,
    goals: Sequence[str | Goal],
    constraints: Sequence[str | Constraint] = (),
    *,
    over: Given | None = None,
    plants: int | None = None,
    held_out: int | None = None,
    budget: int = BUDGET,
    optimiser: str | None = None,
    seed: int = 0,
) -> Plan:
    """Checks what a tuning is asked for; see :func:`tune`.

    Raises:
        LeadscrewError: one sentence about what cannot be.
    """
    space, other = Space.of(vary), Space.of(over or {})
    if not len(space):
        raise ValueRefused("--vary is missing: say which parameters may change, as KEY=LOW:HIGH")
    if not goals:
        raise ValueRefused("--minimise is missing: say which metric to minimise")
    wanted = tuple(goal(g) for g in goals)
    kept = tuple(constraint(c) for c in constraints)
    for text in [str(w) for w in (*wanted, *kept)]:
        if [str(w) for w in (*wanted, *kept)].count(text) > 1:
            raise ValueRefused(f"{text}: given twice")
    sheet = job.sheet()
    space, other = space.checked(sheet, "--vary"), other.checked(sheet, "--over")
    both = [k for k in space.keys if k in other.keys]
    if both:
        raise ValueRefused(f"{both[0]}: a key is either varied (--vary) or sampled (--over), not both")
    for w in (*wanted, *kept):
        w.check(job)
    if clash := contradiction(kept):
        raise ValueRefused(clash)
    name = optimiser or ("cma" if len(wanted) == 1 else "nsga2")
    optimisers.check(name, len(wanted), budget)
    return Plan(
        job, space, wanted, kept, other,
        validate.whole("plants", plants if plants is not None else PLANTS if len(other) else 1, 1, 10**6),
        validate.whole("held_out", held_out if held_out is not None else HELD_OUT if len(other) else 1, 1, 10**6),
        validate.whole("budget", budget, 1, 10**9), name, validate.whole("seed", seed, 0, 2**31 - 1),
    )  # fmt: skip


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


HELD_OUT_NOISE = 1_000_000
"""Number of the first held-out run: its noise."""
MEMBERS = 24
"""Settings of a front that are shown and scored on held-out plants."""


class Rounds:
    """Sets of runs one after the other, whose chunks count on in the journal."""

    def __init__(self, job: Job, crew: Crew, journal: Journal | None, progress: Progress | None, runs: int) -> None:
        self.job, self.crew, self.journal, self.progress = job, crew, journal, progress
        self.start, self.finished, self.runs = 0, 0, runs

    def measure(self, columns: Mapping[str, np.ndarray], first: int = 0) -> Samples:
        """One set of runs."""

        def report(done: int, _: int) -> None:
            if self.progress is not None:
                self.progress(self.finished + done, max(self.runs, self.finished + done))

        found = measure(self.job, columns, self.crew, first=first, journal=self.journal, start=self.start,
                        progress=report)  # fmt: skip
        self.start += len(chunks_of(self.job, columns, first))
        self.finished += len(found) * len(self.job.where)
        return found


def crossed(settings: Mapping[str, np.ndarray], plants: Mapping[str, np.ndarray], count: int) -> dict[str, np.ndarray]:
    """Every setting on every plant, one run after the other; ``count`` plants."""
    members = len(next(iter(settings.values())))
    return {k: np.repeat(v, count) for k, v in settings.items()} | {k: np.tile(v, members) for k, v in plants.items()}


class Seen:
    """All settings that a search asked for, and what they were worth."""

    def __init__(self, asked: Plan, rounds: Rounds) -> None:
        self.plan, self.rounds = asked, rounds
        self.plants = training(asked.over, asked.plants, asked.seed)
        d, g = len(asked.vary), len(asked.goals)
        self.units, self.objectives = np.zeros((0, d)), np.zeros((0, g))
        self.violation, self.failed, self.diverged = (np.zeros(0) for _ in range(3))
        self.history: list[Generation] = []

    def evaluate(self, units: np.ndarray) -> optimisers.Answer:
        """One population."""
        asked = self.plan
        columns = crossed(asked.vary.values(units), self.plants, asked.plants)
        found = score(self.rounds.measure(columns), asked.plants, asked.goals, asked.constraints)
        self.units = np.vstack([self.units, units])
        self.objectives = np.vstack([self.objectives, found.objectives])
        self.violation = np.concatenate([self.violation, found.violation])
        self.failed = np.concatenate([self.failed, found.failed])
        self.diverged = np.concatenate([self.diverged, found.diverged])
        at = self.best()
        allowed = self.violation <= 0.0
        goals = self.objectives[allowed].min(axis=0) if allowed.any() else self.objectives[at]
        self.history.append(
            Generation(len(self.units), tuple(map(float, goals)), float(self.violation[at]),
                       int((found.violation <= 0.0).sum()))
        )  # fmt: skip
        return optimisers.Answer(found.objectives, found.violations)

    def best(self) -> int:
        """The setting with the smallest violation, then the smallest goal; with several goals the compromise."""
        allowed = self.violation <= 0.0
        if len(self.plan.goals) > 1 and allowed.any():
            kept = front(self.objectives, allowed)
            return int(kept[compromise(self.objectives[kept])])
        return int(np.lexsort((self.objectives[:, 0], np.maximum(self.violation, 0.0)))[0])

    def front(self) -> list[int]:
        """Some settings along the front; none with one goal."""
        allowed = self.violation <= 0.0
        if len(self.plan.goals) < 2 or not allowed.any():
            return []
        kept = front(self.objectives, allowed)
        return [int(i) for i in kept[thinned(self.objectives[kept], MEMBERS)]]


def run(
    asked: Plan, crew: Crew | None = None, journal: Journal | None = None, progress: Progress | None = None
) -> Tuned:
    """Does what was planned; see :func:`tune`."""
    return done(asked, Rounds(asked.job, crew or Threads(), journal, progress, asked.runs))


def done(asked: Plan, rounds: Rounds) -> Tuned:
    """Does what was planned, as some rounds of several."""
    began, before_runs = time.perf_counter(), rounds.finished
    job, vary = asked.job, asked.vary
    seen = Seen(asked, rounds)
    sheet = job.loop(job.where[0]).sheet
    present = {k: float(sheet[k].stored(sheet[k].default)) for k in vary.keys}
    grain = np.array([_grain(d) for _, d in vary.items])
    search = optimisers.Search(
        seen.evaluate,
        vary.units(present),
        asked.budget,
        asked.seed,
        len(asked.goals),
        len(asked.constraints) + 1,
        grain,
    )
    optimisers.OPTIMISERS[asked.optimiser][0](search)
    _refuse_hopeless(asked, seen)
    others = held_out_plants(asked.over, asked.held_out, asked.seed)

    def scored(values: Mapping[str, float]) -> tuple[Marks, Marks, Samples]:
        one = {k: np.array([v]) for k, v in values.items()}
        near = rounds.measure(crossed(one, seen.plants, asked.plants))
        far = rounds.measure(crossed(one, others, asked.held_out), first=HELD_OUT_NOISE)
        return marks(near, asked.goals, asked.constraints), marks(far, asked.goals, asked.constraints), far

    def named(values: Mapping[str, float]) -> dict[str, Any]:
        return {k: v if sheet[k].choice is None else sheet[k].check(v) for k, v in values.items()}

    def values_at(i: int) -> dict[str, float]:
        return {k: float(v[0]) for k, v in vary.values(seen.units[i : i + 1]).items()}

    best, members = seen.best(), []
    before, before_far, before_samples = scored(present)
    trained, far, far_samples = scored(values_at(best))
    for i in seen.front():
        near_i, far_i = (trained, far) if i == best else scored(values_at(i))[:2]
        members.append(Member(named(values_at(i)), near_i, far_i, i == best))
    subject = job.experiment
    return Tuned(
        subject.study, subject.controller or "", job.where, {k: str(d) for k, d in vary.items},
        {k: str(d) for k, d in asked.over.items}, asked.goals, asked.constraints, named(values_at(best)),
        named(present), before, before_far, trained, far, tuple(seen.history), tuple(members), asked.plants,
        asked.held_out, asked.budget, len(seen.units), asked.optimiser, asked.seed,
        optimisers.versions(asked.optimiser),
        at_ends(vary, values_at(best)), rounds.crew.name,
        time.perf_counter() - began, rounds.finished - before_runs, {"before": before_samples, "tuned": far_samples},
        job.integration,
    )  # fmt: skip


def _grain(dist: Distribution) -> float:
    if isinstance(dist, Choice):
        return 1.0 / len(dist.values)
    return 1.0 / (dist.high - dist.low + 1.0) if isinstance(dist, Range) and dist.whole else 0.0


def _refuse_hopeless(asked: Plan, seen: Seen) -> None:
    each = asked.plants * len(asked.job.where)
    if (seen.diverged == each).all():
        raise Diverged(f"every run of all {len(seen.units)} settings diverged: vary other parameters, or less far")
    if (seen.failed == each).all():
        names = list(dict.fromkeys(w.metric for w in (*asked.goals, *asked.constraints)))
        first = asked.vary.values(seen.units[:1]) | seen.plants
        reasons = asked.job.reasons(asked.job.where[0], {k: v[0] for k, v in first.items()}, 0)
        why = "".join(f"; in the first run {n} has no value: {reasons[n]}" for n in names if n in reasons)
        raise LeadscrewError(
            f"not one run of {len(seen.units)} settings could be judged ({', '.join(names)}){why}; vary other "
            "parameters, or run longer"
        )


@entry_point
def tune(
    job: Job,
    vary: Given,
    goals: Sequence[str | Goal],
    constraints: Sequence[str | Constraint] = (),
    *,
    over: Given | None = None,
    plants: int | None = None,
    held_out: int | None = None,
    budget: int = BUDGET,
    optimiser: str | None = None,
    seed: int = 0,
    crew: Crew | None = None,
    journal: Journal | str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Tuned:
    """Finds the best setting of the parameters that ``vary``; the same whatever the crew.

    Args:
        job: the controller on its machine, and the scenarios.
        vary: what may change: ``{key: (low, high)}``, distributions, or texts as on the command line.
        goals: metrics to minimise; several give a Pareto front.
        constraints: as ``"overshoot<=0.02"``.
        over: what differs from plant to plant; the loop as it is unless given.
        plants: how many the search sees: 16 with ``over``, else 1; more without ``over`` repeat the noise.
        held_out: how many it never sees: 64 with ``over``, else 1.
        budget: evaluations at most; a setting on all its plants and scenarios is one.
        optimiser: ``cma``, ``de``, ``nsga2``, ``scipy``; cma for one goal and nsga2 for several unless given.
        seed: of the plants and the search.
        crew: who does the work; all cores unless given.
        journal: a folder for results as they come.
        resume: what the journal holds is not done again.
        progress: takes the runs done and all of them.

    Raises:
        LeadscrewError: one sentence about what cannot be.
    """
    asked = plan(job, vary, goals, constraints, over=over, plants=plants, held_out=held_out, budget=budget,
                 optimiser=optimiser, seed=seed)  # fmt: skip
    kept = Journal(journal, asked.question(), resume) if isinstance(journal, str | Path) else journal
    return run(asked, crew, kept, progress)
