"""What a tuning leaves on disk: the controller file, and an experiment file where more than the controller varied."""

from __future__ import annotations

import shlex
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from leadscrew import controller_file, userfile
from leadscrew.controller_file import ControllerFile
from leadscrew.experiment import Experiment
from leadscrew.tune.job import Job, typed
from leadscrew.tune.tuned import Tuned

PREFIX = "controller."


def controller_of(job: Job, tuned: Tuned, values: Mapping[str, float] | None = None) -> ControllerFile:
    """The controller with the setting that was found, or with another one of its front."""
    experiment = job.experiment
    base, parameters = experiment.controller or "", {}
    if userfile.is_controller_file(base):
        start = controller_file.read(base)
        base, parameters = start.controller, dict(start.parameters)
    changes = {**experiment.changes, **typed(job.sheet(), tuned.values if values is None else values)}
    parameters |= {k.removeprefix(PREFIX): v for k, v in changes.items() if k.startswith(PREFIX)}
    rest = {k: v for k, v in changes.items() if not k.startswith(PREFIX)}
    return ControllerFile(
        userfile.absolute(experiment.study), userfile.absolute(base), parameters, tuning(job, tuned) | {"also": rest}
    )


def tuning(job: Job, tuned: Tuned) -> dict[str, Any]:
    """Where a setting comes from; the same for the same question on the same day."""
    from leadscrew import __version__

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
    experiment, words = job.experiment, ["leadscrew", "tune", userfile.absolute(job.experiment.study)]
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
        "study": userfile.absolute(experiment.study), "controller": controller, "scenario": job.where[0] or None,
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
        controller_file.write_experiment(path, experiment_table(job, tuned))
        return [path]
    controller_file.write(path, controller_of(job, tuned))
    if not needs_experiment(job.experiment, tuned.vary):
        return [path]
    controller_file.write_experiment(beside(path), experiment_table(job, tuned))
    return [path, beside(path)]
