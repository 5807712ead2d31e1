"""``leadscrew certify``: what is proved of a loop's stability, for the loop as it is sampled, delayed and exported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import (
    Certificate,
    Changes,
    Controller,
    Duration,
    Json,
    LoopName,
    Plot,
    Scenario,
    Trust,
)
from leadscrew.cli.output import busy, deliver, free
from leadscrew.cli.subject import experiment_of
from leadscrew.cli.values import parse

if TYPE_CHECKING:
    from leadscrew.analysis.stability.certification import Certification
    from leadscrew.experiment import Experiment
    from leadscrew.figures.figure import Figure


def certify(
    study: LoopName,
    controller: Controller = None,
    scenario: Scenario = None,
    changes: Changes = None,
    level: Annotated[
        str, typer.Option(help="What the verdict is about: driven (any command and load) or autonomous (at rest).")
    ] = "driven",
    reserve: Annotated[
        float, typer.Option(metavar="X", help="The proved limit must exceed the bound this many times.")
    ] = 1.0,
    proof: Annotated[
        bool, typer.Option("--proof", help="Count matrix inequalities alone, no check on a grid of frequencies.")
    ] = False,
    points: Annotated[
        int | None, typer.Option(metavar="N", help="Frequencies of the grid; the loop's own grid unless given.")
    ] = None,
    popov: Annotated[
        bool,
        typer.Option(
            "--popov/--no-popov", help="Also Popov, of the continuous model; it proves nothing of the sampled loop."
        ),
    ] = False,
    simulate: Annotated[
        bool,
        typer.Option("--simulate/--no-simulate", help="Run the scenario, to see what the nonlinear gain does in it."),
    ] = True,
    duration: Duration = None,
    out: Certificate = None,
    plot: Plot = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Certify a loop: margins, absolute stability at rest and under command and load, limit cycles, one verdict.

    Exit code 0 where it is certified as asked, 1 where it is not, 2 for bad input.
    """
    from leadscrew.analysis.stability.certification import certify as certified
    from leadscrew.export.controller import identity_of
    from leadscrew.report.report import File, Lines, Report, head

    free([out, plot])
    given = {"controller": controller, "scenario": scenario, "duration_s": duration}
    experiment = replace(experiment_of(study), **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]
    experiment = experiment.with_first_scenario()
    if changes:
        experiment = replace(experiment, changes={**experiment.changes, **parse(changes, experiment.settable())})
    loop = experiment.loop()
    seconds = _seconds(experiment, duration) if simulate else None
    with busy(f"{loop.name}: certifying"):
        found = certified(
            loop, level=level, factor=reserve, proof=proof, points=points, seconds=seconds,  # type: ignore[arg-type]
            name=experiment.controller or loop.name, model=popov,
        )  # fmt: skip
        identity = identity_of(loop)
    data = {**head("certify"), **found.as_dict(), "controller": identity, "origin": loop.origin}
    steps = (
        f"controller {identity['block']}: steps {identity['source_hash']} (as in an export's manifest.json), with "
        f"parameters {identity['fingerprint']}"
    )
    report = Report(
        data,
        parts=[Lines(found.report().splitlines()), steps],
        files=[File("out", out, "the certificate", lambda path: _save(path, data))],
        figure=lambda: figure_of(found),
        code=0 if found.passed else MISSED,
    )
    deliver(report, plot=plot, as_json=as_json)


def _seconds(experiment: Experiment, duration: float | None) -> float | None:
    """How long to simulate; a loop of one's own without a duration is not simulated."""
    from leadscrew.util.errors import ValueRefused

    if duration is not None:
        return duration
    try:
        return experiment.seconds()
    except ValueRefused:
        return None


def _save(path: Path, text: dict[str, Any]) -> None:
    import json

    from leadscrew.util.atomic import atomic_write
    from leadscrew.util.strict_json import strict

    atomic_write(json.dumps(strict(text), allow_nan=False, indent=1) + "\n", path)


def figure_of(found: Certification) -> Figure:
    """The plot of the certificate that the verdict rests on; of a linear controller the Nyquist plot."""
    best = found.best if found.taken.nonlinear and found.best is not None else found.margins
    chosen = best if best.drawing else next(
        (c for c in (*found.autonomous, found.margins) if c.drawing), None
    )  # fmt: skip
    assert chosen is not None
    return chosen.figure()
