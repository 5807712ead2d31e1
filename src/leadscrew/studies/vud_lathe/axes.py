"""Many axes: drawn ones behind screw and ruler with errors, and what the axis may be off by, one thing at a time.

Every drawn axis is tried with each pair of sensor and controller. Its screw's lead, cyclic error, play and warmth, and
its ruler's residual interpolation error, lie uniformly in :data:`SCREW` and :data:`RULER`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from leadscrew.controllers._vud.family import BETA_E, vud_family
from leadscrew.controllers._vud.scaled import vud_scaled
from leadscrew.kernel.block import Block
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.vud_lathe.controllers import VARIANTS
from leadscrew.studies.vud_lathe.scenarios import MACHINES, STEPS

DRAWS, SEED = 200, 9
"""How many axes, and the seed that they are drawn with."""
SCREW: dict[str, tuple[float, float]] = {
    "plant.lead_error": (-12.0 / 300e3, 12.0 / 300e3),
    "plant.cyclic_error_mm": (0.9e-3, 3.0e-3),
    "plant.backlash_mm": (0.0, 6.0e-3),
    "plant.warming_K": (0.0, 3.0),
}
"""12 um in 300 mm (ISO 3408 grade 3), play up to 6 um, up to 3 K too warm."""
RULER: dict[str, tuple[float, float]] = {
    "sensor.interpolation_1_mm": (0.0, 0.15e-3),
    "sensor.interpolation_2_mm": (0.0, 0.08e-3),
    "sensor.interpolation_phase": (0.0, 2.0 * np.pi),
    "sensor.noise_mm": (50e-6, 50e-6),
}
"""What interpolation leaves after its adjustment, and 50 nm of noise."""
LEADS_UM = (12.0, 23.0, 52.0)
"""In 300 mm: screws of ISO 3408 grades 3, 5 and 7."""

LAWS: dict[str, Block] = {
    "corrected.vud_raw_rate": VARIANTS["corrected.vud_raw_rate"],
    "corrected.vud_beta_e_half": vud_family(output_from="error", output_tau=0.5),
    "corrected.vud_beta_e": vud_family.using(**BETA_E),
    "ours.vud_opt": vud_scaled,
}
"""Laws whose axis is put off; the first three as one program."""
SPEEDS_MM_S = np.array([209.0, 259.0, 334.0, 380.0])
"""Speeds at full duty: what Table 1's moves ask for, and wider."""
THRESHOLDS = np.array([1e-4, 1e-3, 1e-2])
"""Duties below which the motor stands."""
DRIFTS_MM_S = np.array([0.01, 0.1, 1.0])
READER_LAGS_S = np.array([0.003, 0.009, 0.012])
"""Lags of the grating reader; the paper has 6 ms."""
FRICTIONS = np.array([0.005, 0.01, 0.02, 0.05])
"""Duties that friction takes off every command, moving or not."""

HELD_OUT_MM_S = np.concatenate([[259.0, 334.0], np.random.default_rng(2014).uniform(259.0, 334.0, 62)])
"""64 speeds at full duty, both ends among them; no search has seen them."""

Metrics = Mapping[str, np.ndarray]


class Spread(NamedTuple):
    """Error after 2 s over the drawn axes, in um."""

    p95: float
    largest: float


def spread(errors_um: np.ndarray) -> Spread:
    """95th percentile and largest."""
    return Spread(float(np.percentile(errors_um, 95.0)), float(errors_um.max()))


def drawn_axes(lead_um: float = LEADS_UM[0]) -> dict[str, np.ndarray]:
    """The drawn axes, by dotted key; the same ones whatever the lead's grade, but for the lead."""
    rng = np.random.default_rng(SEED)
    drawn = {key: rng.uniform(*ends, DRAWS) for key, ends in (SCREW | RULER).items()}
    drawn["plant.lead_error"] = drawn["plant.lead_error"] * lead_um / LEADS_UM[0]
    return drawn


@measure
def errors_um(
    lab: Lab, controller: str, scenario: str, sensor: str, lead_um: float = LEADS_UM[0], after_s: float = 2.0
) -> np.ndarray:
    """Largest error of the table after 2 s (or ``after_s``) on every drawn axis."""
    drawn = {k: v for k, v in drawn_axes(lead_um).items() if sensor == "grating" or k not in RULER}
    drawn["metrics.error_after_2s.from_time"] = np.full(DRAWS, after_s)
    done = lab.batch(controller, scenario, drawn, machine="screw", sensor=sensor)
    return 1000.0 * np.asarray(done.metrics["error_after_2s"])


def gain_sweep(lab: Lab, law: str, scenario: str) -> Metrics:
    """Over :data:`SPEEDS_MM_S`."""
    return lab.batch(LAWS[law], scenario, {"plant.full_duty_speed_mm_s": SPEEDS_MM_S}).metrics


def lag_sweep(lab: Lab, law: str, scenario: str) -> Metrics:
    """Over :data:`READER_LAGS_S`."""
    return lab.batch(LAWS[law], scenario, {"plant.grating_lag_s": READER_LAGS_S}).metrics


def dead_zone_sweep(lab: Lab, law: str, scenario: str) -> Metrics:
    """Over :data:`THRESHOLDS`: nothing happens below, everything above."""
    return lab.batch(LAWS[law], scenario, {"actuator.threshold": THRESHOLDS}, machine="dead_zone").metrics


def drift_sweep(lab: Lab, law: str, scenario: str) -> Metrics:
    """Over :data:`DRIFTS_MM_S`."""
    speed = lab.loop(LAWS[law], scenario, machine="drift").parameters["plant.full_duty_speed_mm_s"]
    return lab.batch(LAWS[law], scenario, {"actuator.bias": DRIFTS_MM_S / speed}, machine="drift").metrics


@measure
def friction_sweep(lab: Lab, scenario: str, integral: bool, share: float) -> Metrics:
    """The tuned law over :data:`FRICTIONS`, with a share of the dead zone's inverse, and integral action or none."""
    block = vud_scaled(integral_gain=2.0 if integral else 0.0, dead_zone_share=share)
    changes = {
        "actuator.threshold": FRICTIONS,
        "controller.dead_zone": FRICTIONS,
        "actuator.subtract": np.ones(len(FRICTIONS)),
    }
    return lab.batch(block, scenario, changes, machine="dead_zone").metrics


@measure
def settled_s(lab: Lab, controller: str) -> np.ndarray:
    """Seconds to 2 um of both steps, on the nominal axis and on 64 that no search has seen, ``[axis, step]``."""
    speeds = np.concatenate([[MACHINES["linear"].plant.params.full_duty_speed_mm_s], HELD_OUT_MM_S])
    varied = {"plant.full_duty_speed_mm_s": speeds}
    found = [lab.batch(controller, s.scenario, varied, 2.5).metrics["settling_2um"] for s in STEPS.values()]
    return np.nan_to_num(np.array(found).T, nan=np.inf)
