"""The stage with backlash inside the loop: closed on the motor's encoder, on the table's scale, or on both.

Machines: the stage with the classic play (``ballscrew_play``) and with two masses (``ballscrew_backlash``), each with
2 um of play. All at 4 kHz with 10 nm a count; runs enter in motion, on the command, the table behind its flank.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.analysis.circular.paths import CircularTest, Turn
from leadscrew.kernel.loop import Loop
from leadscrew.plants.backlash_two_mass import damping_ratio
from leadscrew.plants.ballscrew_backlash import BallscrewBacklashParams, backlash_in_motion, ballscrew_backlash
from leadscrew.plants.ballscrew_play import ballscrew_play, play_in_motion
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.sensors.dual_encoder import dual_encoder
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.machines import TIGHT
from leadscrew.studies.fsmc_ballscrew.runs import ENCODER_NM, PERIOD_S
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, command, start_speed

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run
    from leadscrew.studies.fsmc_ballscrew.runs import Loops

GAP_UM = 2.0
"""Play of both machines."""
MOTOR, TABLE = 1e6, 0.0
"""Lag of the table's reading, s: never, and at once."""
_KEPT: WeakKeyDictionary[Loops, dict[Any, Run]] = WeakKeyDictionary()
PLANTS = {
    "play": (ballscrew_play, play_in_motion),
    "two_mass": (ballscrew_backlash, backlash_in_motion),
}
BOUND_MM = 50.0
"""A table that is farther away has left the loop."""
SEEN = 0.8
"""Part of the way to the next reversal that is looked at."""
BACK_UM = 0.1
"""A peak is over when the error stays within this, a twentieth of the play."""


def backlash_loop(loops: Loops, controller: str, scenario: str, machine: str, lag: float) -> Loop:
    """A controller on a sine, on ``play`` or ``two_mass``; ``lag`` as in :mod:`leadscrew.sensors.dual_encoder`."""
    asked = SCENARIOS[scenario].params
    plant, in_motion = PLANTS[machine]
    return Loop(
        reference=command(asked),
        controller=CONTROLLERS[controller],
        plant=in_motion(plant(travel_per_rad=TRAVEL_MM_PER_RAD), start_speed(asked)),
        sensor=dual_encoder(lag=lag, resolution=1e-6 * ENCODER_NM),
        period=PERIOD_S,
        metrics={},
        bound=BOUND_MM,
        **TIGHT,
    )


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


def backlash_run(loops: Loops, controller: str, scenario: str, machine: str, lag: float, seconds: float) -> Run:
    """A run with command, table and motor in mm, and the torque; made once for the same ``loops`` and arguments."""
    kept = _KEPT.setdefault(loops, {})
    key = (controller, scenario, machine, lag, seconds)
    if key not in kept:
        kept[key] = played(backlash_loop(loops, controller, scenario, machine, lag), seconds)
    return kept[key]


def played(loop: Loop, seconds: float) -> Run:
    """The same of a loop that exists; that it may diverge is expected."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return loop.run(seconds, record=("command.position", "actual", "output"))


def error_um(run: Run) -> np.ndarray:
    """Error of the table."""
    return np.asarray(1e3 * (run["actual.position"] - run["command.position"]))


def swing_um(run: Run) -> float:
    """Swing of the table's error, peak to peak, within 50 ms of full speed at 2 s."""
    e = error_um(run)
    return float(np.ptp(e[(run.time > 1.95) & (run.time < 2.05)]))


def reversed_by(run: Run, rate: float) -> Reversed:
    """The reversals of a run on a sine of this angular frequency."""
    if run.diverged:
        return Reversed(math.nan, math.nan, math.nan, str(run.diverged))
    e, half = error_um(run), math.pi / rate
    heights, durations, offsets = [], [], []
    start = 0.5 * half
    while start + half <= run.time[-1] + 1e-9:
        inside = (run.time >= start) & (run.time < start + half)
        window, since = e[inside], run.time[inside] - start
        height = float(np.abs(window).max())
        far = np.abs(window) > BACK_UM
        heights.append(height)
        over = since[far & (since < SEEN * half)]
        last = float(over[-1]) if over.size else 0.0
        durations.append(last if last < 0.5 * half else math.nan)
        offsets.append(float(window[(since > 0.4 * half) & (since < 0.6 * half)].mean()))
        start += half
    return Reversed(max(heights), max(durations), 0.5 * abs(offsets[1] - offsets[0]), "")


def circle(run: Run, radius_mm: float, seconds: float = 1.0) -> CircularTest:
    """Both axes alike: the circle of a run on a sine of this period, from its second half on; and the way back."""
    turn = round(seconds / PERIOD_S)
    quarter = turn // 4
    place = run["actual.position"]
    first = len(place) - turn - quarter
    y, x = place[first : first + turn], place[first + quarter : first + quarter + turn]
    return CircularTest(
        radius_mm, Turn("ccw", x, y), Turn("cw", x, -y), feed_mm_min=60.0 * 2.0 * math.pi * radius_mm / seconds
    )


def least_lag_s(params: BallscrewBacklashParams | None = None) -> float:
    """The lag below which the table swings up, ``M / c``, with the joint's damping and the guide's in ``c``.

    With the motor at ``m = -correction`` (its own loop fast) and ``lag correction' = x``, the table obeys ``M x'' +
    c x' + k (x - m) = 0``, so ``M s^3 + c s^2 + k s + k / lag = 0``, which is stable for ``c k > M k / lag`` (Routh).
    """
    p = BallscrewBacklashParams() if params is None else params
    k, mass, motor = p.joint.forward_stiffness, p.table_mass, p.inertia / p.lead_per_rad**2
    c = 2.0 * damping_ratio(p.restitution) * math.sqrt(k * mass * motor / (mass + motor)) + p.guide.viscous
    return mass / c


__all__: list[Any] = [
    "GAP_UM", "MOTOR", "TABLE", "Reversed", "backlash_loop", "backlash_run", "circle", "error_um", "least_lag_s",
    "played", "reversed_by", "swing_um",
]  # fmt: skip
