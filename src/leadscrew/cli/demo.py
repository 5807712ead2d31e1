"""``leadscrew demo``: the key claims of all published systems, on one page."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import Json
from leadscrew.cli.output import deliver, progress
from leadscrew.report.report import File, Report, Verbatim, head

if TYPE_CHECKING:
    from rich.text import Text

    from leadscrew.report.report import StudyReport

STUDIES: tuple[str, ...] = ("vud_lathe", "fsmc_ballscrew", "npid_xytable", "grey_turning", "sofnn_tangent")
NEXT = (
    "leadscrew run vud_lathe",
    "leadscrew list npid_xytable",
    "leadscrew simulate vud_lathe --controller ours.pd --scenario fig11a_step_m50",
)
"""What to try after the demo."""
MOST_LINES = 4
"""Of a conclusion, but for a first sentence that is longer."""


def demo(
    out: Annotated[Path | None, typer.Option(help="Folder of the pages (default: report/demo).")] = None,
    as_json: Json = False,
) -> None:
    """Run the key claims of all five published systems; write a page with a card for each.

    Exit code 1 when a number is not the expected one.
    """
    from leadscrew.report import folder as reports
    from leadscrew.report import index

    began = time.perf_counter()
    target = out if out is not None else Path("report") / "demo"
    places = {name: reports.claimable(target / Path(name).stem.split(":")[0]) for name in STUDIES}
    pages: dict[str, Path] = {}
    with progress() as show_progress:
        done = evaluated(show_progress)
        for at, (name, (report, seconds)) in enumerate(done.items()):
            show_progress(f"drawing {report.name}", 0.8 + 0.2 * at / len(done))
            pages[name] = reports.put(report, places[name], wall_s=seconds)
    found = {name: report for name, (report, _) in done.items()}
    page = index.write(target, "Five published systems, rebuilt and judged", [places[name].name for name in STUDIES])
    wall = time.perf_counter() - began
    result = Report(
        {
            **head("demo"), "wall_s": wall, "report": str(page or target),
            "studies": [reports.data(found[name], done[name][1], pages[name]) for name in STUDIES],
        },
        parts=[
            lambda columns: conclusions([found[name] for name in STUDIES], columns),
            Verbatim(["Then try:", *(f"  {command}" for command in NEXT)]),
        ],
        files=[File("", (page or target).resolve(), f"all reports ({wall:.1f} s)")],
        code=MISSED if any(report.missed for report in found.values()) else 0,
    )  # fmt: skip
    deliver(result, as_json=as_json)


def evaluated(show_progress: Callable[[str, float], None]) -> dict[str, tuple[StudyReport, float]]:
    """The reports by name, with the seconds of each, side by side; their figures are not drawn yet."""
    from leadscrew.kernel.one_thread import one_thread

    def one(name: str) -> tuple[StudyReport, float]:
        began = time.perf_counter()
        report = report_of(name)
        return report, time.perf_counter() - began

    with one_thread(), ThreadPoolExecutor(2) as side_by_side:
        jobs: dict[Future[tuple[StudyReport, float]], str] = {side_by_side.submit(one, name): name for name in STUDIES}
        for number, job in enumerate(as_completed(jobs), start=1):
            show_progress(f"{jobs[job]} done", 0.8 * number / len(jobs))
    return {name: job.result() for job, name in jobs.items()}


def report_of(name: str) -> StudyReport:
    """The key claims of a study."""
    from leadscrew import resolve
    from leadscrew.report.study import summary_of
    from leadscrew.studies.results import evaluate

    return summary_of(evaluate(resolve.study(name), key=True), shlex.join(["leadscrew", "run", name]))


def conclusions(found: list[StudyReport], columns: int) -> Iterator[Text]:
    """Each study in a few lines."""
    from rich.text import Text

    from leadscrew.report import text

    for report in found:
        yield from (Text(line, "bold") for line in text.wrapped(f"{report.name}: {report.title}", columns))
        yield from map(Text, text.shortened(report.conclusion, columns, MOST_LINES))
        yield from (Text(line, "bold red") for line in text.limited(report.missed, columns, 3))
