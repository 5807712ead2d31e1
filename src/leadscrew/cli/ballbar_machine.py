"""The machine of ``leadscrew ballbar``: loops with their changes made, and the circle that they draw."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from leadscrew.cli.output import progress
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
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
    from leadscrew.kernel.sheet import entries

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
