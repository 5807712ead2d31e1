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

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from leadscrew.figures.table import number
from leadscrew.kernel import validate
from leadscrew.kernel.parameters import nearest
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import Crew, Threads
from leadscrew.tune.job import Job, held
from leadscrew.tune.measure import Progress, Samples, same_run
from leadscrew.tune.objective import Constraint, Goal, constraint, contradiction, goal
from leadscrew.tune.space import Space
from leadscrew.tune.statistics import Pair, Standing, bad_plants, paired, per_plant, plain, standing
from leadscrew.tune.tuned import Marks, Tuned, marks
from leadscrew.tune.tuner import BUDGET, Given, Plan, Rounds, done, held_out_plants, plan
from leadscrew.util.errors import LeadscrewError, NameUnknown, ValueRefused, entry_point


@dataclass
class Result:
    """What came of one contender."""

    name: str
    tuned: Tuned | None
    marks: Marks
    standings: dict[str, Standing]
    """By the text of a goal or a constraint's metric."""
    bad: int
    """Unseen plants on which it fails or misses a constraint."""
    samples: Samples = field(repr=False)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        standings = {
            k: {"mean": s.mean._asdict(), "p95": s.p95._asdict(), "worst": s.worst, "judged": s.judged}
            for k, s in self.standings.items()
        }
        return {"name": self.name, "tuned": None if self.tuned is None else self.tuned.as_dict(),
                "scores": self.marks.as_dict(), "metrics": standings, "bad_plants": self.bad}  # fmt: skip


@dataclass
class Comparison:
    """The result, best first."""

    results: tuple[Result, ...]
    pairs: tuple[Pair, ...]
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    over: dict[str, str]
    scenarios: tuple[str, ...]
    unseen: int
    seed: int
    unit: str
    """Of the first goal."""
    budget: int
    plants: int
    optimiser: str
    crew: str = ""
    wall_s: float = 0.0
    units: dict[str, str] = field(default_factory=dict)
    """Of each metric, by its text in the standings; empty for a mere number."""
    integration: dict[str, dict[str, dict[str, Any]]] = field(default_factory=dict)
    """What integrates the plant, by contender and scenario."""
    same_run: bool = False
    """Whether all runs of each contender are the same run: nothing varied, so there is no confidence to state."""

    def sentence(self) -> str:
        """What may be said of it."""
        return sentence(self)

    @property
    def notes(self) -> list[str]:
        """What is to be known besides: of the plants, and of each contender's setting."""
        return nothing_varied(self) + [f"{r.name}: {n}" for r in self.results if r.tuned for n in r.tuned.notes]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        pairs = [
            {"better": p.better, "worse": p.worse, "order": p.order, "difference": p.difference._asdict(),
             "judged": p.judged, "shown": p.shown}
            for p in self.pairs
        ]  # fmt: skip
        return {
            "ranking": [r.name for r in self.results], "pairs": pairs, "results": [r.as_dict() for r in self.results],
            "goals": [str(g) for g in self.goals], "constraints": [str(c) for c in self.constraints],
            "over": self.over, "scenarios": list(self.scenarios), "unseen": self.unseen, "seed": self.seed,
            "budget": self.budget, "plants": self.plants, "optimiser": self.optimiser, "sentence": self.sentence(),
            "notes": self.notes, "units": self.units, "integration": self.integration, "same_run": self.same_run,
            "crew": self.crew, "wall_s": self.wall_s,
        }  # fmt: skip


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
        tuple(made), wanted, kept, other, validate.whole("unseen", unseen, 2, 10**6),
        validate.whole("seed", seed, 0, 2**31 - 1), budget, planned.plants if planned else 0,
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
    from leadscrew.figures.formats import metric_unit

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


@entry_point
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


def sentence(found: Comparison) -> str:
    """What a referee would accept: effort, plants, paired difference with its interval, and what is not shown."""
    best, second = found.results[0], found.results[1]
    pair = found.pairs[0]
    over = ", ".join(f"{k} in {v}" for k, v in found.over.items())
    where = f" in {len(found.scenarios)} scenarios" if len(found.scenarios) > 1 else ""
    runs = (
        "On the machine as it is, in one run without spread"
        if found.same_run
        else f"On {found.unseen} simulated plants that no tuning saw ({over})"
        if over
        else f"In {found.unseen} runs of the machine as it is, which differ in noise alone and which no tuning saw"
    )
    kept = (
        _kept_alone(found, best, second)
        if found.same_run
        else f"{best.name} kept all constraints on {found.unseen - best.bad} of them and {second.name} on "
        f"{found.unseen - second.bad}; "
        if found.constraints
        else f"{best.name} failed on {best.bad} of them and {second.name} on {second.bad}; "
        if best.bad or second.bad
        else ""
    )
    return (
        f"{runs}{where}, {kept}{_difference(found, pair)}; "
        f"{_efforts(found)}; nothing is shown about plants or scenarios outside of these, about the real machine, "
        f"{'or about other seeds or longer tuning' if found.optimiser else 'or about other settings of them'}."
    )


def _kept_alone(found: Comparison, best: Result, second: Result) -> str:
    """What each did in the only run there is."""
    kept, lost = ("kept all constraints", "missed a constraint or failed") if found.constraints else ("ran", "failed")
    if not found.constraints and not (best.bad or second.bad):
        return ""
    return f"{best.name} {lost if best.bad else kept} and {second.name} {lost if second.bad else kept}; "


def nothing_varied(found: Comparison) -> list[str]:
    """Says that all runs of a contender are the same run; nothing where they are not."""
    if not found.same_run:
        return []
    return [
        f"all {found.unseen} runs of each controller are the same run, bit for bit: nothing varies from plant to plant "
        "and no noise reaches a metric, so there is no confidence to state; name what varies with --over"
    ]


def confidence(found: Comparison) -> str:
    """What the worst run seen says of those not seen; empty where nothing varied."""
    if found.same_run:
        return ""
    most = 100.0 * worse_than_seen(found.unseen)
    others = "all plants" if found.over else "all runs of this machine"
    return f"With 95 % confidence at most {most:.2g} % of {others} are worse than the worst one seen"


def _difference(found: Comparison, pair: Pair) -> str:
    goal = found.goals[0]
    what = f"{goal.metric}{f' in {goal.scenario}' if goal.scenario else ''}"
    d, unit = pair.difference, f" {found.unit}" if found.unit else ""
    if not pair.judged:
        return f"{what} could not be compared, because on no plant both could be judged"
    if found.same_run or math.isnan(d.low):
        relation = "equal to" if d.value == 0.0 else "smaller than" if d.value < 0.0 else "larger than"
        on = "" if found.same_run else " on the one plant on which both could be judged, which shows no spread"
        by = f" by {number(abs(d.value))}{unit}" if d.value else ""
        return f"the {what} of {pair.better} was {relation} that of {pair.worse}{by}{on}"
    numbers = f"{number(d.value)}{unit} (95 % interval {number(d.low)} to {number(d.high)})"
    of = "plants" if found.over else "runs"
    paired = f"paired over the {pair.judged} {of} on which both could be judged, {numbers}"
    if d.low <= 0.0 <= d.high:
        return f"no difference in the mean {what} is shown between {pair.better} and {pair.worse}: {paired}"
    relation = "smaller" if d.value < 0.0 else "larger"
    return f"the mean {what} of {pair.better} was {relation} than that of {pair.worse}: {paired}"


def _efforts(found: Comparison) -> str:
    tuned = [r for r in found.results if r.tuned]
    plain = [r.name for r in found.results if not r.tuned]
    parts = []
    if tuned:
        who = "each contender was" if not plain else " and ".join(r.name for r in tuned)
        who += "" if not plain else " were each" if len(tuned) > 1 else " was"
        used = ", ".join(str(r.tuned.used) for r in tuned if r.tuned)
        plants = f"{found.plants} other plant{'s' if found.plants > 1 else ''}"
        parts.append(
            f"{who} tuned once with {found.budget} evaluations at most ({used} used) by {found.optimiser} on "
            f"{plants}, seed {found.seed}"
        )
    if plain:
        parts.append(f"{' and '.join(plain)} {'were' if len(plain) > 1 else 'was'} taken without tuning")
    return ", ".join(parts)


def worse_than_seen(unseen: int) -> float:
    """The part of all plants that may be worse than the worst seen, with 95 % confidence at most."""
    return float(1.0 - 0.05 ** (1.0 / unseen))
