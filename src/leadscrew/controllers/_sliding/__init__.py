"""Sliding-mode controllers of a stage with friction, after Shams and Safdari (2010)."""

from leadscrew.controllers._sliding.complementary import csmc
from leadscrew.controllers._sliding.conventional import smc
from leadscrew.controllers._sliding.integral import smc_integral
from leadscrew.kernel.block import Block

READINGS: dict[str, Block] = {
    "paper.smc_integral": smc_integral(layer_rate=0.0),
    "corrected.smc": smc(layer_rate=0.0),
    "paper.csmc": csmc(layer_rate=0.0),
    "ours.smc_integral_4khz": smc_integral,
    "ours.smc_4khz": smc,
    "ours.csmc_4khz": csmc,
}
"""By the names of the study: the printed boundary layer, for periods below 6 us, and ours for 4 kHz and above."""

__all__ = ["READINGS", "csmc", "smc", "smc_integral"]
