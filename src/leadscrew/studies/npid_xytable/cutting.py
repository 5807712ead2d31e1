"""Runs under cutting, many at once: spindle speeds, random phases of the disturbance, plants off the nominal one.

The phases of the paper's forces are unknown, so nothing may depend on one choice of them: a trial has the three columns
of Table II, each under many draws of phases, independent and uniform over a turn. Amplitudes are fitted by least
squares together with the motion's own frequency, the lines of the spindle and a trend: nothing leaks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.calibration import PERIOD_S, volts
from leadscrew.studies.npid_xytable.scenarios import CUT_S, line_changes
from leadscrew.studies.npid_xytable.table2 import BASE_HZ, LINES_HZ, ORDERS, PID_UM, SPEEDS
from leadscrew.studies.npid_xytable.tunings import table_pid

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

DRAWS = 30
"""Of phases, for each spindle speed."""
FEW = 6
"""The same where amplitudes hardly depend on the draw."""
SPEED_KNOWN = ("ours.resonant_full", "ours.resonant_full_185", "ours.resonant_adaptive")
"""Controllers that get the spindle's speed, as a CNC can give it."""
BOX: dict[str, np.ndarray] = {
    f"plant.{key}": np.array([combination[i] for combination in product(
        (0.8 * 69380.0, 69380.0, 1.2 * 69380.0), (0.8 * 144.8, 1.2 * 144.8), (0.70e-3, 0.85e-3),
    )])
    for i, key in enumerate(("gain", "damping", "dead_time_s"))
}  # fmt: skip
"""The robustness box: gain of (1) by 0.8, 1 and 1.2, damping by 0.8 and 1.2, dead time 0.70 and 0.85 ms; 12 plants."""
NO_SPINDLE = {"plant.spindle_v": 0.0, "plant.tooth_v": 0.0}
"""What takes the lines of the spindle out of a scenario."""
SINE_S = 12.0
LATE = round(2.0 / PERIOD_S)
"""Periods of a sine that do not count: start-up. Ten seconds, seven periods of the motion, are left."""


def rms(e: np.ndarray) -> np.ndarray:
    """Root mean square along the last axis."""
    return np.asarray(np.sqrt(np.mean(np.square(e), axis=-1)))


def spindle_lines_hz(loop: Loop, spindle_hz: float | None = None) -> tuple[float, ...]:
    """Where the lines of spindle and teeth stand in sampled signals, Hz: folded where above Nyquist."""
    from leadscrew.analysis.harmonics import folded

    plant = loop.blocks["plant"]
    params: Any = None if plant is None else plant.params
    turning = getattr(params, "spindle_hz", 0.0) if spindle_hz is None else spindle_hz
    if turning <= 0.0 or not hasattr(params, "teeth"):
        return ()
    seen = {round(float(folded(f, 1.0 / loop.period)), 9) for f in (turning, params.teeth * turning)}
    return tuple(sorted(f for f in seen if f > 0.0))


def amplitudes_um(run: Any, frequencies: Sequence[float] = LINES_HZ) -> np.ndarray:
    """Amplitudes of the true error at these frequencies in the last half of a run, um; of a batch a row a run."""
    from leadscrew.analysis.harmonics import LineFit

    e = 1e3 * np.atleast_2d(run["true_error"])
    half = e.shape[1] // 2
    turning = getattr(run, "varied", {}).get("plant.spindle_hz")
    speeds = np.full(len(e), np.nan) if turning is None else np.broadcast_to(turning, len(e))
    fitted = np.full((len(e), len(frequencies)), np.nan)
    finite = np.isfinite(e).all(axis=1)
    for speed in np.unique(speeds):
        rows = finite & (np.isnan(speeds) if np.isnan(speed) else speeds == speed)
        asked = dict.fromkeys((BASE_HZ, *frequencies))
        asked |= dict.fromkeys(spindle_lines_hz(run.loop, None if np.isnan(speed) else float(speed)))
        if rows.any():
            fit = LineFit(run.time[half:], tuple(asked)).fit(e[rows, half:], noise="none")
            fitted[rows] = fit.amplitudes[..., [list(asked).index(f) for f in frequencies]]
    return fitted if run["true_error"].ndim > 1 else fitted[0]


@measure
def lines_um(lab: Lab, controller: str, scenario: str, base: bool = False) -> np.ndarray:
    """Amplitudes at the five lines in a run of a scenario, um; ``base``: the motion's own frequency before them."""
    return amplitudes_um(lab.run(controller, scenario), (*((BASE_HZ,) if base else ()), *LINES_HZ))


# ---- trials
@dataclass(frozen=True)
class Trial:
    """Results of one controller; the first axis is the run."""

    speeds: np.ndarray
    """Spindle speed of each run, 1/min."""
    rows: np.ndarray
    """Amplitudes at the five lines, um, ``(runs, 5)``; NaN where a run diverged."""
    motion: np.ndarray
    """Amplitude at the frequency of the motion, um: the following error."""
    rms: np.ndarray
    """um, of the last half."""
    largest: np.ndarray
    """um."""
    chatter: np.ndarray
    """RMS change of the output from sample to sample, mV."""

    def at(self, rpm: int) -> np.ndarray:
        """The rows of one spindle speed."""
        return self.rows[self.speeds == rpm]

    def reductions(self) -> np.ndarray:
        """Reduction of each line against the printed PID column, percent, ``(runs, 5)``."""
        return 100.0 * (1.0 - self.rows / np.array([PID_UM[int(rpm)] for rpm in self.speeds]))

    def by_draw(self) -> np.ndarray:
        """Mean row of each draw, um: over the speeds and the five lines."""
        return np.mean([self.at(rpm).mean(axis=1) for rpm in SPEEDS], axis=0)

    def by_row(self) -> np.ndarray:
        """Mean amplitude over the draws for the fifteen rows of Table II, um."""
        return np.concatenate([self.at(rpm).mean(axis=0) for rpm in SPEEDS])


def spindle_key(loop: Loop) -> str:
    """Where a controller gets the spindle's speed: the outermost place."""
    places = [key for key in loop.sheet if key.startswith("controller.") and key.endswith("spindle_hz")]
    return min(places, key=len)


def phases_of(draws: int, seed: int = 1) -> np.ndarray:
    """Uniform phases, ``(draws, 5)``: the same for every controller and speed."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (draws, len(ORDERS)))


def plants_of(draws: int, seed: int = 3) -> dict[str, np.ndarray]:
    """Plants drawn from within the robustness box, uniformly."""
    draw = np.random.default_rng(seed)
    return {key: draw.uniform(values.min(), values.max(), draws) for key, values in BOX.items()}


def line_volts(rpm: np.ndarray, phases: np.ndarray, place: str = "disturbance") -> dict[str, Any]:
    """Lines of Table II's PID column for a batch, ``rpm`` and ``(runs, 5)`` phases; parameters by dotted key."""
    by_speed = {speed: volts(PID_UM[speed]) for speed in SPEEDS}
    lines = line_changes(LINES_HZ, list(np.array([by_speed[int(r)] for r in rpm]).T), list(phases.T))
    return {f"{place}.{key}": value for key, value in lines.items() if not key.endswith("frequency")}


def tried(
    lab: Lab,
    controller: str | Block,
    amplitude_mm: float = 1.0,
    draws: int = DRAWS,
    *,
    encoder: bool = True,
    spindle: bool = True,
    box: bool = False,
    own_plants: bool = False,
    phases: np.ndarray | None = None,
    **options: Any,
) -> Trial:
    """The three speeds with ``draws`` of phases each, on the nominal plant or on every plant of :data:`BOX`.

    ``own_plants``: each draw on a plant of its own, from within the box. ``encoder``: of 0.5 um with 0.1 um of noise.
    ``phases``: ``(3, runs a speed, 5)`` in place of random ones. The controllers of :data:`SPEED_KNOWN` get the
    spindle's speed.
    """
    read = {} if encoder else {"encoder_um": 0.0, "noise_um": 0.0}
    loop = lab.loop(controller, "measured_1000", **read, **options)
    loop = loop.using({"reference.amplitude": amplitude_mm, **({} if spindle else NO_SPINDLE)})
    drawn = phases_of(draws) if phases is None else phases
    by_speed = np.broadcast_to(drawn, (len(SPEEDS), *drawn.shape[-2:]))
    plants = len(BOX["plant.gain"]) if box else 1
    order = list(product(range(len(SPEEDS)), range(by_speed.shape[1]), range(plants)))
    speed, draw, plant = (np.array(x) for x in zip(*order, strict=True))
    rpm = np.array(SPEEDS)[speed]
    varied = line_volts(rpm, by_speed[speed, draw]) | {"plant.spindle_hz": rpm / 60.0}
    if controller in SPEED_KNOWN:
        varied[spindle_key(loop)] = rpm / 60.0
    if box:
        varied |= {key: values[plant] for key, values in BOX.items()}
    if own_plants:
        varied |= {key: values[draw] for key, values in plants_of(by_speed.shape[1]).items()}
    done = loop.batch(CUT_S, varied, record=("true_error",))
    fitted = amplitudes_um(done, (BASE_HZ, *LINES_HZ))
    metrics = {name: 1e3 * values for name, values in done.metrics.items()}
    return Trial(rpm, fitted[:, 1:], fitted[:, 0], metrics["rms_error"], metrics["max_error"], metrics["chatter"])


@measure
def trial(
    lab: Lab,
    controller: str,
    amplitude_mm: float = 1.0,
    draws: int = DRAWS,
    *,
    encoder: bool = True,
    spindle: bool = True,
    box: bool = False,
    own_plants: bool = False,
) -> Trial:
    """:func:`tried`, once."""
    return tried(lab, controller, amplitude_mm, draws, encoder=encoder, spindle=spindle, box=box, own_plants=own_plants)


# ---- sines and constant loads
def sines(lab: Lab, block: str | Block, scenario: str, varied: dict[str, Any], **options: Any) -> tuple[Any, ...]:
    """RMS and largest error, um, and RMS change of the output from period to period, mV, for each run of a batch."""
    run = lab.loop(block, scenario, **options).batch(SINE_S, varied, record=("true_error", "output"))
    e, u = 1e3 * run["true_error"][:, LATE:], 1e3 * run["output"][:, LATE:]
    return rms(e), np.abs(e).max(axis=1), rms(np.diff(u, axis=1))


LOADS_UM = np.array([2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0])
"""Constant loads by the error that they leave under Table I's PID, um."""
LOAD_S = 6.0


def load_volts(load_um: Any) -> np.ndarray:
    """The load in V for the error that it leaves under Table I's PID without its integral, um."""
    return 1e-3 * table_pid.params.kp * np.asarray(load_um, dtype=float)


def swing_um(lab: Lab, block: str | Block, changes: dict[str, Any]) -> np.ndarray:
    """Peak to peak of the error at the end of runs under constant load, um, without the drift of the slow integral."""
    run = lab.loop(block, "constant_load").batch(LOAD_S, changes, record="true_error")
    e = 1e3 * run["true_error"][:, -1000:]
    n = np.arange(e.shape[1]) - 0.5 * (e.shape[1] - 1)
    return np.asarray(np.ptp(e - np.outer(e @ n / (n @ n), n), axis=1))
