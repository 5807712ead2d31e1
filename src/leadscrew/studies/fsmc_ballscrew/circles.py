"""Circles of two stages, as a double ball bar would see them, and feeds so slow that the stage sticks and slips.

Both axes of a circle are the stage of the study, X on a cosine and Y on a sine, each with a loop of its own; nothing
couples them. X starts at rest at its reversal with its bristles unbent, Y in the middle of its travel in steady
sliding; the last turn is measured, at 1,800 points evenly spaced in the commanded angle. Clockwise, the command of Y is
turned round. Laws, friction and scale are odd, so that Y then draws its own mirror image: with ``both=False`` it is not
run again.

:mod:`leadscrew.analysis.circular.simulation` draws circles of any loop with a start as on a machine, from rest, and in
both directions; here the loops are those of the sines, one compiled program a controller.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import TURN, USUAL, CircularTest, Floats, Turn
from leadscrew.analysis.circular.quantities import BothWays, OneWay, quantities
from leadscrew.analysis.circular.reversals import Reversal, reversals
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.kernel.block import Block
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import PERIOD_S, SineMove
from leadscrew.studies.lab import Lab, measure
from leadscrew.study_data import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


class Way(NamedTuple):
    """A circle."""

    radius_mm: float
    rate_rad_s: float

    @property
    def feed_mm_min(self) -> float:
        """Along the circle."""
        return 60.0 * self.radius_mm * self.rate_rad_s

    def __str__(self) -> str:
        return f"R = {self.radius_mm:g} mm at {self.feed_mm_min:.0f} mm/min"


CIRCLES: dict[str, Way] = {
    "r5": Way(5.0, 1.0),
    "r1": Way(1.0, 2.0 * math.pi),
    "r100": Way(100.0, 1000.0 / 60.0 / 100.0),
}
"""300 mm/min and 377 mm/min, the axes then move as in Figures 13 and 14, and the 1,000 mm/min of a usual test."""


IDEAL = ("corrected.smc", "paper.csmc", "corrected.fsmc")
"""The paper's three in continuous time."""
NO_MODEL = pd_dob(
    kp=300.0, kd=0.9, kp_slow=0.0, kd_slow=0.0, observer_rate=1250.0, rate_of_error=False, friction=False,
    travel_per_rad=TRAVEL_MM_PER_RAD,
)  # fmt: skip
"""PD with the observer as its integral and without a model of friction: a PID. The gains are ours."""
SLOW_FSMC, PID = "fsmc", "pid"
BLOCKS: dict[str, Block] = {
    SLOW_FSMC: CONTROLLERS["ours.fsmc_4khz_slow"],
    PID: NO_MODEL,
    "fsmc_undamped": CONTROLLERS["ours.fsmc_4khz_slow"].using(**{"hat.damping": 0.0}),
}
"""Controllers beside those of the study. ``fsmc_undamped`` believes no damping of the bristles."""
NAMES = {SLOW_FSMC: "FSMC at 4 kHz, λ = 150 1/s", PID: "PID at 4 kHz without a model"}


def block_of(name: str) -> Block:
    """A controller of :data:`BLOCKS` or of the study."""
    return BLOCKS[name] if name in BLOCKS else CONTROLLERS[name]


# ---- circles
@measure
def circle_of(
    lab: Lab, controller: str, way: Way, both: bool = False, turns: float = 2.0, true_viscous: bool = False,
    **options: Any,
) -> CircularTest:  # fmt: skip
    """The circle of a controller; the last of ``turns`` is measured. ``options``: of the study's loops.

    With ``true_viscous`` the controller believes the viscous friction that the stage has.
    """
    block = block_of(controller)
    block = block.using(**{"hat.viscous": 0.4}) if true_viscous else block
    before = TURN * (turns - 1.0)
    phi = before + TURN * np.arange(USUAL) / USUAL
    axes = ("x", "y", "-y") if both else ("x", "y")
    off = {a: _errors(axis_loop(lab, block, way, a, **options), phi / way.rate_rad_s) for a in axes}
    x = way.radius_mm * np.cos(phi) + off["x"]
    y = way.radius_mm * np.sin(phi) + off["y"]
    other = -way.radius_mm * np.sin(phi) + off["-y"] if both else -y
    rate = "in continuous time" if block.continuous else f"at {1e-3 / options.get('period', PERIOD_S):g} kHz"
    return CircularTest(
        way.radius_mm, Turn("ccw", x, y), Turn("cw", x, other), feed_mm_min=way.feed_mm_min,
        start_deg=math.degrees(before) % 360.0, name=controller,
        sampling=f"{USUAL} points a turn, {rate}; last of {turns:g} turns",
    )  # fmt: skip


def axis_loop(lab: Lab, block: Block, way: Way, axis: str, **options: Any) -> Loop:
    """The loop of ``x``, ``y`` or, clockwise, ``-y``."""
    sign = -1.0 if axis == "-y" else 1.0
    scenario = Scenario("circle", SineMove(way.radius_mm, way.rate_rad_s), "one axis of a circle", 1.0)
    changes = {"reference.phase": 0.5 * math.pi if axis == "x" else 0.0, "reference.amplitude": sign * way.radius_mm}
    speed = 0.0 if axis == "x" else sign * way.radius_mm * way.rate_rad_s / TRAVEL_MM_PER_RAD
    given = {"sample": TURN / way.rate_rad_s / USUAL} | options if block.continuous else options
    loop = lab.loop(block, scenario, changes=changes, speed=speed, **given)
    plant = loop.blocks["plant"]
    assert plant is not None
    loop.blocks["plant"] = plant.starting(angle=way.radius_mm / TRAVEL_MM_PER_RAD if axis == "x" else 0.0)
    return loop


def _errors(loop: Loop, when: Floats) -> Floats:
    """Deviation of an axis from its command at these times, in its unit."""
    first = max(math.floor(float(when[0]) / loop.period) - 2, 1)
    last = math.ceil(float(when[-1]) / loop.period) + 2
    live = loop.start()
    live.advance(first, record=(), every=0)
    run = live.advance(last - first, record=("true_error",))
    return np.asarray(-np.interp(when, run.time, run["true_error"]))


def both(test: CircularTest) -> BothWays:
    """Quantities of both directions."""
    found = quantities(test).both
    assert found is not None
    return found


def one(test: CircularTest) -> OneWay:
    """Quantities of the counter-clockwise turn."""
    found = quantities(test).ccw
    assert found is not None
    return found


HZ = (0.1, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Turns per second of Figure 21, at R = 1 mm."""
RADIUS_LAWS = (*IDEAL, "fsmc_undamped")


def radius_um(lab: Lab, controller: str, hz: float, true_viscous: bool = False) -> float:
    """D at R = 1 mm, um."""
    return both(circle_of(lab, controller, Way(1.0, TURN * hz), true_viscous=true_viscous)).mean_radial


class Glitch(NamedTuple):
    """The quadrant glitches of the counter-clockwise turn."""

    height_um: float
    """Of the tallest."""
    lasts_s: float
    """Of the longest: until the radius stays within a tenth of the peak."""


def glitch(test: CircularTest) -> Glitch:
    """Its glitches."""
    found: list[Reversal] = [r for r in reversals(test) if r.direction == "ccw"]
    return Glitch(max(abs(r.height_um) for r in found), max(r.duration_s or math.inf for r in found))


@measure
def around_reversal(lab: Lab, controller: str, way: Way, seconds: float = 0.06) -> tuple[Floats, Floats, Floats]:
    """Time in ms from the reversal of X, and there command and table, um from the end of the travel."""
    loop, turn = axis_loop(lab, block_of(controller), way, "x"), math.pi / way.rate_rad_s
    live = loop.start()
    live.advance(math.floor((turn - seconds) / loop.period), record=(), every=0)
    run = live.advance(math.ceil(2.0 * seconds / loop.period), record=("true_error", "command.position"))
    above = 1e3 * (run["command.position"] + way.radius_mm)
    return 1e3 * (run.time - turn), above, above - 1e3 * run["true_error"]


# ---- stick-slip at a constant feed
FEEDS_UM_S = (1.0, 2.0, 4.0, 5.0, 10.0)
SECONDS, SETTLED_S = 6.0, 2.0
LEAST_UM = 0.01
"""Less than this peak to peak is no stick-slip: one count of the scale."""
SLOW_CIRCLE = Way(0.1, 0.2)
"""R = 0.1 mm at 20 um/s, 1.2 mm/min."""
NEAR_DEG, FAR_DEG = 20.0, 25.0


class Creep(NamedTuple):
    """A run at constant feed, after it has settled."""

    time: Floats
    error_um: Floats
    fastest: float
    """Largest speed over the feed."""

    @property
    def peak_to_peak_um(self) -> float:
        """Of the error."""
        return float(np.ptp(self.error_um))


@measure
def creep(lab: Lab, controller: str, feed_um_s: float, encoder_nm: float = 0.0, falling: bool = True) -> Creep:
    """A run at constant feed from steady sliding; ``falling`` False: on a stage with F_S = F_C.

    Without the scale's counts, unless asked for: 10 nm are enough to start the stage slipping where it would slide.
    """
    feed = 1e-3 * feed_um_s
    changes = {"reference.rate": feed, "reference.duration": 100.0 * SECONDS}
    changes |= {} if falling else {"plant.friction.static": 6.24}
    loop = lab.loop(
        block_of(controller), "creep", changes=changes, encoder_nm=encoder_nm, speed=feed / TRAVEL_MM_PER_RAD
    )
    run = loop.run(SECONDS, record=("true_error", "plant.speed"))
    late = run.time >= SETTLED_S
    fastest = TRAVEL_MM_PER_RAD * float(np.abs(run["plant.speed"][late]).max()) / feed
    return Creep(run.time[late], -1e3 * run["true_error"][late], fastest)


def trend(sizes: Sequence[float]) -> str:
    """What sizes do from feed to feed, in Kakino's words."""
    if any(b > a + LEAST_UM for a, b in pairwise(sizes)):
        return "does not decrease"
    return "decreases, then eliminated" if sizes[-1] <= LEAST_UM else "decreases"


def slow_circle(lab: Lab) -> CircularTest:
    """Figure 20: a circle of FSMC at 4 kHz so slow that the axes stick near their reversals; no counts of the scale."""
    return circle_of(lab, SLOW_FSMC, SLOW_CIRCLE, turns=1.25, encoder_nm=0.0)


def jumps_um(test: CircularTest) -> tuple[Floats, Floats]:
    """Degrees from the nearest axis, and the change of the radius to the next point, counter-clockwise."""
    assert test.ccw is not None
    quarter = np.mod(np.degrees(test.ccw.angle), 90.0)
    change = np.abs(np.diff(test.ccw.deviation_um(test.radius_mm)))
    return np.minimum(quarter, 90.0 - quarter)[:-1], change
