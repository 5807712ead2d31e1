"""``leadscrew compare``: controllers with the same effort on the same plants that none of them saw."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.checkpoint_policy import Keeping
from leadscrew.cli.options import (
    Changes,
    Cluster,
    Constraints,
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
from leadscrew.cli.subject import spread
from leadscrew.cli.tune import job_of
from leadscrew.util.errors import ValueRefused


def compare(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY", help="A study, a machine file, path/file.py:NAME of a study, or an experiment file."
        ),
    ],
    controller: Annotated[
        list[str] | None,
        typer.Option("--controller", "-c", metavar="NAME", help="A contender, as for simulate. Two or more."),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME:KEY=LOW:HIGH",
            help="What a contender may change when it is tuned; one without is taken as it is. Repeat.",
        ),
    ] = None,
    minimise: Goals = None,
    subject_to: Constraints = None,
    scenario: Scenarios = None,
    changes: Changes = None,
    over: Over = None,
    plants: Plants = None,
    unseen: Annotated[int, typer.Option(metavar="N", help="Plants of the comparison.")] = 200,
    budget: Annotated[int, typer.Option(metavar="N", help="Settings to try for each contender, at most.")] = 400,
    optimiser: Optimiser = None,
    seed: Annotated[int, typer.Option(help="Of plants, searches and bootstrap.")] = 0,
    duration: Duration = None,
    threads: Threads = None,
    cluster: Cluster = None,
    report: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for a page, a figure, runs and tuned controllers.")
    ] = None,
    journal: Journal = None,
    resume: Resume = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Compare controllers, each tuned with the same budget, on plants that no tuning saw."""
    from leadscrew.report.comparison import report_of
    from leadscrew.tune import compare as comparing
    from leadscrew.tune.executors import crew

    names = controller or []
    job = job_of(study, names[0] if names else None, scenario or [], changes or [], duration)
    asked = comparing.contest(
        job, names, minimise or [], subject_to or [], vary=by_name(vary or [], names), over=spread(study, over),
        plants=plants, unseen=unseen, budget=budget, optimiser=optimiser, seed=seed,
    )  # fmt: skip
    free([report])
    keeping = Keeping(report, journal, resume, "--report")
    with keeping, crew(cluster, threads) as workers, counting() as stage:
        found = comparing.run(asked, workers, keeping.open(asked.question()), stage(f"{len(names)} contenders"))
        deliver(report_of(found, asked), out=report, as_json=as_json)


def by_name(texts: list[str], names: list[str]) -> dict[str, list[str]]:
    """What each contender may change.

    Raises:
        ValueRefused: a text that begins with no contender's name.
    """
    found: dict[str, list[str]] = {}
    for text in texts:
        owner = next((n for n in sorted(names, key=len, reverse=True) if text.startswith(f"{n}:")), None)
        if owner is None:
            raise ValueRefused(f"--vary {text!r}: expected NAME:KEY=LOW:HIGH with NAME one of {', '.join(names)}")
        found.setdefault(owner, []).append(text[len(owner) + 1 :])
    return found
