"""``leadscrew simulate``: one loop of a study, with any parameter changed."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.exit_codes import DIVERGED, say
from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.cli.subject import Trust, experiment_of
from leadscrew.cli.values import parse

if TYPE_CHECKING:
    from leadscrew.experiment import Experiment
    from leadscrew.kernel.run import Run

SCHEMA_VERSION = 1
MOST_ROWS = 1_000_000
"""Rows from which the notes are made where no signal is kept."""


def simulate(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A study's name; path/file.py:NAME of a study, a Loop or a function that returns one; "
            "or a machine or experiment file (.toml).",
        ),
    ],
    controller: Annotated[
        str | None,
        typer.Option(
            "--controller",
            "-c",
            help="Of the study, of the catalogue, path/file.py:NAME, a fuzzy system's file, "
            "or a controller file (.toml).",
        ),
    ] = None,
    scenario: Annotated[str | None, typer.Option("--scenario", "-s", help="What is asked of the machine.")] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter; leadscrew list STUDY shows them."),
    ] = None,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Seconds; the scenario's unless given.")] = None,
    engine: Annotated[str | None, typer.Option(help="What runs the loop; the fastest unless given.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of all noise.")] = None,
    replicate: Annotated[int | None, typer.Option(metavar="K", help="Which stream of noise, as in a batch.")] = None,
    substeps: Annotated[
        int | None, typer.Option(metavar="N", help="Integration steps of the plant a period; the study's unless given.")
    ] = None,
    every: Annotated[int | None, typer.Option(metavar="N", help="Record every N-th period.")] = None,
    record: Annotated[
        list[str] | None, typer.Option(metavar="SIGNAL", help="Record this signal; may be repeated.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for signals.parquet and run.json.")] = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Run one loop and print its metrics.

    Exit code 3 when it diverges.
    """
    from leadscrew.util.errors import ValueRefused

    experiment = experiment_of(study)
    given = {
        "controller": controller, "scenario": scenario, "duration_s": duration, "engine": engine, "seed": seed,
        "every": every, "record": tuple(record) if record else None, "replicate": replicate, "substeps": substeps,
    }  # fmt: skip
    experiment = replace(experiment, **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]
    if experiment.every < 1:
        raise ValueRefused(f"--every {experiment.every}: allowed are whole numbers from 1 on")
    if changes:
        parsed = parse(changes, experiment.settable())
        experiment = replace(experiment, changes={**experiment.changes, **parsed})
    if out is not None and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise ValueRefused(f"--out {out} exists already; choose another folder or remove it")
    run = executed(experiment, keep=out is not None)
    if out is not None:
        run.save(out)
    if as_json:
        emit(as_object(experiment, run, out))
    else:
        print_run(run, out)
    if run.diverged is not None:
        say(f"leadscrew: {run.loop.name} {run.diverged}")
        raise typer.Exit(DIVERGED)


def executed(experiment: Experiment, keep: bool) -> Run:
    """The run of an experiment, with its notes; signals are in it only to be kept."""
    from leadscrew.kernel.loop import DivergenceWarning
    from leadscrew.kernel.notes import RunWarning, needed

    loop = experiment.loop()
    seconds = experiment.seconds()
    wanted = loop.columns(experiment.record)
    every = experiment.every if keep else -(-loop.periods(seconds) // MOST_ROWS)
    record = list(dict.fromkeys([*(wanted if keep else ()), *loop.columns(needed(loop))]))
    with warnings.catch_warnings(), busy(f"{loop.name}, {seconds:g} s"):
        warnings.simplefilter("ignore", DivergenceWarning)
        warnings.simplefilter("ignore", RunWarning)
        run = loop.run(seconds, record, every, engine=experiment.engine, replicate=experiment.replicate)
    return replace(run, signals={k: run.signals[k] for k in wanted if k in run.signals} if keep else {})


def as_object(experiment: Experiment, run: Run, out: Path | None) -> dict[str, Any]:
    """The result for ``--json``."""
    from leadscrew.figures.formats import metric_rows

    rows = metric_rows(run)
    lost = None if run.diverged is None else {**run.diverged.__dict__, "message": str(run.diverged)}
    return {
        "schema_version": SCHEMA_VERSION,
        **experiment.origin,
        "duration_s": run.duration,
        "engine": run.engine,
        "seed": run.loop.seed,
        "replicate": run.replicate,
        **run.loop.integration,
        "wall_s": run.wall_s,
        "metrics": {r.name: r.value for r in rows},
        "metrics_without_value": run.metrics_without_value,
        "units": {r.name: r.unit for r in rows},
        "diverged": lost,
        "notes": [n._asdict() for n in run.notes],
        "out": None if out is None else str(out),
    }


def print_run(run: Run, out: Path | None) -> None:
    """The result in words."""
    from leadscrew.figures.formats import integrated, metric_rows, number

    by = integrated(run.loop.integration)
    typer.echo(f"{run.loop.name}: {run.duration:g} s on {run.engine}{by and f' by {by}'}, {1e3 * run.wall_s:.3g} ms\n")
    rows = [(r.name, number(r.value), r.unit, f"no value: {r.reason}" if r.reason else r.doc) for r in metric_rows(run)]
    print_table(["metric", "value", "unit", ""], rows, right=("value",))
    for note in run.notes:
        typer.echo(f"\nnote: {note.message}")
    if out is not None:
        typer.echo(f"\n{out}: {len(run.time)} rows of {', '.join(n for n in run.signals if n != 'time')}")
