"""Many runs under cutting at once: spindle speeds, random phases of the disturbance, plants off the nominal one.

The phases of the paper's forces are unknown, so nothing may hang on one choice of them: a trial has the three columns
of Table II, each under many draws of phases, independent and uniform over a turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, LINES_HZ, ORDERS, volts
from leadscrew.studies.npid_xytable.columns import PID_UM
from leadscrew.studies.npid_xytable.runs import Loops, amplitudes_um
from leadscrew.studies.npid_xytable.scenarios import CUT_S, SPEEDS, Cutting, line_changes
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

DRAWS = 30
"""Of phases, for each spindle speed."""


TOLD = ("ours.resonant_full", "ours.resonant_full_185", "ours.resonant_adaptive")
"""Controllers that are told the spindle's speed, as a CNC can."""


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

    def __len__(self) -> int:
        return len(self.speeds)

    def at(self, rpm: int) -> np.ndarray:
        """The rows of one spindle speed."""
        return self.rows[self.speeds == rpm]

    def reductions(self) -> np.ndarray:
        """Reduction of each line against the printed PID column, percent, ``(runs, 5)``."""
        return 100.0 * (1.0 - self.rows / np.array([PID_UM[int(rpm)] for rpm in self.speeds]))

    def by_row(self) -> np.ndarray:
        """Mean amplitude over the draws for the fifteen rows of Table II, um."""
        return np.concatenate([self.at(rpm).mean(axis=0) for rpm in SPEEDS])


def spindle_key(loop: Loop) -> str:
    """Where a controller is told the spindle's speed: the outermost place."""
    places = [key for key in loop.sheet if key.startswith("controller.") and key.endswith("spindle_hz")]
    return min(places, key=len)


def phases_of(draws: int, seed: int = 1) -> np.ndarray:
    """Uniform phases, ``(draws, 5)``: the same for every controller and speed."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (draws, len(ORDERS)))


def trial(
    loops: Loops,
    controller: str | Block,
    amplitude_mm: float = 1.0,
    draws: int = DRAWS,
    seed: int = 1,
    encoder_um: float = 0.5,
    noise_um: float = 0.1,
    spindle: bool = True,
    box: Mapping[str, np.ndarray] | None = None,
    phases: np.ndarray | None = None,
    **options: Any,
) -> Trial:
    """The three speeds with ``draws`` of phases each, and every plant of ``box`` (parameters by dotted key).

    ``phases``: ``(runs a speed, 5)`` or ``(3, runs a speed, 5)`` in place of random ones. The controllers of
    :data:`TOLD` are told the spindle's speed.
    """
    move = Cutting(amplitude_mm, 1000.0, 1000, encoder_um=encoder_um, noise_um=noise_um)
    plain = Scenario("trial", move if spindle else move._replace(runout_mv=0.0, tooth_mv=0.0), "", CUT_S)
    loop = loops.get(controller, plain, **options)
    drawn = phases_of(draws, seed) if phases is None else phases
    by_speed = np.broadcast_to(drawn, (len(SPEEDS), *drawn.shape[-2:]))
    plants = len(next(iter(box.values()))) if box else 1
    order = list(product(range(len(SPEEDS)), range(by_speed.shape[1]), range(plants)))
    speed, draw, plant = (np.array(x) for x in zip(*order, strict=True))
    rpm = np.array(SPEEDS)[speed]
    sizes = np.array([volts(PID_UM[r]) for r in SPEEDS])[speed].T
    varied: dict[str, Any] = line_changes(LINES_HZ, list(sizes), list(by_speed[speed, draw].T))
    varied = {f"disturbance.{k}": v for k, v in varied.items() if not k.endswith("frequency")}
    varied["plant.spindle_hz"] = rpm / 60.0
    if controller in TOLD:
        varied[spindle_key(loop)] = rpm / 60.0
    varied |= {key: values[plant] for key, values in (box or {}).items()}
    done = loop.batch(CUT_S, varied, record=("true_error",))
    found = amplitudes_um(done, (BASE_HZ, *LINES_HZ))
    metrics = {name: 1e3 * values for name, values in done.metrics.items()}
    return Trial(rpm, found[:, 1:], found[:, 0], metrics["rms_error"], metrics["max_error"], metrics["chatter"])


BOX: dict[str, np.ndarray] = {
    f"plant.{key}": np.array([combination[i] for combination in product(
        (0.8 * 69380.0, 69380.0, 1.2 * 69380.0), (0.8 * 144.8, 1.2 * 144.8), (0.70e-3, 0.85e-3),
    )])
    for i, key in enumerate(("gain", "damping", "dead_time_s"))
}  # fmt: skip
"""The robustness box: gain of (1) by 0.8, 1 and 1.2, damping by 0.8 and 1.2, dead time 0.70 and 0.85 ms; 12 plants."""
