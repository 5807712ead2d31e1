"""``leadscrew ballbar``: a circular test of a machine in simulation, or of a measured file, evaluated and drawn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.options import Engine, Folder, Json, Trust
from leadscrew.cli.output import deliver, free, progress, write_example
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.analysis.circular.evaluation import Evaluation
    from leadscrew.analysis.circular.paths import CircularTest
    from leadscrew.analysis.circular.synthetic import BallBar
    from leadscrew.experiment import Experiment
    from leadscrew.kernel.loop import Loop


RADIUS_MM, FEED_MM_MIN = 100.0, 1000.0


def loops_of(
    names: list[str], controller: str | None, scenario: str | None, changes: list[str], bar: bool
) -> tuple[list[Loop], BallBar | None]:
    """The loops of the axes with their changes made, and the bar if one is wanted."""
    from leadscrew.analysis.circular.synthetic import BallBar
    from leadscrew.cli.values import parse
    from leadscrew.kernel.parameters import entries

    experiments = [_experiment(n, controller, scenario) for n in names]
    prefixes = ["x.", "y."] if len(names) == 2 else [""]
    sheets = [e.settable() if changes else {} for e in experiments]
    known = {f"{p}{k}": v for p, sheet in zip(prefixes, sheets, strict=True) for k, v in sheet.items()}
    known |= {e.key: e for e in entries(BallBar(), "bar.")}
    parsed = parse(changes, known)
    of_bar = {k.removeprefix("bar."): v for k, v in parsed.items() if k.startswith("bar.")}
    if of_bar and not bar:
        raise ValueRefused(f"--set bar.{next(iter(of_bar))} is about the ball bar: give --bar")
    loops = []
    for prefix, experiment in zip(prefixes, experiments, strict=True):
        mine = {
            k.removeprefix(prefix): v for k, v in parsed.items() if k.startswith(prefix) and not k.startswith("bar.")
        }
        loops.append(replace(experiment, changes={**experiment.changes, **mine}).loop())
    return loops, BallBar(**of_bar) if bar else None


def _experiment(name: str, controller: str | None, scenario: str | None) -> Experiment:
    from leadscrew.cli.subject import experiment_of

    found = experiment_of(name)
    given: dict[str, Any] = {"controller": controller, "scenario": scenario}
    return replace(found, **{k: v for k, v in given.items() if v is not None}).with_first_scenario()


def simulated(
    loops: list[Loop], wanted: tuple[Any, ...], encoder: bool, unit: str | None, engine: str | None
) -> CircularTest:
    from leadscrew.analysis.circular.simulation import Circle, Machine, draw

    radius, feed, direction, start, points = wanted
    circle = Circle(
        radius_mm=RADIUS_MM if radius is None else radius,
        feed_mm_min=FEED_MM_MIN if feed is None else feed,
        direction=direction or "both",
        start_deg=start or 0.0,
        points=1800 if points is None else points,
        source="encoder" if encoder else "path",
    )
    with progress() as bar:
        return draw(Machine(loops[0], loops[1] if len(loops) == 2 else None, unit), circle, engine, bar)


FILES = (".csv", ".txt")


def ballbar(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="SUBJECT",
            help="What draws the circle: path/file.py:NAME of a loop of two axes (or of one, with --y), an experiment "
            "file, a study with --controller; or a measured file (.csv).",
        ),
    ],
    y: Annotated[
        str | None, typer.Option("--y", metavar="SUBJECT", help="The loop of Y, where SUBJECT moves X alone.")
    ] = None,
    radius: Annotated[float | None, typer.Option(metavar="MM", help="Of the circle; 100 for a loop.")] = None,
    feed: Annotated[float | None, typer.Option(metavar="MM/MIN", help="Along the circle; 1000 for a loop.")] = None,
    direction: Annotated[str | None, typer.Option(help="both (the default), ccw or cw.")] = None,
    start: Annotated[float | None, typer.Option(metavar="DEG", help="Angle of the start point.")] = None,
    points: Annotated[int | None, typer.Option(metavar="N", help="A turn; 1800 unless given.")] = None,
    encoder: Annotated[
        bool, typer.Option("--encoder", help="The circle of the encoder signals instead of the true path.")
    ] = False,
    bar: Annotated[bool, typer.Option("--bar", help="Also what a double ball bar would read.")] = False,
    edition: Annotated[str, typer.Option(help="Names and quantities of ISO 230-4: 1996, 2005 or 2022.")] = "2022",
    lead_x: Annotated[
        float | None, typer.Option(metavar="MM", help="Pitch of X's cyclic error; searched for unless given.")
    ] = None,
    lead_y: Annotated[float | None, typer.Option(metavar="MM", help="The same of Y.")] = None,
    centre: Annotated[
        str | None, typer.Option(metavar="X,Y", help="Of the nominal circle in a measured file, mm; 0,0 unless given.")
    ] = None,
    controller: Annotated[str | None, typer.Option("--controller", "-c", help="As for simulate.")] = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", "-s", help="Of the study; its first unless given.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="A parameter of the loop (with --y: x.KEY or y.KEY), or of the bar, as bar.centring_x_um=5.",
        ),
    ] = None,
    unit: Annotated[str | None, typer.Option(help="Of the loop's positions, where its blocks say none.")] = None,
    engine: Engine = None,
    out: Folder = None,
    example: Annotated[
        bool, typer.Option("--example", help="Write a synthetic measurement to SUBJECT instead, to see such a file.")
    ] = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Circular test (double ball bar) in the sense of ISO 230-4, with the faults that it shows.

    A machine in simulation draws the circle itself: from rest, one turn to settle, then the measured one. A measured
    file has the columns x_mm, y_mm, or angle_deg and deviation_um or radius_mm.
    """
    of_loop = {
        "--y": y, "--direction": direction, "--start": start, "--points": points, "--bar": bar or None,
        "--controller": controller, "--scenario": scenario, "--set": changes, "--unit": unit, "--engine": engine,
    }  # fmt: skip
    if example:
        if any(v is not None for v in (*of_loop.values(), out)) or as_json:
            raise ValueRefused("--example only writes SUBJECT; leave the other options for the evaluation of it")
        _write_example(subject)
        return
    from leadscrew.analysis.circular.evaluation import evaluate
    from leadscrew.analysis.circular.quantities import EDITIONS

    if edition not in EDITIONS:
        raise ValueRefused(f"--edition {edition}: expected {', '.join(EDITIONS)}")
    free([out])
    instrument: BallBar | None = None
    if subject.lower().endswith(FILES):
        given = next((k for k, v in of_loop.items() if v is not None), None)
        if given is not None:
            raise ValueRefused(f"{given} is about a loop that draws the circle; {subject} is a measured file")
        test = _measured(subject, radius, feed, centre, encoder)
    else:
        if centre is not None:
            raise ValueRefused("--centre is about a measured file; a loop draws around a centre of its own")
        names = [n for n in (subject, y) if n is not None]
        loops, instrument = loops_of(names, controller, scenario, changes or [], bar)
        drawn = simulated(loops, (radius, feed, direction, start, points), encoder, unit, engine)
        test = replace(drawn, name=" and ".join(" ".join(filter(None, (n, controller, scenario))) for n in names))
    leads = (lead_x, lead_y)
    found = evaluate(test, edition, leads)
    read: Evaluation | None = None
    if instrument is not None:
        from leadscrew.analysis.circular.synthetic import read_by

        read = evaluate(read_by(instrument, test), edition, leads)
    from leadscrew.report.ballbar import report_of

    deliver(report_of(found, read), out=out, as_json=as_json)


def _measured(
    subject: str, radius: float | None, feed: float | None, centre: str | None, encoder: bool
) -> CircularTest:
    from leadscrew.analysis.circular.file import read_circles

    if radius is None:
        raise ValueRefused(f"--radius is missing: {subject} does not say which circle was commanded")
    at = _pair("--centre", centre) if centre is not None else (0.0, 0.0)
    return read_circles(subject, radius, feed, at, "encoder" if encoder else "measured")


def _pair(option: str, text: str) -> tuple[float, float]:
    parts = text.split(",")
    try:
        x, y = (float(p) for p in parts)
    except ValueError:
        raise ValueRefused(f"{option} {text}: expected two numbers, X,Y") from None
    if not (abs(x) < 1e9 and abs(y) < 1e9):
        raise ValueRefused(f"{option} {text}: expected two finite numbers below 1e9 mm")
    return x, y


def _write_example(subject: str) -> None:
    from leadscrew.analysis.circular.synthetic import FEED_MM_MIN, RADIUS_MM, example

    file = Path(subject)
    if file.suffix.lower() not in FILES:
        raise ValueRefused(f"--example writes a measured file: its name ends in .csv, not {file.name!r}")
    next_ = f"leadscrew ballbar {shell(file)} --radius {RADIUS_MM:g} --feed {FEED_MM_MIN:g}"
    write_example(file, example(), "an example of a measured circle", next_)
