"""The controllers of the study, by name.

``paper.*`` is what the paper prints, ``corrected.*`` the same with what it needs to mean what it says: both in
continuous time, with the printed gains, which ask for 200 kHz and more. ``ours.*`` are for a machine: sampled at 4 kHz.
"""

from __future__ import annotations

from collections.abc import Mapping

from leadscrew.controllers.pd_dob import TUNINGS as PD_DOB
from leadscrew.controllers.pd_learned import TUNINGS as LEARNED
from leadscrew.controllers.sliding.complementary import csmc
from leadscrew.controllers.sliding.continuous import (
    csmc_ideal,
    fsmc_ideal,
    fsmc_printed_ideal,
    smc_ideal,
    smc_integral_ideal,
)
from leadscrew.controllers.sliding.conventional import smc
from leadscrew.controllers.sliding.fuzzy import TUNINGS as FUZZY
from leadscrew.controllers.sliding.integral import smc_integral
from leadscrew.controllers.sliding.super_twisting import super_twisting
from leadscrew.kernel.block import Block
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.tunings import TUNINGS

IDEAL: dict[str, Block] = {
    "paper.smc": smc_integral_ideal,
    "paper.csmc": csmc_ideal,
    "paper.fsmc": fsmc_printed_ideal,
    "corrected.smc": smc_ideal,
    "corrected.fsmc": fsmc_ideal,
}
"""Without sampling. What is corrected: the surface of the sliding mode has no integral; the rules act along s + s_c."""

SAMPLED: dict[str, Block] = {
    "ours.smc_4khz": smc,
    "ours.csmc_4khz": csmc,
    "ours.smc_integral_4khz": smc_integral,
    **{name: block for name, block in FUZZY.items() if name.startswith("ours.")},
    "ours.super_twisting": super_twisting,
    **PD_DOB,
    **LEARNED,
}
"""At 4 kHz, in rad; :data:`CONTROLLERS` has them in mm."""

CONTROLLERS: Mapping[str, Block] = (
    IDEAL | {name: block(travel_per_rad=TRAVEL_MM_PER_RAD) for name, block in SAMPLED.items()} | TUNINGS
)
"""By name, for a command and a feedback in mm of the table."""
