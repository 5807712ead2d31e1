"""Sensor and controller, two by two: which of them makes the accuracy, on axes whose screw and ruler have errors.

Every axis is drawn once and then tried with each pair of sensor and controller: the screw's lead, cyclic error, play
and warmth, and the ruler's residual interpolation error and noise, uniformly in :data:`RANGES`. Digest section 9.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from leadscrew.studies.vud_lathe.runs import STEPS, Loops

DRAWS, SEED = 200, 9
"""How many axes, as in the digest, and the seed they are drawn with (ours; the digest does not print its own)."""

RANGES: dict[str, tuple[float, float]] = {
    "plant.lead_error": (-12.0 / 300e3, 12.0 / 300e3),
    "plant.cyclic_error_mm": (0.9e-3, 3.0e-3),
    "plant.backlash_mm": (0.0, 6.0e-3),
    "plant.warming_K": (0.0, 3.0),
}
"""Of the screw: 12 um in 300 mm (ISO 3408 grade 3), play up to 6 um, up to 3 K too warm."""
RULER_RANGES: dict[str, tuple[float, float]] = {
    "sensor.interpolation_1_mm": (0.0, 0.15e-3),
    "sensor.interpolation_2_mm": (0.0, 0.08e-3),
    "sensor.interpolation_phase": (0.0, 2.0 * np.pi),
    "sensor.noise_mm": (50e-6, 50e-6),
}
"""Of the grating: what interpolation leaves after its adjustment, and 50 nm of noise."""
LEADS_UM_PER_300_MM = (12.0, 23.0, 52.0)
"""Screws of ISO 3408 grades 3, 5 and 7, for the share of the screw in the encoder's error."""


Errors = Mapping[tuple[str, str, str], np.ndarray]
"""Errors after 2 s in um over the drawn axes, by controller, sensor and scenario."""


class Spread(NamedTuple):
    """Error after 2 s over the drawn axes, in um."""

    p95: float
    largest: float


def axes(lead_um: float = LEADS_UM_PER_300_MM[0]) -> dict[str, np.ndarray]:
    """The drawn axes, by dotted key; the same ones whatever the lead's grade, but for the lead."""
    rng = np.random.default_rng(SEED)
    drawn = {key: rng.uniform(*ends, DRAWS) for key, ends in (RANGES | RULER_RANGES).items()}
    drawn["plant.lead_error"] = drawn["plant.lead_error"] * lead_um / LEADS_UM_PER_300_MM[0]
    return drawn


def errors_um(
    loops: Loops,
    controller: str,
    scenario: str,
    sensor: str,
    lead_um: float = LEADS_UM_PER_300_MM[0],
    after_s: float = 2.0,
) -> np.ndarray:
    """Largest error of the table after 2 s (or ``after_s``) on every drawn axis."""
    on_ruler = sensor == "grating"
    drawn = {k: v for k, v in axes(lead_um).items() if on_ruler or k not in RULER_RANGES}
    drawn["metrics.error_after_2s.from_time"] = np.full(DRAWS, after_s)
    done = loops.batch(controller, scenario, drawn, machine="screw", sensor=sensor)
    return 1000.0 * np.asarray(done.metrics["error_after_2s"])


def spread(found: np.ndarray) -> Spread:
    """95th percentile and largest."""
    return Spread(float(np.percentile(found, 95.0)), float(found.max()))


def two_by_two(loops: Loops, controllers: tuple[str, ...]) -> Errors:
    """Errors by controller, sensor and scenario."""
    return {
        (controller, sensor, scenario): errors_um(loops, controller, scenario, sensor)
        for controller in controllers
        for sensor in ("encoder", "grating")
        for scenario in STEPS
    }
