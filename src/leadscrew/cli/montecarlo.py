"""``leadscrew montecarlo``: many runs of a loop with distributed parameters, and what they say."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.exit_codes import DIVERGED, say
from leadscrew.cli.output import Json, emit
from leadscrew.cli.subject import StudyName, Trust


def montecarlo(
    study: StudyName,
    controller: Annotated[
        str | None,
        typer.Option(
            "--controller",
            "-c",
            help="Of the study, of the catalogue, path/file.py:NAME, a fuzzy system's file, "
            "or a controller file (.toml).",
        ),
    ] = None,
    scenario: Annotated[
        list[str] | None, typer.Option("--scenario", "-s", help="May be repeated; the study's first unless given.")
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=DIST",
            help="What varies: LOW:HIGH, LOW:HIGH:log, LOW:HIGH:int, normal:MEAN:DEVIATION, lognormal:MEDIAN:FACTOR "
            "A|B|C, or intervals: of a machine file. Noise differs from run to run in any case.",
        ),
    ] = None,
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
    duration: Annotated[float | None, typer.Option(metavar="S", help="Seconds; the scenario's unless given.")] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter in all runs.")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Of the samples and of all noise.")] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Threads; all cores unless given.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="WHERE", help="local:N or tcp://HOST:PORT: the same runs on Dask workers.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Report; report/STUDY_montecarlo unless given.")
    ] = None,
    journal: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Keeps what is done; beside the report, and gone with it, unless given."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what the journal holds.")] = False,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures.")] = True,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Run a loop many times with distributed parameters; write percentiles, yields, sensitivities, the worst runs.

    Exit code 3 when every run diverges.
    """
    from leadscrew.cli import montecarlo_work
    from leadscrew.report.montecarlo import alike, summary

    given = montecarlo_work.Asked(
        study, controller, tuple(scenario or ()), tuple(over or ()), runs, tuple(tolerance or ()), sampling, sobol,
        tuple(wear or ()), life, level, worst, duration, tuple(changes or ()), seed, threads, cluster, out, journal,
        resume, figures,
    )  # fmt: skip
    asked = montecarlo_work.Work(given)
    findings = asked.done()
    if as_json:
        emit({**summary(findings, asked.out), "report": str(asked.out / "report.html")})
    else:
        montecarlo_work.print_findings(findings, asked.out)
    found = findings.found
    if note := alike(found):
        say(f"warning: {note}")
    if found.diverged.all():
        first = min(float(at.min()) for at in (v[v == v] for v in found.samples.diverged_at.values()) if len(at))
        say(f"leadscrew: all {len(found)} runs diverged, the first at {first:g} s")
        raise typer.Exit(DIVERGED)
