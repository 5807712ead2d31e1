"""``leadscrew simulate``: one loop of a study, with any parameter changed."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.exit_codes import DIVERGED
from leadscrew.cli.options import Changes, Controller, Duration, Engine, Json, LoopName, Scenario, Trust
from leadscrew.cli.output import busy, deliver, free
from leadscrew.cli.subject import experiment_of
from leadscrew.cli.values import parse
from leadscrew.figures.table import number, unit
from leadscrew.report.report import File, Report, TextTable, head

if TYPE_CHECKING:
    from leadscrew.experiment import Experiment
    from leadscrew.kernel.run import Run

MOST_ROWS = 1_000_000
"""Rows from which the notes are made where no signal is kept."""


def simulate(
    study: LoopName,
    controller: Controller = None,
    scenario: Scenario = None,
    changes: Changes = None,
    duration: Duration = None,
    engine: Engine = None,
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
    free([out])
    run = executed(experiment, keep=out is not None)
    deliver(report_of(experiment, run, out), as_json=as_json)


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


def report_of(experiment: Experiment, run: Run, out: Path | None) -> Report:
    """The report of ``leadscrew simulate``."""
    from leadscrew.figures.formats import integrated, metric_rows

    rows = metric_rows(run)
    data = {
        **head("simulate"), **experiment.origin, "duration_s": run.duration, "engine": run.engine,
        "seed": run.loop.seed, "replicate": run.replicate, **run.loop.integration, "wall_s": run.wall_s,
        "metrics": {r.name: r.value for r in rows}, "metrics_without_value": run.metrics_without_value,
        "units": {r.name: r.unit for r in rows},
        "diverged": None if run.diverged is None else {**run.diverged.__dict__, "message": str(run.diverged)},
        "notes": [n._asdict() for n in run.notes],
    }  # fmt: skip
    by = integrated(run.loop.integration)
    cells = [(r.name, number(r.value, 6), unit(r.unit), f"no value: {r.reason}" if r.reason else r.doc) for r in rows]
    signals = "" if out is None else f"{len(run.time)} rows of {', '.join(n for n in run.signals if n != 'time')}"
    return Report(
        data,
        parts=[
            f"{run.loop.name}: {run.duration:g} s on {run.engine}{by and f' by {by}'}, {1e3 * run.wall_s:.3g} ms",
            TextTable(("metric", "value", "unit", ""), cells, [False, True, False, False]),
        ],
        verdict="" if run.diverged is None else f"{run.loop.name} {run.diverged}",
        notes=[n.message for n in run.notes],
        files=[File("out", out, signals, run.save)],
        code=0 if run.diverged is None else DIVERGED,
    )
