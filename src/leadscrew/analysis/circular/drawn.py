"""A loop draws the circle of a ball-bar test: its reference is replaced by a circle, everything else stays.

A loop of two axes has a command with the fields ``x`` and ``y`` (positions, or motions with derivatives), and shows its
place with the same fields. Two loops of one axis each make a machine too: one moves X, the other Y, without coupling.

In each direction the machine starts at rest where its axes stand, on the circle. It comes up to the feed within an
eighth of the first turn, settles during the rest of it, and the second turn is measured. Between control periods the
deviation from the command is interpolated linearly, at points evenly spaced in the angle of the command. Axes and
directions are runs of their own: on a compiled engine they run side by side, with the same bits as one by one.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular import command
from leadscrew.analysis.circular.machine import Machine, place_of, reference_of, with_reference
from leadscrew.analysis.circular.paths import CCW, CW, FEWEST, TURN, USUAL, CircularTest, Floats, Turn, positive
from leadscrew.kernel.errors import DataError, Diverged, ValueRefused
from leadscrew.kernel.loop import DivergenceWarning, Loop

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live

MOST_ROWS = 200_000
"""Recorded control periods of a turn; of more only every n-th is kept."""
SEEN = {"path": "actual", "encoder": "feedback"}
"""The signal of a loop that a source reads."""
MOST_PERIODS = 2_000_000_000


@dataclass(frozen=True)
class Circle:
    """What is to be drawn.

    Raises:
        ValueRefused: a radius, feed or number of points that makes no circle; names value and range.
    """

    radius_mm: float = 100.0
    feed_mm_min: float = 1000.0
    direction: str = "both"
    """``ccw``, ``cw`` or ``both``."""
    start_deg: float = 0.0
    points: int = USUAL
    """Of a turn."""
    source: str = "path"
    """``path``, or ``encoder`` for what the sensors say."""

    def __post_init__(self) -> None:
        positive("radius", self.radius_mm, "mm")
        positive("feed", self.feed_mm_min, "mm/min")
        if self.direction not in ("both", CCW, CW):
            raise ValueRefused(f"direction = {self.direction!r}: expected both, ccw or cw")
        if not math.isfinite(self.start_deg):
            raise ValueRefused(f"start = {self.start_deg!r} degrees: expected a finite number")
        if not FEWEST <= self.points <= MOST_ROWS:
            raise ValueRefused(f"points = {self.points!r} a turn: expected {FEWEST} to {MOST_ROWS}; {USUAL} are usual")
        if self.source not in SEEN:
            raise ValueRefused(f"source = {self.source!r}: expected path or encoder")

    @property
    def speed(self) -> float:
        """Angular speed, rad/s."""
        return self.feed_mm_min / 60.0 / self.radius_mm


def draw(
    machine: Machine,
    circle: Circle,
    engine: str | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> CircularTest:
    """The circular test of a machine in simulation.

    Raises:
        ValueRefused: a loop that has not two axes, no length, or whose turn takes less than eight control periods.
        Diverged: a loop diverged on the way.
        DataError: the path is no full circle in the commanded direction, or the axes are swapped.
    """
    scale = machine.mm()
    turns: dict[str, Turn] = {}
    wanted = [w for w in (CCW, CW) if circle.direction in ("both", w)]
    period, apart = machine.x.period, 0.0
    made = {direction: _started(machine, circle, direction, scale, engine) for direction in wanted}
    runs = _runs([axis.live for axes in made.values() for axis in axes], circle, progress)
    for direction, axes in made.items():
        x, y = _path(machine, circle, direction, scale, axes, runs)
        turns[direction] = Turn(direction, x[:-1], y[:-1])
        apart = max(apart, 1000.0 * math.hypot(x[-1] - x[0], y[-1] - y[0]))
    each = TURN / circle.speed / period
    return CircularTest(
        circle.radius_mm, turns.get(CCW), turns.get(CW), feed_mm_min=circle.feed_mm_min, source=circle.source,
        start_deg=circle.start_deg, open_um=apart,
        sampling=f"{circle.points} points a turn, from {each:.0f} control periods of {period:g} s; second turn",
        name=machine.x.name if machine.y is None else f"{machine.x.name} and {machine.y.name}",
    )  # fmt: skip


class _Axis(NamedTuple):
    """One axis in one direction."""

    live: Live
    key: str
    """The signal that is its place."""
    centre: float
    """Of the circle, in the unit of the loop."""


def _started(machine: Machine, circle: Circle, direction: str, scale: float, engine: str | None) -> list[_Axis]:
    """Both axes, ready to draw; of a loop of two axes the same run twice."""
    start = math.radians(circle.start_deg)
    radius = circle.radius_mm / scale
    both = machine.y is None
    loops = [machine.x] if machine.y is None else [machine.x, machine.y]
    fields = [".x", ".y"] if both else ["", ""]
    at = [place_of(loops[i % len(loops)], "actual", fields[i], i)[1] for i in (0, 1)]
    centre = at[0] - radius * math.cos(start), at[1] - radius * math.sin(start)
    values = {
        "radius": radius, "speed": circle.speed, "turning": 1.0 if direction == CCW else -1.0, "start": start,
        "centre_x": centre[0], "centre_y": centre[1],
    }  # fmt: skip
    found: list[_Axis] = []
    for which, loop in enumerate([machine.x, machine.x if machine.y is None else machine.y]):
        key = place_of(loop, SEEN[circle.source], fields[which], which)[0]
        if both and found:
            live = found[0].live
        else:
            ready = with_reference(loop, reference_of(loop, which, both).using(**values))
            _refuse_length(ready, circle)
            # Numbers of the runs in the noise: each axis and direction has noise of its own.
            live = ready.start(engine=engine, replicate=which + (0 if direction == CCW else 2))
        found.append(_Axis(live, key, centre[which]))
    return found


def _path(
    machine: Machine, circle: Circle, direction: str, scale: float, axes: list[_Axis], runs: dict[int, Any]
) -> tuple[Floats, Floats]:
    """Both axes at the points of the second turn and at its end, from the centre of the circle, mm."""
    start = math.radians(circle.start_deg)
    sign = 1.0 if direction == CCW else -1.0
    radius = circle.radius_mm / scale
    turned = TURN * np.arange(circle.points + 1) / circle.points
    when = (TURN + turned + 0.5 * command.QUARTER) / circle.speed
    here = start + sign * (TURN + turned)
    found = []
    for axis, wave in zip(axes, (np.cos, np.sin), strict=True):
        run = runs[id(axis.live)]
        phi = start + sign * (circle.speed * run["time"] - 0.5 * command.QUARTER)
        off = run[axis.key] - (axis.centre + radius * wave(phi))
        found.append(scale * (np.interp(when, run["time"], off) + radius * wave(here)))
    _refuse_swapped(machine, circle, found, here, (scale * axes[0].centre, scale * axes[1].centre))
    return found[0], found[1]


def _refuse_swapped(
    machine: Machine, circle: Circle, found: list[Floats], phi: Floats, centre: tuple[float, float]
) -> None:
    x, y = found[0] + centre[0] - centre[1], found[1] + centre[1] - centre[0]
    off = np.hypot(x - circle.radius_mm * np.sin(phi), y - circle.radius_mm * np.cos(phi))
    if float(off.max()) < 0.2 * circle.radius_mm:
        raise DataError(
            f"{machine.x.name}: X follows the command of Y, and Y that of X; are the axes swapped, in the controller "
            "or in the feedback?"
        )


def _runs(lives: list[Live], circle: Circle, progress: Callable[[str, float], None] | None) -> dict[int, Any]:
    """The signals of each live loop by its id; side by side, on threads, where the engine is compiled."""
    each = {id(live): live for live in lives}
    found: dict[int, Any] = {}
    with warnings.catch_warnings(), ThreadPoolExecutor(min(len(each), os.cpu_count() or 1)) as crew:
        warnings.simplefilter("ignore", DivergenceWarning)
        one_by_one = any(live.engine == "python" for live in lives)
        signals = (map if one_by_one else crew.map)(lambda live: _run(live, circle), each.values())
        for key in each:
            if progress is not None:
                progress(f"turns of radius {circle.radius_mm:g} mm", len(found) / len(each))
            found[key] = next(signals)
    return found


def _refuse_length(loop: Loop, circle: Circle) -> None:
    each = TURN / circle.speed / loop.period
    if 8.0 <= each <= MOST_PERIODS / 4:
        return
    wanted = "at least 8" if each < 8.0 else f"at most {MOST_PERIODS / 4:g}"
    raise ValueRefused(
        f"a turn of radius {circle.radius_mm:g} mm at {circle.feed_mm_min:g} mm/min takes {each:.3g} control periods; "
        f"expected {wanted}"
    )


def _run(live: Live, circle: Circle) -> Any:
    """Signals of the second turn, and a little on both sides."""
    period = live.loop.period
    first = max(math.floor(command.time_of(1.0, circle.speed) / period) - 2, 1)
    last = math.ceil(command.time_of(2.0, circle.speed) / period) + 2
    every = max(1, math.floor((last - first) / MOST_ROWS))
    last += every
    run = live.advance(first, record=(), every=0)
    if run.diverged is None:
        run = live.advance(last - first, record=[SEEN[circle.source]], every=every)
    if run.diverged is not None:
        raise Diverged(f"{live.loop.name} {run.diverged} on the circle", run)
    return run.signals
