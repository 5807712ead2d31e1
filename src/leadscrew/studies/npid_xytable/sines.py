"""Batches on a slow sine, reduced to three numbers a run: size of the error, its peak, how calm the drive is."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.runs import Loops

SINE_S = 12.0
LATE = round(2.0 / PERIOD_S)
"""Periods that do not count: start-up. Ten seconds, seven periods of the motion, are left."""

QUIET = {"plant.spindle_v": 0.0, "plant.tooth_v": 0.0} | {
    f"disturbance.{line}.amplitude": 0.0 for line in ("first", "second", "third", "fourth", "fifth")
}
"""What takes the cutting out of a scenario and leaves its encoder and noise."""


def rms(e: np.ndarray) -> np.ndarray:
    """Root mean square along the last axis."""
    return np.asarray(np.sqrt(np.mean(np.square(e), axis=-1)))


def sines(loops: Loops, block: Any, scenario: str, changes: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    """RMS and largest error, um, and RMS change of the output from period to period, mV, for each run of a batch."""
    from leadscrew.kernel.loop import DivergenceWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        run = loops.get(block, scenario).batch(SINE_S, changes, record=("true_error", "output"))
    e, u = 1e3 * run["true_error"][:, LATE:], 1e3 * run["output"][:, LATE:]
    return rms(e), np.abs(e).max(axis=1), rms(np.diff(u, axis=1))


def read(loops: Loops, block: Any, changes: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    """:func:`sines` at 1 mm without cutting, read by an encoder of 0.5 um with 0.1 um of noise."""
    count = len(next(iter(changes.values())))
    return sines(loops, block, "measured_1000", changes | {k: np.full(count, v) for k, v in QUIET.items()})
