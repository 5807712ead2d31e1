"""``leadscrew compare``: controllers with the same effort on the same plants that none of them saw."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.checkpoint_policy import Keeping
from leadscrew.cli.exit_codes import say
from leadscrew.cli.output import Json, emit, print_table
from leadscrew.cli.progress import counting
from leadscrew.cli.subject import Trust, spread
from leadscrew.cli.tune import free, job_of
from leadscrew.util.errors import ValueRefused

SCHEMA_VERSION = 1


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
    minimise: Annotated[
        list[str] | None, typer.Option(metavar="METRIC", help="What all are tuned for and ranked by; as for tune.")
    ] = None,
    subject_to: Annotated[
        list[str] | None, typer.Option("--subject-to", metavar="'METRIC<=VALUE'", help="To be kept. Repeat.")
    ] = None,
    scenario: Annotated[
        list[str] | None, typer.Option("--scenario", "-s", help="The study's first unless given. Repeat for several.")
    ] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter for all.")
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=LOW:HIGH", help="What differs from plant to plant; intervals: of a machine file."),
    ] = None,
    plants: Annotated[int | None, typer.Option(metavar="N", help="That the tuning sees; 16 with --over.")] = None,
    unseen: Annotated[int, typer.Option(metavar="N", help="Plants of the comparison.")] = 200,
    budget: Annotated[int, typer.Option(metavar="N", help="Settings to try for each contender, at most.")] = 400,
    optimiser: Annotated[str | None, typer.Option(help="cma, de, nsga2 or scipy.")] = None,
    seed: Annotated[int, typer.Option(help="Of plants, searches and bootstrap.")] = 0,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Seconds; the scenario's unless given.")] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="All cores unless given.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A Dask cluster: local:N or tcp://HOST:PORT.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for a page, a figure, runs and tuned controllers.")
    ] = None,
    journal: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for results as they come, kept afterwards; DIR.journal, removed afterwards, with --report.",
        ),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with what a journal holds.")] = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Compare controllers, each tuned with the same budget, on plants that no tuning saw."""
    from leadscrew.report import comparison
    from leadscrew.tune import compare as comparing
    from leadscrew.tune.compare import METRICS, RANKING, confidence, metric_rows, ranking_rows, setting
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
        if report is not None:
            comparison.write(found, asked, report)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, **found.as_dict(), "report": None if report is None else str(report)})
        return
    print_table(RANKING, ranking_rows(found), right=("rank",))
    typer.echo()
    print_table(METRICS, metric_rows(found), right=("worst seen", "judged"))
    for result in found.results:
        if result.tuned is not None:
            typer.echo(f"\n{result.name}: {setting(result)}; {result.tuned.verdict()}")
    typer.echo(f"\n{found.sentence()}")
    if bound := confidence(found):
        typer.echo(f"{bound}.")
    for note in found.notes:
        say(f"leadscrew: note: {note}")
    if report is not None:
        typer.echo(f"\n{report}: report.html, compare.json, compare.png, runs, tuned controllers")


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
