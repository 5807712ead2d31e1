"""The axes of the study: the printed plant with the dead time that its stability plot needs, without it, with friction.

The paper prints no dead time, yet its plot crosses the negative real axis at -0.4. In a loop sampled at 2 kHz with a
backward difference that takes 0.775 ms (the digest's loop L*).
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.kernel.block import Block
from leadscrew.plants.xy_table_cutting import xy_table_cutting
from leadscrew.plants.xy_table_lugre import xy_table_lugre
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S


class Machine(NamedTuple):
    """An axis, and how it is stepped."""

    doc: str
    plant: Block
    substeps: int = 1
    computation_delay: float = 0.0
    """Dead time, for a plant that has none of its own."""


FRICTION_STEPS = 20
"""Integration steps a period of an axis with friction: 25 us."""


def _rough(friction_mv: float, presliding_um: float) -> Machine:
    return Machine(
        f"the same with LuGre friction of {friction_mv:g} mV and {presliding_um:g} um of presliding",
        xy_table_lugre(friction_mv=friction_mv, presliding_um=presliding_um),
        FRICTION_STEPS,
        DEAD_TIME_S,
    )


MACHINES: dict[str, Machine] = {
    "l_star": Machine("equation (1) with 0.775 ms of dead time", xy_table_cutting),
    "l_zero": Machine("equation (1) as printed, without dead time", xy_table_cutting(dead_time_s=0.0)),
    "friction_low": _rough(2.6, 2.0),
    "friction_medium": _rough(20.0, 5.0),
    "friction_high": _rough(150.0, 10.0),
}
"""By name; a scenario that ends in ``_on_NAME`` runs on that one, every other on ``l_star``."""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "l_star")
