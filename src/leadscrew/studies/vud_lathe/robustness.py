"""What the axis may be off by: gain, sensor lag, dead zone, drift, and everything of a real sensor at once.

The rows of the digest's table of robustness (section 7). Each function gives the metrics of a batch, one value a run.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.controllers.vud.family import BETA_E, ERROR, vud_family
from leadscrew.controllers.vud.scaled import vud_scaled
from leadscrew.kernel.block import Block
from leadscrew.studies.vud_lathe.runs import Loops
from leadscrew.studies.vud_lathe.variants import VARIANTS

LAWS: dict[str, Block] = {
    "raw_rate": VARIANTS["corrected.vud_raw_rate"],
    "beta_e_half": vud_family(output_from=ERROR, output_tau=0.5),
    "beta_e": vud_family(**BETA_E),
    "opt": vud_scaled,
}
"""L1, A, A+ and OPT-R of the digest; the first three as one program."""
FILTERED = vud_family(**BETA_E, filter_s=0.005)
"""A+ with ec behind a low-pass of 5 ms."""

SPEEDS_MM_S = np.array([209.0, 259.0, 334.0, 380.0])
"""Speeds at full duty: what Table 1's moves ask for, and wider."""
THRESHOLDS = np.array([1e-4, 1e-3, 1e-2])
"""Duties below which the motor stands."""
DRIFTS_MM_S = np.array([0.01, 0.1, 1.0])
LAGS_S = np.array([0.003, 0.009, 0.012])
"""Lags of the grating reader; the paper has 6 ms."""
FRICTIONS = np.array([0.005, 0.01, 0.02, 0.05])
"""Duties that friction takes off every command, moving or not."""

SEED, AXES = 7, 64
SPEED_RANGE_MM_S = (259.0, 334.0)

Metrics = Mapping[str, np.ndarray]


def gain_sweep(loops: Loops, law: str, scenario: str) -> Metrics:
    """Over :data:`SPEEDS_MM_S`."""
    return _metrics(loops, LAWS[law], scenario, {"plant.full_duty_speed_mm_s": SPEEDS_MM_S})


def lag_sweep(loops: Loops, law: str, scenario: str) -> Metrics:
    """Over :data:`LAGS_S`."""
    return _metrics(loops, LAWS[law], scenario, {"plant.grating_lag_s": LAGS_S})


def dead_zone_sweep(loops: Loops, law: str, scenario: str) -> Metrics:
    """Over :data:`THRESHOLDS`: nothing happens below, everything above."""
    return _metrics(loops, LAWS[law], scenario, {"actuator.threshold": THRESHOLDS}, "dead_zone")


def drift_sweep(loops: Loops, law: str, scenario: str) -> Metrics:
    """Over :data:`DRIFTS_MM_S`."""
    speed = loops.get(LAWS[law], scenario, "drift").parameters["plant.full_duty_speed_mm_s"]
    return _metrics(loops, LAWS[law], scenario, {"actuator.bias": DRIFTS_MM_S / speed}, "drift")


def friction_sweep(loops: Loops, scenario: str, integral: bool, share: float) -> Metrics:
    """OPT-R over :data:`FRICTIONS`, with the inverse of a dead zone that it knows, and integral action or none."""
    block = vud_scaled(integral_gain=2.0 if integral else 0.0, dead_zone_share=share)
    changes = {
        "actuator.threshold": FRICTIONS,
        "controller.dead_zone": FRICTIONS,
        "actuator.subtract": np.ones(len(FRICTIONS)),
    }
    return _metrics(loops, block, scenario, changes, "dead_zone")


def worn_axes(play_mm: float) -> dict[str, np.ndarray]:
    """:data:`AXES` axes: gain, play and what interpolation leaves drawn, noise of 50 nm."""
    rng = np.random.default_rng(SEED)
    return {
        "plant.full_duty_speed_mm_s": np.linspace(*SPEED_RANGE_MM_S, AXES),
        "plant.backlash_mm": rng.uniform(0.0, play_mm, AXES),
        "sensor.interpolation_1_mm": rng.uniform(0.0, 0.13e-3, AXES),
        "sensor.interpolation_2_mm": rng.uniform(0.0, 0.07e-3, AXES),
        "sensor.interpolation_phase": rng.uniform(0.0, 2.0 * np.pi, AXES),
        "sensor.noise_mm": np.full(AXES, 50e-6),
    }


def on_worn_axes(loops: Loops, block: Block | str, scenario: str, play_mm: float) -> Metrics:
    """Over :func:`worn_axes`, on the grating."""
    return loops.batch(block, scenario, worn_axes(play_mm), machine="screw", sensor="grating").metrics


def _metrics(
    loops: Loops, block: Block, scenario: str, changes: Mapping[str, np.ndarray], machine: str = "linear"
) -> Metrics:
    return loops.batch(block, scenario, changes, machine=machine, sensor="grating").metrics
