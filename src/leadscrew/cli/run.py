"""``leadscrew run``: judge the claims of a study and write its report."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import Json, StudyName, Trust
from leadscrew.cli.output import deliver, progress
from leadscrew.cli.subject import whole_study


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
    from leadscrew.report import drawing, index, text
    from leadscrew.report import folder as reports
    from leadscrew.report.report import File, Report
    from leadscrew.report.study import report_of
    from leadscrew.studies.results import evaluate, write_expected

    origin, found = whole_study(study)
    began = time.perf_counter()
    target = reports.claimable(out if out is not None else Path("report") / found.name)
    notes = []
    with progress() as show_progress, drawing.beside(found, figures) as draw:
        results = evaluate(found, show_progress)
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
        index.write(target.parent, "Reports")
    wall_s = time.perf_counter() - began
    printed = text.whole if everything else text.summary
    result = Report(
        reports.data(report, wall_s, page),
        parts=[lambda columns: printed(report, columns), *notes],
        files=[File("", page, f"the report ({wall_s:.1f} s)")],
        code=MISSED if report.missed else 0,
    )
    deliver(result, as_json=as_json)
