"""Spindle speeds from 500 to 24,000 1/min, the paper's future work: errors at the lines of spindle and teeth.

The table moves 1 mm at 0.7 Hz under a cutter of four teeth, 1 mV of runout and 2 mV at the teeth, no other disturbance.
Runs of 20 s; the last 10 s count, in which the motion makes seven periods and the spindle, at multiples of 6 1/min, a
whole number of turns: nothing leaks. From 15,000 1/min on the teeth pass faster than 1 kHz, half the control rate: what
is sampled stands at the folded frequency, and there it is measured.

Beside it, in closed form, for a line of ``d`` volt at ``w`` that is not held and a linear controller:

    error at the samples     abs(S P(j w)) d                   P: equation (1);  S = 1 / (1 + C P_d) at z = e^(j w T)
    motion between them      P(j w) (d + e^(-j w tau) H(j w) U)  at w, and  P(j v) e^(-j v tau) H(j v) U  at v,
                             U = -C S P(j w) d,  H(j v) = (1 - e^(-j v T)) / (j v T),  v = w folded, with its sign
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.harmonics import folded
from leadscrew.controllers._npid import npid
from leadscrew.controllers._resonant import resonant
from leadscrew.controllers._response import law_response, plant_response
from leadscrew.controllers._wrapping import takes_motion
from leadscrew.disturbances._wandering_spindle import wandering_spindle
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S, PERIOD_S
from leadscrew.studies.npid_xytable.cutting import line_volts
from leadscrew.studies.npid_xytable.scenarios import CUT_S
from leadscrew.studies.npid_xytable.table2 import SPEEDS
from leadscrew.studies.npid_xytable.tunings import TUNINGS, XY_TABLE

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

TEETH, RUNOUT_MV, TOOTH_MV = 4, 1.0, 2.0
RUN_S, COUNTED_S = 20.0, 10.0
COUNTS = round(COUNTED_S / PERIOD_S)
NYQUIST_HZ = 0.5 / PERIOD_S
FIRST_RPM, LAST_RPM = 498, 24_000
FOLDS_RPM = round(60.0 * NYQUIST_HZ / TEETH)
"""Speed from which the teeth pass faster than half the control rate."""


def _speeds() -> np.ndarray:
    whole = 6.0 * np.round(np.geomspace(FIRST_RPM, LAST_RPM, 30) / 6.0)
    more = [2850.0, 14_400.0, 15_600.0, 16_800.0, 18_000.0, 19_800.0, 22_200.0]
    return np.unique(np.concatenate([whole, more]))


RPM = _speeds()
"""Multiples of 6; at 2,850 the teeth pass at 190 Hz, where NPID chatters."""

APART = RPM != LAST_RPM
"""At 24,000 1/min the teeth fold from 1,600 Hz to 400 Hz, onto the spindle: no sampled signal tells them apart."""

SWEPT: dict[str, Block] = {
    "paper.pid": TUNINGS["paper.pid"],
    "corrected.npid_um": npid,
    "ours.pid_ms_159": TUNINGS["ours.pid_ms_159"],
    "ours.pid_ms_185": TUNINGS["ours.pid_ms_185"],
    "resonant": resonant(TUNINGS["ours.pid_ms_159"], (0.7,), model=XY_TABLE),
}
"""The last one is ours.pid_ms_159 with resonators: at the motion, the spindle, and the teeth while below Nyquist."""


@dataclass(frozen=True)
class Sweep:
    """Amplitudes of the true error at the samples, um, one a speed of :data:`RPM`."""

    spindle: np.ndarray
    tooth: np.ndarray
    rms: np.ndarray
    """Of the whole error, um."""


def tooth_hz(rpm: float) -> float:
    """Teeth a second."""
    return TEETH * rpm / 60.0


def seen_hz(frequency: float) -> float:
    """Where a line stands in the samples."""
    return folded(frequency, 1.0 / PERIOD_S)


def amplitude(error: np.ndarray, frequency: float) -> float:
    """Amplitude at a frequency that is whole in the record, in the error's unit."""
    turn = np.exp(-2j * np.pi * frequency * PERIOD_S * np.arange(len(error)))
    return float(2.0 * abs(np.mean(error * turn)))


def _loop(lab: Lab, name: str) -> Loop:
    plant = xy_table_cutting(teeth=TEETH, spindle_v=1e-3 * RUNOUT_MV, tooth_v=1e-3 * TOOTH_MV)
    return lab.loop(SWEPT[name], "sine_1mm", plant=plant)


@measure
def sweep(lab: Lab, name: str) -> Sweep:
    """All speeds side by side."""
    loop = _loop(lab, name)
    varied: dict[str, np.ndarray] = {"plant.spindle_hz": RPM / 60.0}
    if name == "resonant":
        varied |= {
            "controller.spindle_hz": RPM / 60.0,
            "controller.teeth": np.where(tooth_hz(1.0) * RPM < NYQUIST_HZ, TEETH, 1),
        }
    error = 1e3 * loop.batch(RUN_S, varied, record=("true_error",))["true_error"][:, -COUNTS:]
    error = error - error.mean(axis=1, keepdims=True)
    return Sweep(
        np.array([amplitude(e, rpm / 60.0) for e, rpm in zip(error, RPM, strict=True)]),
        np.array([amplitude(e, seen_hz(tooth_hz(rpm))) for e, rpm in zip(error, RPM, strict=True)]),
        np.sqrt(np.mean(error**2, axis=1)),
    )


class Line(NamedTuple):
    """What a line of 1 mV does, in closed form; um."""

    sampled: float
    """Error at the samples."""
    own: float
    """Motion at the line's frequency, between the samples too."""
    ghost: float
    """Motion at the folded frequency, which the controller makes; of a line below Nyquist there is none."""

    @property
    def rms(self) -> float:
        """Of the motion."""
        return float(np.hypot(self.own, self.ghost) / np.sqrt(2.0))


def table(w: float) -> complex:
    """Equation (1), mm/V."""
    p = xy_table_cutting.params
    return complex(p.gain / ((1j * w) ** 2 + p.damping * 1j * w + p.stiffness))


def line(controller: Block | None, frequency: float, cancelled: bool = False) -> Line:
    """A line under a linear controller; ``cancelled``: under a resonator that takes it out of the samples."""
    w = 2.0 * np.pi * frequency
    free, driven = table(w), complex(np.ravel(plant_response(XY_TABLE, PERIOD_S, w))[0])
    if controller is None:
        return Line(1e3 * abs(free) * 1e-3, 1e3 * abs(free) * 1e-3, 0.0)
    law = complex(
        law_response(
            controller.step, prepared(controller, PERIOD_S), controller.state, takes_motion(controller), PERIOD_S, w
        )[0]
    )
    drive = -free / driven if cancelled else -law * free / (1.0 + law * driven)

    def held(v: float) -> complex:
        turn = 1j * v * PERIOD_S
        return complex(table(v) * np.exp(-1j * v * DEAD_TIME_S) * ((1.0 - np.exp(-turn)) / turn if v else 1.0))

    rate = 1.0 / PERIOD_S
    v = 2.0 * np.pi * (frequency - rate * round(frequency / rate))
    ghost = abs(held(v) * drive) if frequency > NYQUIST_HZ else 0.0
    return Line(abs(free + driven * drive), abs(free + held(w) * drive), ghost)


GHOST_RPM = 22_200.0
"""Teeth at 1,480 Hz, which fold to 520 Hz."""


def closed_form(name: str) -> Sweep:
    """The same for a linear controller without resonators."""
    spindle = np.array([RUNOUT_MV * line(SWEPT[name], rpm / 60.0).sampled for rpm in RPM])
    tooth = np.array([TOOTH_MV * line(SWEPT[name], tooth_hz(rpm)).sampled for rpm in RPM])
    return Sweep(spindle, tooth, np.full(len(RPM), np.nan))


@measure
def ghost_um(lab: Lab) -> float:
    """Error at the samples at 520 Hz, teeth at 1,480 Hz, under a resonator at 520 Hz; um, by simulation."""
    seen = seen_hz(tooth_hz(GHOST_RPM))
    varied = {"plant.spindle_hz": [GHOST_RPM / 60.0], "controller.spindle_hz": [seen], "controller.teeth": [1]}
    error = _loop(lab, "resonant").batch(RUN_S, varied, record=("true_error",))["true_error"][0, -COUNTS:]
    return 1e3 * amplitude(error, seen)


# ---- a speed that is not known
OFF = 0.02
"""How far the speed is off, either way."""
DRIFT = 1e-3
"""Change of the speed a second, as a share of it."""
WANDER_S = 10.0
NEAR = 5e-4
"""The speed counts as found when it stays within this share of itself."""
ESTIMATE = "controller.spindle.spindle_hz"
ADAPTIVE, KNOWN_SPEED = "ours.resonant_adaptive", "ours.resonant_full"


@dataclass(frozen=True)
class Cuts:
    """Runs of 1 mm at 0.7 Hz under Table II's lines and the spindle's; the first axis is the run."""

    rpm: np.ndarray
    """Commanded, 1/min."""
    share: np.ndarray
    """Turned over commanded, less 1."""
    rms: np.ndarray
    """um, of the last half."""
    time: np.ndarray
    estimate: np.ndarray
    """Estimated speed over the commanded one, over time; empty for a controller that estimates none."""

    def found_after(self) -> np.ndarray:
        """Time from which on the estimate stays within :data:`NEAR` of the speed, s."""
        off = np.abs(self.estimate / (1.0 + self.share[:, None]) - 1.0) > NEAR
        last = off.shape[1] - 1 - np.argmax(off[:, ::-1], axis=1)
        return np.where(off.any(axis=1), self.time[np.minimum(last + 1, len(self.time) - 1)], 0.0)


@measure
def wrong_speed(lab: Lab, controller: str) -> Cuts:
    """The three speeds, each right and off by 2 % to either side."""
    rpm, share = (np.array(x) for x in zip(*product(SPEEDS, (-OFF, 0.0, OFF)), strict=True))
    phases = np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, (7, 13 * len(rpm)))[:, : len(rpm)]
    varied: dict[str, Any] = {
        "controller.inner.spindle_hz": rpm / 60.0,
        "plant.spindle_hz": rpm / 60.0 * (1.0 + share),
        "plant.spindle_phase": phases[5],
        "plant.tooth_phase": phases[6],
        **line_volts(rpm, phases[:5].T),
    }
    shown = (ESTIMATE,) if controller == ADAPTIVE else ()
    done = lab.batch(controller, "measured_1000", varied, CUT_S, record=("true_error", *shown))
    estimate = done[ESTIMATE][:, ::20] / (rpm / 60.0)[:, None] if shown else np.zeros((len(rpm), 0))
    return Cuts(rpm, share, 1e3 * done.metrics["rms_error"], done.time[::20], estimate)


@measure
def moving_speed(lab: Lab, drift: float, wander: float) -> Cuts:
    """Three speeds that start 2 % below the commanded one and grow, or that wander about it with a period of 10 s."""
    load = wandering_spindle(drift=drift, wander=wander, wander_s=WANDER_S)
    loop = lab.loop(ADAPTIVE, "measured_1000", disturbance=load, changes={"plant.spindle_v": 0.0, "plant.tooth_v": 0.0})
    rpm, start = np.array(SPEEDS), -OFF if drift else 0.0
    varied: dict[str, Any] = line_volts(rpm, np.zeros((3, 5)), "disturbance.lines")
    varied |= {"controller.inner.spindle_hz": rpm / 60.0, "disturbance.spindle_hz": rpm / 60.0 * (1.0 + start)}
    done = loop.batch(CUT_S, varied, record=("true_error", ESTIMATE))
    estimate = done[ESTIMATE][:, ::20] / (rpm / 60.0)[:, None]
    return Cuts(rpm, np.full(3, start), 1e3 * done.metrics["rms_error"], done.time[::20], estimate)
