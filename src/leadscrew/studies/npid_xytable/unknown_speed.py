"""M7: the spindle turns at another speed than the controller was told, up to 2 % off, or changes its speed.

Runs of ``ours.resonant_adaptive`` in L*, 1 mm at 0.7 Hz under the columns of Table II, spindle lines of 1 and 2 mV, an
encoder of 0.5 um with 0.1 um of noise; beside it ``ours.resonant_full``, whose resonators stay where they were put.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from leadscrew.disturbances.wandering_spindle import wandering_spindle
from leadscrew.plants.xy_table_cutting import xy_table_cutting
from leadscrew.studies.npid_xytable.calibration import LINES_HZ, volts
from leadscrew.studies.npid_xytable.columns import PID_UM
from leadscrew.studies.npid_xytable.runs import Loops, amplitudes_um
from leadscrew.studies.npid_xytable.scenarios import CUT_S, SPEEDS, line_changes
from leadscrew.studies.npid_xytable.trials import BOX

OFF = 0.02
"""How far the speed is off, either way."""
DRIFT = 1e-3
"""Change of the speed a second, as a share of it."""
WANDER_S = 10.0
NEAR = 5e-4
"""The speed counts as found when it stays within this share of itself."""
ESTIMATE = "controller.spindle.spindle_hz"
FINE, COARSE = "ours.resonant_adaptive", "ours.resonant_full"


@dataclass(frozen=True)
class Cuts:
    """Results; the first axis is the run."""

    rpm: np.ndarray
    """Told, 1/min."""
    share: np.ndarray
    """Turned, less 1, over told."""
    rms: np.ndarray
    """um, of the last half."""
    rows: np.ndarray
    """Amplitudes at the five lines of Table II, um; NaN where they were not fitted."""
    time: np.ndarray
    estimate: np.ndarray
    """Estimated speed over the told one, over time; empty for a controller that estimates none."""

    def found_after(self) -> np.ndarray:
        """Time from which on the estimate stays within :data:`NEAR` of the speed, s."""
        off = np.abs(self.estimate / (1.0 + self.share[:, None]) - 1.0) > NEAR
        last = off.shape[1] - 1 - np.argmax(off[:, ::-1], axis=1)
        return np.where(off.any(axis=1), self.time[np.minimum(last + 1, len(self.time) - 1)], 0.0)


def cuts(loops: Loops, controller: str, box: bool, seed: int = 7) -> Cuts:
    """The three speeds, each right and off by 2 % to either side, on the nominal axis; with ``box`` on the box too.

    Without ``box`` no rows are fitted.
    """
    nominal = {key: getattr(xy_table_cutting.params, key.split(".")[1]) for key in BOX}
    plants = {key: np.array([nominal[key], *(values if box else ())]) for key, values in BOX.items()}
    order = list(product(range(len(plants["plant.gain"])), SPEEDS, (-OFF, 0.0, OFF)))
    plant, rpm, share = (np.array(x) for x in zip(*order, strict=True))
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (7, len(order)))
    varied: dict[str, Any] = {
        "controller.inner.spindle_hz": rpm / 60.0,
        "plant.spindle_hz": rpm / 60.0 * (1.0 + share),
        "plant.spindle_phase": phases[5],
        "plant.tooth_phase": phases[6],
    }
    sizes = np.array([volts(PID_UM[r]) for r in rpm]).T
    lines = line_changes(LINES_HZ, list(sizes), list(phases[:5]))
    varied |= {f"disturbance.{k}": v for k, v in lines.items() if not k.endswith("frequency")}
    varied |= {key: values[plant] for key, values in plants.items()}
    loop = loops.get(controller, "measured_1000")
    shown = (ESTIMATE,) if controller == FINE else ()
    done = loop.batch(CUT_S, varied, record=("true_error", *shown))
    told = (rpm / 60.0)[:, None]
    estimate = done[ESTIMATE][:, ::20] / told if shown else np.zeros((len(order), 0))
    rows = amplitudes_um(done) if box else np.full((len(order), 5), np.nan)
    return Cuts(rpm, share, 1e3 * done.metrics["rms_error"], rows, done.time[::20], estimate)


@lru_cache(maxsize=4)
def drifting(loops: Loops, drift: float = DRIFT, wander: float = 0.0) -> Cuts:
    """Three speeds that start 2 % below what was told and grow, or that wander about it with a period of 10 s."""
    load = wandering_spindle(drift=drift, wander=wander, wander_s=WANDER_S)
    loop = loops.get(FINE, "measured_1000", disturbance=load, changes={"plant.spindle_v": 0.0, "plant.tooth_v": 0.0})
    rpm = np.array(SPEEDS)
    start = -OFF if drift else 0.0
    sizes = np.array([volts(PID_UM[r]) for r in SPEEDS]).T
    lines = line_changes(LINES_HZ, list(sizes), list(np.zeros((5, 3))))
    varied: dict[str, Any] = {f"disturbance.lines.{k}": v for k, v in lines.items() if not k.endswith("frequency")}
    varied |= {"controller.inner.spindle_hz": rpm / 60.0, "disturbance.spindle_hz": rpm / 60.0 * (1.0 + start)}
    done = loop.batch(CUT_S, varied, record=("true_error", ESTIMATE))
    told = (rpm / 60.0)[:, None]
    return Cuts(
        rpm, np.full(3, start), 1e3 * done.metrics["rms_error"], amplitudes_um(done), done.time[::20],
        done[ESTIMATE][:, ::20] / told,
    )  # fmt: skip


@lru_cache(maxsize=4)
def _made(loops: Loops, controller: str) -> Cuts:
    return cuts(loops, controller, controller == FINE)


def kept(loops: Loops, controller: str = FINE, box: bool = False) -> Cuts:
    """:func:`cuts`, made once: on the nominal axis, or, of :data:`FINE`, on the box."""
    found, nominal = _made(loops, controller), 3 * len(SPEEDS)
    part = slice(nominal, None) if box else slice(0, nominal)
    return Cuts(found.rpm[part], found.share[part], found.rms[part], found.rows[part], found.time, found.estimate[part])
