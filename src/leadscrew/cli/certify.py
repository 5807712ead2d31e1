"""``leadscrew certify``: what is proved of a loop's stability, for the loop as it is sampled, delayed and exported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.output import Json, busy, emit
from leadscrew.cli.subject import Trust, experiment_of
from leadscrew.cli.values import parse

if TYPE_CHECKING:
    from leadscrew.analysis.stability.certification import Certification
    from leadscrew.experiment import Experiment

SCHEMA_VERSION = 1


def certify(
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
            help="Of the study, of the catalogue, path/file.py:NAME, or a controller file (.toml).",
        ),
    ] = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", "-s", help="Whose loop and errors; the study's first unless given.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter; leadscrew list STUDY shows them."),
    ] = None,
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
    duration: Annotated[float | None, typer.Option(metavar="S", help="Seconds of that run.")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.json", help="Save the certificate.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw what the verdict rests on (.png, .svg, .pdf).")
    ] = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Certify a loop: margins, absolute stability at rest and under command and load, limit cycles, one verdict.

    Exit code 0 where it is certified as asked, 1 where it is not, 2 for bad input.
    """
    from leadscrew.analysis.stability.certification import certify as certified
    from leadscrew.cli.tune import free
    from leadscrew.export.controller import identity_of
    from leadscrew.util.errors import ValueRefused

    if out is not None and out.suffix != ".json":
        raise ValueRefused(f"--out {out}: a certificate is saved as .json")
    if plot is not None and plot.suffix not in PLOTS:
        raise ValueRefused(f"--plot {plot}: expected {', '.join(PLOTS)}")
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
        whose = identity_of(loop)
    text = {"schema_version": SCHEMA_VERSION, **found.as_dict(), "controller": whose, "origin": loop.origin}
    if out is not None:
        _save(out, text)
    if plot is not None:
        draw(found, plot)
    if as_json:
        emit({**text, "out": None if out is None else str(out)})
    else:
        typer.echo(found.report())
        typer.echo(
            f"controller {whose['block']}: steps {whose['source_hash']} (as in an export's manifest.json), with "
            f"parameters {whose['fingerprint']}"
        )
        for kept in (out, plot):
            if kept is not None:
                typer.echo(f"saved: {kept}")
    if not found.passed:
        raise typer.Exit(MISSED)


PLOTS = (".png", ".svg", ".pdf")


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


def draw(found: Certification, path: Path) -> None:
    """The plot of the certificate that the verdict rests on; of a linear controller the Nyquist plot."""
    best = found.best if found.taken.nonlinear and found.best is not None else found.margins
    chosen = best if best.drawing else next(
        (c for c in (*found.autonomous, found.margins) if c.drawing), None
    )  # fmt: skip
    assert chosen is not None
    chosen.figure().savefig(path, dpi=150)
