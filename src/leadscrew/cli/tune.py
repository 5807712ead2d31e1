"""``leadscrew tune``: the best setting of a controller's parameters over many plants and scenarios."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.checkpoint_policy import Keeping, undone
from leadscrew.cli.exit_codes import MISSED, say
from leadscrew.cli.output import Json, emit, print_table
from leadscrew.cli.progress import counting
from leadscrew.cli.subject import Trust, experiment_of, spread
from leadscrew.cli.values import parse
from leadscrew.util.errors import LeadscrewError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.tune.job import Job
    from leadscrew.tune.tuned import Tuned

SCHEMA_VERSION = 1


def tune(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A study, a machine file, path/file.py:NAME of a study or Loop, or an experiment file.",
        ),
    ],
    controller: Annotated[
        str | None,
        typer.Option(
            "--controller",
            "-c",
            help="Of the study, of the catalogue, path/file.py:NAME, a fuzzy system's file, or a controller file.",
        ),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH", help="What may change; also LOW:HIGH:log, LOW:HIGH:int, A|B|C. Repeat."),
    ] = None,
    minimise: Annotated[
        list[str] | None,
        typer.Option(metavar="METRIC", help="Worst case; also mean:, median:, p95: before, @SCENARIO after. Repeat."),
    ] = None,
    subject_to: Annotated[
        list[str] | None,
        typer.Option("--subject-to", metavar="'METRIC<=VALUE'", help="To be kept; also >=. Repeat."),
    ] = None,
    scenario: Annotated[
        list[str] | None, typer.Option("--scenario", "-s", help="The study's first unless given. Repeat for several.")
    ] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter for good.")
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW:HIGH",
            help="What differs from plant to plant; distributions as --vary; intervals: of a machine file.",
        ),
    ] = None,
    plants: Annotated[int | None, typer.Option(metavar="N", help="That the search sees; 16 with --over.")] = None,
    held_out: Annotated[
        int | None, typer.Option("--held-out", metavar="N", help="That it never sees; 64 with --over.")
    ] = None,
    budget: Annotated[
        int, typer.Option(metavar="N", help="Settings to try, at most; each on all its plants and scenarios.")
    ] = 400,
    optimiser: Annotated[
        str | None,
        typer.Option(help="cma, de, nsga2 or scipy; cma for one goal and nsga2 for several unless given."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of plants and search.")] = 0,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Seconds; the scenario's unless given.")] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="All cores unless given.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A Dask cluster: local:N or tcp://HOST:PORT.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Controller file.")] = None,
    report: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for a page, figures and runs.")] = None,
    journal: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for results as they come, kept afterwards; FILE.journal, removed afterwards, with -o.",
        ),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what a journal holds.")] = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Tune a controller over many plants and scenarios; its scores on plants that the search never saw.

    Exit code 1 where no setting keeps the constraints, on the plants of the search and on held-out ones.
    """
    from leadscrew.tune import tuned, tuner
    from leadscrew.tune.executors import crew

    job = job_of(study, controller, scenario or [], changes or [], duration)
    asked = tuner.plan(
        job, vary or [], minimise or [], subject_to or [], over=spread(study, over), plants=plants, held_out=held_out,
        budget=budget, optimiser=optimiser, seed=seed,
    )  # fmt: skip
    free([out, report] + ([tuned.beside(out)] if out and tuned.needs_experiment(
        job.experiment, dict(asked.vary.items)) else []))  # fmt: skip
    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a controller file ends in .toml")
    keeping = Keeping(out, journal, resume, "-o")
    with keeping, crew(cluster, threads) as workers, counting() as stage:
        kept = keeping.open(asked.question())
        found = tuner.run(asked, workers, kept, stage(f"{job.experiment.controller or study}: {asked.optimiser}"))
        files = _saved(job, found, out, report)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, **found.as_dict(), "files": [str(f) for f in files],
              "report": None if report is None else str(report)})  # fmt: skip
    else:
        print_tuned(job, found)
        for line in written(files, report):
            typer.echo(line)
        for note in found.notes:
            say(f"leadscrew: note: {note}")
    if not (found.feasible and found.holds):
        say(f"leadscrew: {found.verdict()}")
        raise typer.Exit(MISSED)


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


def free(paths: list[Path | None]) -> None:
    """Refuses places where something is already, and such as cannot be written, before the work begins.

    Raises:
        DataError: names the place.
    """
    import tempfile

    from leadscrew.util.errors import DataError

    for path in paths:
        if path is None:
            continue
        try:
            if path.exists() and not (path.is_dir() and not any(path.iterdir())):
                raise DataError(f"{path} exists already; choose another place or remove it")
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=path.parent):
                pass
        except OSError as error:
            raise DataError(f"{path} cannot be written: {error.strerror or error}") from None


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


def print_tuned(job: Job, found: Tuned) -> None:
    """The result in words."""
    from leadscrew.report.tuned import COLUMNS, front_table, rows, settings

    name = found.controller or found.study
    typer.echo(
        f"{name}: {found.used} of {found.budget} evaluations by {found.optimiser}, seed {found.seed}; "
        f"{found.runs} runs in {found.wall_s:.3g} s, {found.crew}\n"
    )
    print_table(["parameter", "before", "tuned", "range"], settings(found), right=("before", "tuned"))
    typer.echo()
    print_table(COLUMNS, rows(found, job), right=COLUMNS[2:5])
    if found.front:
        columns, lines = front_table(found)
        typer.echo()
        print_table(columns, lines, right=columns[1:])
    if found.feasible and found.holds:
        typer.echo(f"\n{found.verdict()}")


def written(files: list[Path], report: Path | None) -> list[str]:
    """What was written, a line each."""
    lines = [""] if files or report else []
    if files:
        lines.append(f"{files[0]}: the setting; a name wherever a controller is named")
    if len(files) > 1:
        lines.append(f"{files[1]}: the whole loop, because more than the controller varied")
    return [*lines, *([f"{report}: report.html, tune.json, figures, held-out runs"] if report else [])]
