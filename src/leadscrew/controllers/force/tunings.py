"""Controllers of this package that are ready for the lathes of the study ``grey_turning``, every 20 ms.

The depth is believed to change at once; where it goes through a radial servo, set ``radial.gain`` and ``radial.lag_s``.
"""

from __future__ import annotations

from leadscrew.controllers.force.constant_force import constant_force
from leadscrew.controllers.force.depth_feed_forward import depth_feed_forward
from leadscrew.controllers.force.gain_normalised import gain_normalised
from leadscrew.controllers.force.power_law_inversion import power_law_inversion
from leadscrew.controllers.grey_fuzzy.tunings import TUNINGS as GREY_FUZZY
from leadscrew.kernel.block import Block

TFC = GREY_FUZZY["corrected.tfc_stfc"]
"""What is wrapped: the TFC that is tuned best for plant F."""

PREVIEW_N_S = 0.125
"""Lag of plant N's servo, its dead time, half a revolution and half a period."""

TUNINGS: dict[str, Block] = {
    "ours.tfc_ff": depth_feed_forward(TFC),
    "ours.gain_normalised": gain_normalised(TFC),
    "ours.inversion": power_law_inversion,
    "ours.inversion_cautious": power_law_inversion(first_k=3.0 * 2256.3, stiffness=12000.0),
    "ours.constant_force": constant_force,
    "ours.constant_force_n": constant_force(preview_s=PREVIEW_N_S, lead=0.5, lead_lag_s=0.04),
}
"""By name; ``_n``: for plant N."""
