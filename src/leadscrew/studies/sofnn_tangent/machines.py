"""The plants of the study: the reconstructed process, and one that breaks its rules."""

from __future__ import annotations

from leadscrew.kernel.block import Block
from leadscrew.plants.flexible_cut import flexible_cut

MISMATCH = {"softening": 12.0, "four_fold": 0.7, "ripple": 0.5, "hysteresis": 0.3}
"""Sharp curves add less shear, the fibre acts four-fold, a wave runs along the way, and the shear has a play.

The digest gives no sizes: fitted to its two numbers without compensation, mean RMS 1.45, mean of the largest 3.5 deg.
"""

MACHINES: dict[str, Block] = {
    "believed": flexible_cut,
    "mismatch": flexible_cut(**MISMATCH),
}
"""By name; a scenario that ends in ``_on_NAME`` runs on that one, every other on ``believed``."""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "believed")
