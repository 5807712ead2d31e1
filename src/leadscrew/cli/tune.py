"""``leadscrew tune``: the best setting of a controller's parameters over many plants and scenarios."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.checkpoint_policy import Keeping, undone
from leadscrew.cli.options import (
    Budget,
    Changes,
    Cluster,
    Constraints,
    Controller,
    ControllerFile,
    Duration,
    Goals,
    Journal,
    Json,
    Optimiser,
    Over,
    Plants,
    Resume,
    Scenarios,
    Threads,
    Trust,
)
from leadscrew.cli.output import deliver, free
from leadscrew.cli.progress import counting
from leadscrew.cli.subject import experiment_of, spread
from leadscrew.cli.values import parse
from leadscrew.util.errors import LeadscrewError

if TYPE_CHECKING:
    from leadscrew.tune.job import Job
    from leadscrew.tune.tuned import Tuned


def tune(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A study, a machine file, path/file.py:NAME of a study or Loop, or an experiment file.",
        ),
    ],
    controller: Controller = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH", help="What may change; also LOW:HIGH:log, LOW:HIGH:int, A|B|C. Repeat."),
    ] = None,
    minimise: Goals = None,
    subject_to: Constraints = None,
    scenario: Scenarios = None,
    changes: Changes = None,
    over: Over = None,
    plants: Plants = None,
    held_out: Annotated[
        int | None, typer.Option("--held-out", metavar="N", help="That it never sees; 64 with --over.")
    ] = None,
    budget: Budget = 400,
    optimiser: Optimiser = None,
    seed: Annotated[int, typer.Option(help="Of plants and search.")] = 0,
    duration: Duration = None,
    threads: Threads = None,
    cluster: Cluster = None,
    out: ControllerFile = None,
    report: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for a page, figures and runs.")] = None,
    journal: Journal = None,
    resume: Resume = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Tune a controller over many plants and scenarios; its scores on plants that the search never saw.

    Exit code 1 where no setting keeps the constraints, on the plants of the search and on held-out ones.
    """
    from leadscrew.report.tuned import report_of
    from leadscrew.tune import tuned, tuner
    from leadscrew.tune.executors import crew

    job = job_of(study, controller, scenario or [], changes or [], duration)
    asked = tuner.plan(
        job, vary or [], minimise or [], subject_to or [], over=spread(study, over), plants=plants, held_out=held_out,
        budget=budget, optimiser=optimiser, seed=seed,
    )  # fmt: skip
    free([out, report] + ([tuned.beside(out)] if out and tuned.needs_experiment(
        job.experiment, dict(asked.vary.items)) else []))  # fmt: skip
    keeping = Keeping(out, journal, resume, "-o")
    with keeping, crew(cluster, threads) as workers, counting() as stage:
        kept = keeping.open(asked.question())
        found = tuner.run(asked, workers, kept, stage(f"{job.experiment.controller or study}: {asked.optimiser}"))
        files = _saved(job, found, out, report)
    deliver(report_of(job, found, report, files), as_json=as_json)


def job_of(study: str, controller: str | None, scenarios: list[str], changes: list[str], duration: float | None) -> Job:
    """What the options ask to run.

    Raises:
        LeadscrewError: a name or a value that does not exist.
    """
    from leadscrew.tune.job import Job

    experiment = experiment_of(study)
    if controller is not None:
        experiment = replace(experiment, controller=controller)
    if scenarios:
        experiment = replace(experiment, scenario=scenarios[0])
    experiment = experiment.with_first_scenario()
    if changes:
        experiment = replace(experiment, changes={**experiment.changes, **parse(changes, experiment.settable())})
    return Job(experiment, tuple(dict.fromkeys(scenarios)), duration)


def _saved(job: Job, found: Tuned, out: Path | None, report: Path | None) -> list[Path]:
    """Writes what was asked for, all of it or nothing.

    Raises:
        DataError: it cannot be written.
    """
    from leadscrew.report.tuned import write
    from leadscrew.tune.tuned import save

    if report is not None:
        write(job, found, report)
    try:
        return save(job, found, out) if out else []
    except LeadscrewError:
        undone(report)
        raise
