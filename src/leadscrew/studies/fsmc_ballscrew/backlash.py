"""Backlash: an impact behind a screw whose motion is imposed, and 2 um of play inside the loop.

In the loop: the stage with the classical play (:obj:`leadscrew.plants.ballscrew_play`) or with two masses
(:obj:`leadscrew.plants.ballscrew_backlash`), at 4 kHz with 10 nm a count, closed on the motor's encoder, on the table's
scale, or on both. Runs enter in motion, on the command, the table behind its flank.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CircularTest, Turn
from leadscrew.analysis.friction import imposed_loop
from leadscrew.plants._backlash import Play, followed
from leadscrew.plants._backlash_two_mass import damping_ratio, restitution_of
from leadscrew.plants._ballscrew_backlash import BallscrewBacklashParams, backlash_in_motion, ballscrew_backlash
from leadscrew.plants._ballscrew_play import ballscrew_play, play_in_motion
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.sensors._dual_encoder import dual_encoder
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import (
    ENCODER_NM,
    PERIOD_S,
    SCENARIOS,
    TIGHT,
    command,
    sine_of,
    start_speed,
)
from leadscrew.studies.lab import Lab, measure

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop
    from leadscrew.kernel.run import Run

GAP_UM = 2.0
"""Play of both machines."""
MOTOR, TABLE, BOTH = 1e6, 0.0, 1e-3
"""Lag of the table's reading, s: never, at once, and behind the motor's."""
SECONDS = {"sine_wide": 7.9, "sine_fast": 2.25}
"""Two half turns after the first reversal; a turn and a quarter after the first second."""
PLANTS = {"play": (ballscrew_play, play_in_motion), "two_mass": (ballscrew_backlash, backlash_in_motion)}
SEEN = 0.8
"""Part of the way to the next reversal that is looked at."""
BACK_UM = 0.1
"""A peak is over when the error stays within this, a twentieth of the play."""


# ---- in the loop
def backlash_loop(controller: str, scenario: str, machine: str, lag: float) -> Loop:
    """A controller on a sine, on ``play`` or ``two_mass``; ``lag`` as in :obj:`leadscrew.sensors.dual_encoder`."""
    from leadscrew.kernel.loop import Loop

    asked = SCENARIOS[scenario].params
    plant, in_motion = PLANTS[machine]
    return Loop(
        reference=command(asked),
        controller=CONTROLLERS[controller],
        plant=in_motion(plant(travel_per_rad=TRAVEL_MM_PER_RAD), start_speed(asked)),
        sensor=dual_encoder(lag=lag, resolution=1e-6 * ENCODER_NM),
        period=PERIOD_S,
        metrics={},
        bound=50.0,
        **TIGHT,
    )


@measure
def backlash_run(lab: Lab, controller: str, scenario: str, machine: str, lag: float) -> Run:
    """A run with command and table in mm; it may diverge."""
    loop = backlash_loop(controller, scenario, machine, lag)
    loop.adopt_program(lab.once(("program", loop.compiled_from()), lambda: loop))
    return loop.run(SECONDS[scenario], record=("command.position", "actual", "output"))


class Reversed(NamedTuple):
    """What a run shows of its reversals."""

    height_um: float
    """Largest error of the table after a reversal."""
    duration_s: float
    """From the reversal until the error stays within :data:`BACK_UM`; the longest. NaN: it never does."""
    offset_um: float
    """Half of the distance of the errors of both ways, far from the reversals: a step that stays."""
    diverged: str
    """When and in what the loop diverged; empty if it did not."""


def error_um(run: Any) -> np.ndarray:
    """Error of the table."""
    return np.asarray(1e3 * (run["actual.position"] - run["command.position"]))


def reversed_by(run: Any, rate: float) -> Reversed:
    """The reversals of a run on a sine of this angular frequency."""
    if run.diverged:
        return Reversed(math.nan, math.nan, math.nan, str(run.diverged))
    e, half = error_um(run), math.pi / rate
    heights, durations, offsets = [], [], []
    start = 0.5 * half
    while start + half <= run.time[-1] + 1e-9:
        inside = (run.time >= start) & (run.time < start + half)
        window, since = e[inside], run.time[inside] - start
        over = since[(np.abs(window) > BACK_UM) & (since < SEEN * half)]
        last = float(over[-1]) if over.size else 0.0
        heights.append(float(np.abs(window).max()))
        durations.append(last if last < 0.5 * half else math.nan)
        offsets.append(float(window[(since > 0.4 * half) & (since < 0.6 * half)].mean()))
        start += half
    return Reversed(max(heights), max(durations), 0.5 * abs(offsets[1] - offsets[0]), "")


def reversals_with(lab: Lab, controller: str, scenario: str, machine: str, lag: float) -> Reversed:
    """The reversals of a controller on a sine with play in the loop."""
    return reversed_by(backlash_run(lab, controller, scenario, machine, lag), sine_of(scenario).rate_rad_s)


def circle(run: Any, radius_mm: float, seconds: float = 1.0) -> CircularTest:
    """Both axes alike: the circle of a run on a sine of this period, from its second half on; and the way back."""
    turn = round(seconds / PERIOD_S)
    quarter = turn // 4
    place = run["actual.position"]
    first = len(place) - turn - quarter
    y, x = place[first : first + turn], place[first + quarter : first + quarter + turn]
    return CircularTest(
        radius_mm, Turn("ccw", x, y), Turn("cw", x, -y), feed_mm_min=60.0 * 2.0 * math.pi * radius_mm / seconds
    )


def least_lag_s() -> float:
    """The lag below which the table swings up, ``M / c``, with the joint's damping and the guide's in ``c``.

    With the motor at ``m = -correction`` (its own loop fast) and ``lag correction' = x``, the table obeys ``M x'' +
    c x' + k (x - m) = 0``, so ``M s^3 + c s^2 + k s + k / lag = 0``, which is stable for ``c k > M k / lag`` (Routh).
    """
    p = BallscrewBacklashParams()
    k, mass, motor = p.joint.forward_stiffness, p.table_mass, p.inertia / p.lead_per_rad**2
    c = 2.0 * damping_ratio(p.restitution) * math.sqrt(k * mass * motor / (mass + motor)) + p.guide.viscous
    return mass / c


# ---- impacts behind an imposed screw
SETTLED_UM = 0.05
FREE = {
    "guide.coulomb": 1e-9, "guide.static": 1e-9, "guide.stiffness": 1e-3, "guide.damping": 0.0, "guide.viscous": 0.0,
}  # fmt: skip
"""No guide friction to speak of."""
HARD, SOFT = 0.9, restitution_of(-math.log(0.05) / math.hypot(math.pi, math.log(0.05)))
"""Restitution of an almost elastic impact, and of a flank damped by the usual formula for 0.05: that formula is for a
flank that also pulls, on one that only pushes it makes 0.21."""


class Impact(NamedTuple):
    """What happens after the reversal of the screw."""

    since_s: np.ndarray
    twist_um: np.ndarray
    """Screw minus table."""
    beyond_um: np.ndarray
    """Table minus where the classical play would have it."""
    crossing_s: float
    """From the reversal until the other flank is met first."""
    settled_s: float
    """From the reversal until the difference to the classical play stays within :data:`SETTLED_UM` of its end."""


def radius_and_rate(scenario: str) -> tuple[float, float]:
    """Amplitude in m and angular frequency in rad/s of a sine."""
    sine = sine_of(scenario)
    return 1e-3 * sine.amplitude_mm, sine.rate_rad_s


def imposed(scenario: str, restitution: float, seconds: float, **changes: float) -> Run:
    """The screw from its largest speed on, the table on the forward flank."""
    return (
        imposed_loop(*radius_and_rate(scenario), restitution, 1e-4, **changes).run(seconds, record=("plant",)).check()
    )


@measure
def impact(lab: Lab, scenario: str, restitution: float) -> Impact:
    """The reversal of one of the sines under this restitution."""
    radius, rate = radius_and_rate(scenario)
    run = imposed(scenario, restitution, 0.5 * math.pi / rate + 0.31)
    since = run.time - 0.5 * math.pi / rate
    twist = 1e6 * (run["plant.motor"] - run["plant.table"])
    place, classic = -0.5e-6 * GAP_UM, []
    for x in (radius * np.sin(rate * run.time)).tolist():
        place = followed(Play(), place, x)
        classic.append(place)
    beyond = 1e6 * (run["plant.table"] - np.array(classic))
    first = float(since[np.flatnonzero((twist <= -0.5 * GAP_UM) & (since > 0.0))[0]])
    after = (since > first) & (since < 0.3)
    end = float(beyond[(since > 0.25) & (since < 0.3)].mean())
    off = since[after][np.abs(beyond[after] - end) > SETTLED_UM]
    return Impact(since, twist, beyond, first, float(off[-1]) if off.size else first)


def crossing_of_parabola(scenario: str, gap_um: float = GAP_UM) -> float:
    """``sqrt(2 b / (R w^2))``, s."""
    radius, rate = radius_and_rate(scenario)
    return math.sqrt(2e-6 * gap_um / (radius * rate * rate))


@measure
def free_change_of_flank_deg(lab: Lab, scenario: str) -> float:
    """Phase of the screw after its largest speed at which a table without friction meets the other flank."""
    _, rate = radius_and_rate(scenario)
    run = imposed(scenario, 0.05, 0.5 / rate, **FREE)
    met = run.time[np.argmax(run["plant.motor"] - run["plant.table"] <= -0.5e-6 * GAP_UM)]
    return math.degrees(rate * float(met))
