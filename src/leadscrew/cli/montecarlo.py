"""``leadscrew montecarlo``: many runs of a loop with distributed parameters, and what they say."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.options import (
    Changes,
    Cluster,
    Controller,
    Duration,
    Journal,
    Json,
    Over,
    Resume,
    Scenarios,
    StudyName,
    Threads,
    Trust,
)
from leadscrew.cli.output import deliver


def montecarlo(
    study: StudyName,
    controller: Controller = None,
    scenario: Scenarios = None,
    over: Over = None,
    runs: Annotated[int, typer.Option(metavar="N", help="Runs in every scenario.")] = 1000,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(metavar="TEXT", help="METRIC<=VALUE, METRIC>=VALUE or METRIC@SCENARIO<=VALUE; may be repeated."),
    ] = None,
    sampling: Annotated[str, typer.Option(help="lhs (Latin hypercube), sobol or random.")] = "lhs",
    sobol: Annotated[
        int, typer.Option(metavar="N", help="Sobol indices from N (parameters + 2) runs more; N a power of two.")
    ] = 0,
    wear: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=START:END",
            help="Drift over a life; KEY=xA:xB as factors of the parameter's own value; either with :log.",
        ),
    ] = None,
    life: Annotated[int, typer.Option(metavar="N", help="Steps of a life, each with all runs.")] = 11,
    level: Annotated[float, typer.Option(metavar="PERCENT", help="The yield below which a life ends.")] = 90.0,
    worst: Annotated[int, typer.Option(metavar="K", help="Save the K worst runs against each tolerance.")] = 3,
    duration: Duration = None,
    changes: Changes = None,
    seed: Annotated[int | None, typer.Option(help="Of the samples and of all noise.")] = None,
    threads: Threads = None,
    cluster: Cluster = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Report; report/STUDY_montecarlo unless given.")
    ] = None,
    journal: Journal = None,
    resume: Resume = False,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures.")] = True,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Run a loop many times with distributed parameters; write percentiles, yields, sensitivities, the worst runs.

    Exit code 3 when every run diverges.
    """
    from leadscrew.cli import montecarlo_work
    from leadscrew.report.montecarlo import report_of

    given = montecarlo_work.Asked(
        study, controller, tuple(scenario or ()), tuple(over or ()), runs, tuple(tolerance or ()), sampling, sobol,
        tuple(wear or ()), life, level, worst, duration, tuple(changes or ()), seed, threads, cluster, out, journal,
        resume, figures,
    )  # fmt: skip
    asked = montecarlo_work.Work(given)
    deliver(report_of(asked.done(), asked.out), as_json=as_json)
