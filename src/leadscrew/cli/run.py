"""``leadscrew run``: judge the claims of a study and write its report."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.door import MISSED
from leadscrew.cli.output import Json, deliver, emit, print_table, progress, width
from leadscrew.cli.subject import StudyName, Trust, whole_study
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.report.claim import Claim
    from leadscrew.studies.study import Study, StudyResult

WIDE = 170
"""Columns from which the reasons stand beside the claims."""


def run(
    study: StudyName,
    out: Annotated[Path | None, typer.Option(help="Folder of the report (default: report/STUDY).")] = None,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures.")] = True,
    everything: Annotated[
        bool, typer.Option("--all", help="Print all claims and experiments, not the key claims alone.")
    ] = False,
    accept: Annotated[
        bool, typer.Option("--accept", help="Make the numbers measured now the study's expected.csv.")
    ] = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Judge every claim of a study; write report.html and the runs.

    Exit code 1 when a number is not the expected one.
    """
    origin, found = whole_study(study)
    if found.contents is not None:
        run_study(origin, found, out, figures=figures, everything=everything, accept=accept, as_json=as_json)
        return
    if found.evaluate is None:
        raise ValueRefused(f"{found.name} has no claims to judge: leadscrew simulate, compare or tune run it")
    if accept:
        raise ValueRefused(f"{found.name} keeps no expected.csv: --accept is for studies with contents")
    result, folder, wall = judged(origin, found, out, figures, as_json, everything)
    if not as_json:
        typer.echo(f"\n{folder / 'report.html'}   ({wall:.1f} s)")
    leave(result)


def run_study(
    origin: str, study: Study, out: Path | None, *, figures: bool, everything: bool, accept: bool, as_json: bool
) -> None:
    """Evaluates a study, writes its report, prints its summary."""
    from leadscrew.report import drawing
    from leadscrew.report import folder as reports
    from leadscrew.report.study import report_of
    from leadscrew.studies.results import evaluate, write_expected

    began = time.perf_counter()
    target = reports.claimable(out if out is not None else Path("report") / study.name)
    notes = []
    with progress() as show_progress, drawing.beside(study, figures) as draw:
        results = evaluate(study, show_progress)
        evaluated = time.perf_counter() - began
        if accept:
            notes.append(f"Accepted: {write_expected(results)} now holds the {len(results.values())} numbers measured.")
            results.missed.clear()
        saved = [(key, reports.run_folder(key)) for key in results.lab.runs]
        command = shlex.join(["leadscrew", "run", origin, "--out", str(target)])
        report = report_of(results, saved, command)
        page = reports.put(
            report,
            target,
            wall_s=evaluated,
            runs=results.lab.runs,
            origin=origin,
            draw=draw,
            progress=show_progress,
        )
    if out is None:
        list_reports(target)
    deliver(report, page, time.perf_counter() - began, everything=everything, as_json=as_json, notes=notes)


def list_reports(folder: Path, title: str = "Reports") -> Path | None:
    """Lists the reports beside this one in ``index.html``; gives its path."""
    from leadscrew.report import index

    return index.write(folder.parent, title)


def judged(
    origin: str, found: Study, out: Path | None, figures: bool, as_json: bool, everything: bool = False
) -> tuple[StudyResult, Path, float]:
    """Runs a study, writes its report, prints its claims; gives result, folder and seconds."""
    from leadscrew.report import folder as report

    assert found.evaluate is not None
    began = time.perf_counter()
    target = report.claimable(out if out is not None else Path("report") / found.name)
    with progress() as report_progress:
        result = found.evaluate(report_progress)
        evaluated = time.perf_counter() - began
        report.write(found, result, target, wall_s=evaluated, origin=origin, figures=figures, progress=report_progress)
    if out is None:
        list_reports(target)
    wall = time.perf_counter() - began
    if as_json:
        emit(report.summary(found, result, wall, target / "report.html"))
    else:
        print_claims(result, everything)
    return result, target, wall


def leave(result: StudyResult) -> None:
    """Exit code 1 when a required target is missed."""
    from leadscrew.report.tables import missed

    if missed(result.claims):
        raise typer.Exit(MISSED)


def print_claims(result: StudyResult, everything: bool) -> None:
    """The tables of claims, one a topic, and what they add up to; ours alone only if ``everything`` is asked for."""
    from leadscrew.report import tables

    for title, claims in result.by_topic():
        if title:
            typer.echo(f"\n{title}")
        shown, ours = (claims, []) if everything else tables.of_the_paper(claims)
        if shown:
            print_topic(shown)
        if ours:
            typer.echo(f"{len(ours)} {'more ' if shown else ''}on which the paper says nothing, in the report")
    sums = tables.tally(result.claims)
    typer.echo("\n" + ", ".join(f"{n} {verdict}" for verdict, n in sums.verdicts.items() if n))
    typer.echo(f"{sums.required_met} of {sums.required} required targets met")
    for claim in tables.missed(result.claims):
        typer.echo(f"MISSED {claim.id}: {tables.number(claim.measured)} {claim.unit}, wanted {tables.target(claim)}")


def print_topic(claims: list[Claim]) -> None:
    """One table of claims; below it why, where the terminal is too narrow for a column of reasons."""
    from leadscrew.report import tables

    columns = ["claim", "source", "paper", "measured", "unit", "verdict", "met"]
    beside = width() >= WIDE
    print_table(
        [*columns, "reason"] if beside else columns,
        [
            [c.id, c.source, tables.number(c.paper), tables.number(c.measured), c.unit, c.verdict, tables.met(c)]
            + ([c.reason] if beside else [])
            for c in claims
        ],
        right=("paper", "measured"),
    )
    if not beside:
        typer.echo("\nWhy:")
        for c in claims:
            if c.reason and c.verdict != "reproduced":
                typer.echo(f"  {c.id}: {c.reason}")
