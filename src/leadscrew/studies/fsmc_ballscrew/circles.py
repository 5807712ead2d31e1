"""Circles of two stages, X by a cosine and Y by a sine, as a double ball bar would see them.

Both axes are the stage of the study, each with a loop of its own; nothing couples them. X starts at rest at its
reversal with its bristles unbent, Y in the middle of its travel in steady sliding; the second turn is measured, at
1,800 points evenly spaced in the commanded angle. Clockwise, the command of Y is turned round. Laws, friction and scale
are odd, so that Y then draws its own mirror image: with ``both=False`` it is not run again.

:mod:`leadscrew.analysis.circular.drawn` draws circles of any loop with a start as on a machine, from rest, and in both
directions; here the loops are those of the sines, one compiled program a controller, and the start is the one of the
numbers that the study is checked against.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import TURN, USUAL, CircularTest, Floats, Turn
from leadscrew.controllers.sliding.continuous import in_motion
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.machines import bent
from leadscrew.studies.fsmc_ballscrew.runs import PERIOD_S, Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SineMove
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import Loop


class Way(NamedTuple):
    """A circle."""

    radius_mm: float
    rate_rad_s: float

    @property
    def feed_mm_min(self) -> float:
        """Along the circle."""
        return 60.0 * self.radius_mm * self.rate_rad_s


CIRCLES: dict[str, Way] = {
    "r5": Way(5.0, 1.0),
    "r1": Way(1.0, 2.0 * math.pi),
    "r100": Way(100.0, 1000.0 / 60.0 / 100.0),
}
"""300 mm/min and 377 mm/min, the axes then move as in Figures 13 and 14, and the 1,000 mm/min of a usual test."""


def drawn(
    loops: Loops,
    controller: str | Block,
    way: Way,
    both: bool = True,
    turns: float = 2.0,
    points: int = USUAL,
    **options: Any,
) -> CircularTest:
    """The circle of a controller; the last of ``turns`` is measured. ``options``: of the study's loops.

    Raises:
        DataError: what was drawn is no circle.
    """
    block = CONTROLLERS[controller] if isinstance(controller, str) else controller
    before = TURN * (turns - 1.0)
    phi = before + TURN * np.arange(points) / points
    axes = ("x", "y", "-y") if both else ("x", "y")
    lives = [axis_loop(loops, block, way, axis, options).start() for axis in axes]
    with ThreadPoolExecutor(len(lives)) as side_by_side:
        off = dict(zip(axes, side_by_side.map(lambda live: _errors(live, phi / way.rate_rad_s), lives), strict=True))
    x = way.radius_mm * np.cos(phi) + off["x"]
    y = way.radius_mm * np.sin(phi) + off["y"]
    other = -way.radius_mm * np.sin(phi) + off["-y"] if both else -y
    rate = "in continuous time" if block.continuous else f"at {1e-3 / options.get('period', PERIOD_S):g} kHz"
    return CircularTest(
        way.radius_mm, Turn("ccw", x, y), Turn("cw", x, other), feed_mm_min=way.feed_mm_min,
        start_deg=math.degrees(before) % 360.0, name=controller if isinstance(controller, str) else block.name,
        sampling=f"{points} points a turn, {rate}; last of {turns:g} turns",
    )  # fmt: skip


def axis_loop(loops: Loops, block: Block, way: Way, axis: str, options: Mapping[str, Any] | None = None) -> Loop:
    """The loop of ``x``, ``y`` or, clockwise, ``-y``."""
    sign = -1.0 if axis == "-y" else 1.0
    ahead = 0.5 * math.pi if axis == "x" else 0.0
    scenario = Scenario("circle", SineMove(way.radius_mm, way.rate_rad_s), "one axis of a circle", 1.0)
    given: dict[str, Any] = dict(options or {})
    changes = {"reference.phase": ahead, "reference.amplitude": sign * way.radius_mm} | given.pop("changes", {})
    if block.continuous:
        given = {"sample": TURN / way.rate_rad_s / USUAL} | given
    loop = loops.get(block, scenario, changes=changes, **given)
    plant, law = loop.blocks["plant"], loop.blocks["controller"]
    assert plant is not None and law is not None
    speed = 0.0 if axis == "x" else sign * way.radius_mm * way.rate_rad_s / TRAVEL_MM_PER_RAD
    angle = way.radius_mm / TRAVEL_MM_PER_RAD if axis == "x" else 0.0
    loop.blocks["plant"] = bent(plant, speed).starting(angle=angle)
    if law.continuous:
        loop.blocks["controller"] = in_motion(law, speed)
    return loop


def _errors(live: Live, when: Floats) -> Floats:
    """Deviation of an axis from its command at these times, in its unit."""
    period = live.loop.period
    first = max(math.floor(float(when[0]) / period) - 2, 1)
    last = math.ceil(float(when[-1]) / period) + 2
    live.advance(first, record=(), every=0)
    run = live.advance(last - first, record=("true_error",))
    return np.asarray(-np.interp(when, run.time, run["true_error"]))
