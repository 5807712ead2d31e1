"""What a tuning gives: the setting, its scores on both sets of plants, its history; and the files it leaves."""

from __future__ import annotations

import math
import shlex
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew import controller_file, legacy, names, toml_file
from leadscrew.controller_file import ControllerFile
from leadscrew.experiment import Experiment
from leadscrew.tune.job import Job, typed
from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint, Goal, score


@dataclass(frozen=True)
class Marks:
    """Scores of one setting on some plants."""

    values: dict[str, float]
    """By the text of a goal or constraint; infinite where a run failed."""
    scenarios: dict[str, dict[str, float]]
    """The same in each scenario alone, where it counts."""
    failed: int
    """Runs that diverged or that could not be judged."""
    diverged: int
    runs: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON and TOML."""
        return {"values": self.values, "scenarios": self.scenarios, "failed": self.failed,
                "diverged": self.diverged, "runs": self.runs}  # fmt: skip


def marks(samples: Samples, goals: Sequence[Goal], constraints: Sequence[Constraint]) -> Marks:
    """The scores of one setting from its runs."""
    wanted: tuple[Goal, ...] = (*goals, *constraints)

    def of(asked_goals: Sequence[Goal], asked_constraints: Sequence[Constraint]) -> dict[str, float]:
        found = score(samples, len(samples), asked_goals, asked_constraints)
        numbers = [*found.goals[0], *found.bounded[0]]
        return {str(w): float(x) for w, x in zip(wanted, numbers, strict=True)}

    whole = score(samples, len(samples), goals, constraints)
    alone: dict[str, dict[str, float]] = {}
    for scenario in samples.scenarios:
        found = of(*([replace(w, scenario=scenario) for w in ws] for ws in (goals, constraints)))  # type: ignore[arg-type]
        counted = {str(w) for w in wanted if w.scenario in ("", scenario)}
        alone[scenario] = {k: v for k, v in found.items() if k in counted}
    runs = len(samples) * len(samples.scenarios)
    return Marks(of(goals, constraints), alone, int(whole.failed[0]), int(whole.diverged[0]), runs)


class Generation(NamedTuple):
    """How far a search was after one of its populations."""

    evaluations: int
    """So far."""
    best: tuple[float, ...]
    """The goals of the best setting so far; of several goals the best of each among what is feasible."""
    violation: float
    """Of the best setting so far; 0 where it misses nothing."""
    feasible: int
    """Settings of this population that miss nothing."""


@dataclass(frozen=True)
class Member:
    """A setting of a Pareto front."""

    values: dict[str, Any]
    trained: Marks
    held_out: Marks
    chosen: bool = False

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"values": self.values, "trained": self.trained.values, "held_out": self.held_out.values,
                "chosen": self.chosen}  # fmt: skip


@dataclass
class Tuned:
    """The result of a tuning."""

    study: str
    controller: str
    scenarios: tuple[str, ...]
    vary: dict[str, str]
    over: dict[str, str]
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    values: dict[str, Any]
    """The setting that was found, by dotted key; options by their names."""
    present: dict[str, Any]
    """The setting before."""
    before: Marks
    """The setting before, on the plants of the search."""
    before_held_out: Marks
    trained: Marks
    """The setting that was found, on the plants of the search."""
    held_out: Marks
    """The setting that was found, on plants that the search never saw."""
    history: tuple[Generation, ...]
    front: tuple[Member, ...]
    """With several goals: settings of which none beats another in every goal."""
    plants: int
    held_out_plants: int
    budget: int
    used: int
    """Evaluations: a setting on all its plants and scenarios is one."""
    optimiser: str
    seed: int
    versions: dict[str, str]
    notes: tuple[str, ...] = ()
    """What is to be known of the setting besides: values at the ends of their ranges."""
    crew: str = ""
    wall_s: float = 0.0
    runs: int = 0
    """Simulated runs, those of the scores included."""
    samples: dict[str, Samples] = field(default_factory=dict, repr=False)
    """The runs behind the scores: ``before`` and ``tuned``, both on the held-out plants."""
    integration: dict[str, dict[str, Any]] = field(default_factory=dict)
    """What integrates the plant, by scenario."""

    @property
    def feasible(self) -> bool:
        """Whether the setting keeps every constraint on the plants that it was tuned on."""
        return not self.missed(self.trained) and self.trained.failed == 0

    @property
    def holds(self) -> bool:
        """Whether it keeps them on the held-out plants too."""
        return not self.missed(self.held_out) and self.held_out.failed == 0

    def missed(self, found: Marks) -> dict[str, float]:
        """The constraints that scores miss, and by how much."""
        by = {str(c): float(c.missed(found.values[str(c)])) for c in self.constraints}
        return {k: v for k, v in by.items() if not v <= 0.0}

    def verdict(self) -> str:
        """One sentence: whether it was found."""
        constraints = f"{'all' if len(self.constraints) > 1 else 'the'} constraint{_s(self.constraints)}"
        if not self.feasible:
            where = "plants that it was tuned on"
            return f"no setting of the {self.used} tried keeps {constraints}; {self._misses(self.trained, where)}"
        if not self.holds:
            return (
                f"the setting does well on the plants that it was tuned on and not on held-out ones; "
                f"{self._misses(self.held_out, 'held-out plants')}"
            )
        kept = f"keeps {constraints}" if self.constraints else "was judged"
        if not self.over:
            return f"the setting {kept}; nothing was varied, so nothing is known of other plants"
        return (
            f"the setting {kept} on the {self.plants} plants that it was tuned on and on {self.held_out_plants} others"
        )

    def _misses(self, found: Marks, where: str) -> str:
        if found.failed:
            return f"the best diverges or cannot be judged in {found.failed} of {found.runs} runs on {where}"
        parts = []
        for c in self.constraints:
            if str(c) in self.missed(found):
                parts.append(f"{c} by {float(c.missed(found.values[str(c)])):.4g} ({found.values[str(c)]:.6g})")
        return f"the nearest one misses {', '.join(parts)} on {where}"

    def as_dict(self) -> dict[str, Any]:
        """Everything but the runs, for JSON."""
        return {
            "study": self.study, "controller": self.controller, "scenarios": list(self.scenarios), "vary": self.vary,
            "over": self.over, "goals": [str(g) for g in self.goals], "constraints": [str(c) for c in self.constraints],
            "values": self.values, "present": self.present, "feasible": self.feasible, "holds": self.holds,
            "verdict": self.verdict(), "notes": list(self.notes), "before": self.before.as_dict(),
            "before_held_out": self.before_held_out.as_dict(), "trained": self.trained.as_dict(),
            "held_out": self.held_out.as_dict(), "front": [m.as_dict() for m in self.front],
            "history": [g._asdict() for g in self.history], "plants": self.plants,
            "held_out_plants": self.held_out_plants, "budget": self.budget, "used": self.used,
            "optimiser": self.optimiser, "seed": self.seed, "versions": self.versions, "crew": self.crew,
            "runs": self.runs, "wall_s": self.wall_s, "integration": self.integration,
        }  # fmt: skip

    def same(self, other: Tuned) -> bool:
        """Whether two tunings gave the same, bit for bit; who did the work and how long it took is left out."""
        mine, theirs = ({k: v for k, v in t.as_dict().items() if k not in ("crew", "wall_s")} for t in (self, other))
        return _equal(mine, theirs)


def _s(things: Sequence[Any]) -> str:
    return "s" if len(things) > 1 else ""


def _equal(a: Any, b: Any) -> bool:
    if isinstance(a, Mapping):
        return isinstance(b, Mapping) and list(a) == list(b) and all(_equal(a[k], b[k]) for k in a)
    if isinstance(a, list | tuple):
        return isinstance(b, list | tuple) and len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return (math.isnan(a) and math.isnan(b)) or a == b
    return bool(np.all(a == b))


PREFIX = "controller."


def controller_of(job: Job, tuned: Tuned, values: Mapping[str, float] | None = None) -> ControllerFile:
    """The controller with the setting that was found, or with another one of its front."""
    experiment = job.experiment
    base, parameters = experiment.controller or "", {}
    if names.is_toml(base):
        start = controller_file.read(base)
        base, parameters = start.controller, dict(start.parameters)
    changes = {**experiment.changes, **typed(job.sheet(), tuned.values if values is None else values)}
    parameters |= {k.removeprefix(PREFIX): v for k, v in changes.items() if k.startswith(PREFIX)}
    rest = {k: v for k, v in changes.items() if not k.startswith(PREFIX)}
    return ControllerFile(
        names.absolute(experiment.study), names.absolute(base), parameters, tuning(job, tuned) | {"also": rest}
    )


def tuning(job: Job, tuned: Tuned) -> dict[str, Any]:
    """Where a setting comes from; the same for the same question on the same day."""
    from leadscrew._version import __version__

    return {
        "verdict": tuned.verdict(), "notes": list(tuned.notes) or None, "feasible": tuned.feasible,
        "holds": tuned.holds, "optimiser": tuned.optimiser,
        "budget": tuned.budget, "evaluations": tuned.used, "seed": tuned.seed, "plants": tuned.plants,
        "held_out_plants": tuned.held_out_plants, "scenarios": [s for s in tuned.scenarios if s],
        "duration_s": [job.seconds(s) for s in tuned.scenarios], "minimise": [str(g) for g in tuned.goals],
        "subject_to": [str(c) for c in tuned.constraints], "leadscrew": __version__,
        "date": time.strftime("%Y-%m-%d", time.gmtime()), "command": command(job, tuned), "versions": tuned.versions,
        "vary": tuned.vary, "over": tuned.over, "before": tuned.before.values,
        "before_held_out": tuned.before_held_out.values, "trained": tuned.trained.values,
        "held_out": tuned.held_out.values,
    }  # fmt: skip


def command(job: Job, tuned: Tuned) -> str:
    """The command that finds the setting again; empty where a change is no single value."""
    experiment, words = job.experiment, ["leadscrew", "tune", names.absolute(job.experiment.study)]
    if any(not isinstance(value, bool | int | float | str) for value in experiment.changes.values()):
        return ""
    given: list[tuple[str, Any]] = [
        ("--controller", experiment.controller),
        *(("--scenario", s) for s in job.where if s),
    ]
    given += [
        ("--set", f"{key}={str(v).lower() if isinstance(v, bool) else v}") for key, v in experiment.changes.items()
    ]
    given += [("--vary", f"{key}={spread}") for key, spread in tuned.vary.items()]
    given += [("--minimise", goal) for goal in tuned.goals]
    given += [("--subject-to", constraint) for constraint in tuned.constraints]
    given += [("--over", f"{key}={spread}") for key, spread in tuned.over.items()]
    if tuned.over:
        given += [("--plants", tuned.plants), ("--held-out", tuned.held_out_plants)]
    given += [("--duration", job.duration_s), ("--budget", tuned.budget), ("--optimiser", tuned.optimiser)]
    given.append(("--seed", tuned.seed))
    return shlex.join([*words, *(str(word) for pair in given if pair[1] is not None for word in pair)])


def experiment_table(job: Job, tuned: Tuned) -> dict[str, Any]:
    """The whole loop that was found, as an experiment file says it."""
    experiment = job.experiment
    changes = {**experiment.changes, **typed(job.sheet(), tuned.values)}
    controller = experiment.controller
    if controller is not None:
        file = controller_of(job, tuned)
        controller, changes = file.controller, {**changes, **file.changes}
    return {
        "study": names.absolute(experiment.study), "controller": controller, "scenario": job.where[0] or None,
        "duration": job.seconds(job.where[0]), "seed": experiment.seed, "engine": experiment.engine, "set": changes,
    }  # fmt: skip


def beside(path: Path) -> Path:
    """Where the experiment file stands that belongs to a controller file."""
    return path.with_name(f"{path.stem}_experiment.toml")


def needs_experiment(experiment: Experiment, keys: Mapping[str, Any]) -> bool:
    """Whether a controller file alone would lose something that varied."""
    return experiment.controller is None or any(not k.startswith(PREFIX) for k in keys)


def save(job: Job, tuned: Tuned, path: Path) -> list[Path]:
    """Writes the files, each whole or not at all; a loop of one's own gives an experiment file only.

    Raises:
        DataError: one cannot be written.
    """
    if job.experiment.controller is None:
        toml_file.write(path, {"schema_version": legacy.CURRENT, **experiment_table(job, tuned)})
        return [path]
    controller_file.write(path, controller_of(job, tuned))
    if not needs_experiment(job.experiment, tuned.vary):
        return [path]
    toml_file.write(beside(path), {"schema_version": legacy.CURRENT, **experiment_table(job, tuned)})
    return [path, beside(path)]
