"""A loop draws the circle of a ball-bar test: its reference is replaced by a circle, everything else stays.

A loop of two axes has a command with the fields ``x`` and ``y`` (positions, or motions with derivatives), and shows its
place with the same fields. Two loops of one axis each make a machine too: one moves X, the other Y, without coupling.

In each direction the machine starts at rest where its axes stand, on the circle. It comes up to the feed within an
eighth of the first turn, settles during the rest of it, and the second turn is measured. Between control periods the
deviation from the command is interpolated linearly, at points evenly spaced in the angle of the command. Axes and
directions are runs of their own: on a compiled engine they run side by side, with the same bits as one by one.

A circle as the command of a loop: at rest, then up to speed smoothly, then turn after turn at constant feed.

    phi(t) = start + d w T (q^3 - q^4 / 2),  q = t / T      up to T
    phi(t) = start + d w (t - T / 2)                        from there
    x = x_c + R cos phi,   y = y_c + R sin phi

``d`` is 1 counter-clockwise and -1 clockwise, ``w = feed / R``. The angular speed rises as ``3 q^2 - 2 q^3``: speed and
acceleration have no jump at either end, the jerk is finite. ``T`` is a quarter of the time of a turn, so that an eighth
of a turn brings it up to speed. Velocities and accelerations are exact derivatives.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CCW, CW, FEWEST, TURN, USUAL, CircularTest, Floats, Turn, positive
from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.frame import as_floats
from leadscrew.kernel.layout import Layout
from leadscrew.kernel.loop import DivergenceWarning, Loop
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.references._motion import Motion
from leadscrew.references._path import PathPoint, PathPoint3
from leadscrew.util.errors import DataError, Diverged, ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live


class CircleParams(NamedTuple):
    """The circle, in the unit of the loop's command."""

    radius: Annotated[float, Gt(0), Doc("of the circle")] = 100.0
    speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("angular speed at the feed")] = 1.0
    turning: Annotated[float, Doc("1 counter-clockwise, -1 clockwise")] = 1.0
    start: Annotated[float, Unit("rad"), Doc("angle of the start point, from +x towards +y")] = 0.0
    centre_x: Annotated[float, Doc("of the circle")] = 0.0
    centre_y: Annotated[float, Doc("of the circle")] = 0.0


class Point(NamedTuple):
    """Positions of two axes, for controllers that take no derivatives."""

    x: float = 0.0
    y: float = 0.0


class Point3(NamedTuple):
    """Positions of three axes."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


QUARTER = 0.5 * math.pi
"""Angle that the feed would turn in the time that it takes to come up to it, rad."""


def phase(p, t):
    """Angle, its rate and its acceleration."""
    rise = QUARTER / p.speed
    q = min(t / rise, 1.0)
    ahead = p.speed * max(t - rise, 0.0)
    turned = QUARTER * (q * q * q - 0.5 * q * q * q * q) + ahead
    rate = p.speed * q * q * (3.0 - 2.0 * q)
    growth = p.speed / rise * 6.0 * q * (1.0 - q)
    return Motion(p.start + p.turning * turned, p.turning * rate, p.turning * growth)


def along_x(p, t):
    """Motion of X."""
    turn = phase(p, t)
    c = p.radius * math.cos(turn.position)
    s = p.radius * math.sin(turn.position)
    square = turn.velocity * turn.velocity
    return Motion(p.centre_x + c, -s * turn.velocity, -s * turn.acceleration - c * square)


def along_y(p, t):
    """Motion of Y."""
    turn = phase(p, t)
    c = p.radius * math.cos(turn.position)
    s = p.radius * math.sin(turn.position)
    square = turn.velocity * turn.velocity
    return Motion(p.centre_y + s, c * turn.velocity, c * turn.acceleration - s * square)


@reference(CircleParams())
def circle_motion(p, t):
    """The circle with derivatives, for both axes."""
    return PathPoint(along_x(p, t), along_y(p, t))


@reference(CircleParams())
def circle_motion_3(p, t):
    """The same for three axes; the third rests at 0."""
    return PathPoint3(along_x(p, t), along_y(p, t), Motion(0.0, 0.0, 0.0))


@reference(CircleParams())
def circle_point(p, t):
    """Positions of both axes."""
    return Point(along_x(p, t).position, along_y(p, t).position)


@reference(CircleParams())
def circle_point_3(p, t):
    """Positions of three axes; the third rests at 0."""
    return Point3(along_x(p, t).position, along_y(p, t).position, 0.0)


@reference(CircleParams())
def circle_x_motion(p, t):
    """Motion of X alone."""
    return along_x(p, t)


@reference(CircleParams())
def circle_y_motion(p, t):
    """Motion of Y alone."""
    return along_y(p, t)


@reference(CircleParams())
def circle_x(p, t):
    """Position of X alone."""
    return along_x(p, t).position


@reference(CircleParams())
def circle_y(p, t):
    """Position of Y alone."""
    return along_y(p, t).position


def time_of(turns: float, speed: float) -> float:
    """When the circle has turned that far, past the rise, s."""
    return (2.0 * math.pi * turns + 0.5 * QUARTER) / speed


MM = {"mm": 1.0, "um": 1e-3, "m": 1e3, "in": 25.4, "inch": 25.4}
"""Millimetres in the units that a block may say."""


@dataclass(frozen=True)
class Machine:
    """What draws: one loop of two axes, or one loop for each."""

    x: Loop
    y: Loop | None = None
    """The loop of Y; None: ``x`` moves both."""
    unit: str | None = None
    """Of the loops' positions; what their blocks say unless given."""

    def mm(self) -> float:
        """Millimetres in the unit of the loops.

        Raises:
            ValueRefused: it is not known, no length, or differs between the axes.
        """
        said = {self.unit} if self.unit else {_unit(loop) for loop in (self.x, self.y) if loop is not None}
        if len(said) != 1:
            raise ValueRefused(f"the axes have different units: {', '.join(sorted(said))}; a circle needs one")
        unit = next(iter(said))
        if not unit:
            raise ValueRefused(f"{self.x.name} does not say the unit of its position; expected {', '.join(MM)}")
        if unit not in MM:
            raise ValueRefused(f"{self.x.name} moves in {unit}; a circle needs a length: {', '.join(MM)}")
        return MM[unit]


def _unit(loop: Loop) -> str:
    said = [b.unit for s in ("plant", "sensor", "reference") if (b := loop.blocks[s]) is not None]
    return next((u for u in said if u in MM), next((u for u in said if u), ""))


def with_reference(loop: Loop, reference: Block) -> Loop:
    """The loop with another reference; its metrics, which may be about the old one, left out."""
    held: dict[str, Any] = {s: b for s, b in loop.blocks.items() if s != "reference"}
    return Loop(
        reference=reference,
        metrics={},
        period=None if loop.continuous else loop.period,
        sample=loop.period,
        substeps=loop.substeps,
        method=loop.method,
        computation_delay=loop.sent * loop.step,
        transport_delay=loop.seen * loop.step,
        bound=loop.bound,
        seed=loop.seed,
        rtol=loop.rtol,
        atol=loop.atol,
        engine=loop.engine,
        name=loop.name,
        **held,
    )


def _leaves(signal: Any) -> dict[str, float]:
    """The numbers of a signal by dotted name; a lone number has none."""
    floats = as_floats(signal)
    layout = Layout(floats)
    values = layout.pack(floats)[0]
    return {leaf.key: float(values[leaf.at]) for leaf in layout.scalars}


def place_of(loop: Loop, signal: str, field: str, which: int) -> tuple[str, float]:
    """Column and first value of an axis's position in a signal."""
    leaves = {f".{k}" if k else "": v for k, v in _leaves(loop.signals[signal]).items()}
    for name in (f"{field}.position", field):
        if name in leaves:
            return signal + name, leaves[name]
    if field:
        shown = ", ".join(k.lstrip(".") for k in leaves if k) or "one number"
        raise ValueRefused(
            f"{loop.name} has not two axes: its {signal} is {shown}, expected x and y; give the loop of the other axis"
        )
    shown = ", ".join(k.lstrip(".") for k in leaves)
    if any(k.startswith(".x") for k in leaves) and any(k.startswith(".y") for k in leaves):
        raise ValueRefused(f"{loop.name} has both axes already; the loop of another axis is for a loop of one")
    raise ValueRefused(f"{loop.name}: its {signal} is {shown}; expected one position for axis {'XY'[which]}")


def reference_of(loop: Loop, which: int, both: bool) -> Block:
    """The circle in the form of the loop's command."""
    keys = set(_leaves(loop.signals["command"]))
    ends = {k.rsplit(".", 1)[-1] for k in keys}
    motion = bool(ends & {"position", "velocity", "acceleration"})
    if not both:
        if any(k not in ("", "position", "velocity", "acceleration") for k in keys):
            raise ValueRefused(
                f"{loop.name} is commanded by {', '.join(sorted(keys))}; a loop of one axis takes a position, or a "
                "motion"
            )
        blocks = (circle_x_motion, circle_y_motion) if motion else (circle_x, circle_y)
        return replace(blocks[which], unit=_unit(loop))
    axes = {k.split(".", 1)[0] for k in keys}
    if axes not in ({"x", "y"}, {"x", "y", "z"}):
        shown = ", ".join(sorted(axes)) or "one number"
        raise ValueRefused(
            f"{loop.name} has not two axes: it is commanded by {shown}, expected x and y; give the loop of the other "
            "axis"
        )
    if motion:
        return circle_motion if len(axes) == 2 else circle_motion_3
    return circle_point if len(axes) == 2 else circle_point_3


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
    when = (TURN + turned + 0.5 * QUARTER) / circle.speed
    here = start + sign * (TURN + turned)
    found = []
    for axis, wave in zip(axes, (np.cos, np.sin), strict=True):
        run = runs[id(axis.live)]
        phi = start + sign * (circle.speed * run["time"] - 0.5 * QUARTER)
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
    first = max(math.floor(time_of(1.0, circle.speed) / period) - 2, 1)
    last = math.ceil(time_of(2.0, circle.speed) / period) + 2
    every = max(1, math.floor((last - first) / MOST_ROWS))
    last += every
    run = live.advance(first, record=(), every=0)
    if run.diverged is None:
        run = live.advance(last - first, record=[SEEN[circle.source]], every=every)
    if run.diverged is not None:
        raise Diverged(f"{live.loop.name} {run.diverged} on the circle", run)
    return run.signals
