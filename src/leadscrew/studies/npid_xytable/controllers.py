"""The controllers of the study, by name, for a command and a feedback in mm, at 2 kHz.

``paper.*`` is as printed: the error inside the gain in mm, where the gain never leaves 1. ``corrected.*`` has it in um,
the one change that makes Table I mean something. ``ours.*`` are for comparison.
"""

from __future__ import annotations

from collections.abc import Mapping

from leadscrew.controllers import (
    adaptive_resonant,
    cascade_ppi,
    dead_zone_inverse,
    input_dob,
    inverse_feed_forward,
    learned_feed_forward,
    npid_after,
    npid_slope,
    npid_split,
    repetitive,
    resonant,
    tracking_differentiator,
)
from leadscrew.controllers.npid import READINGS
from leadscrew.controllers.pid import TUNINGS as PID
from leadscrew.controllers.pid import pid
from leadscrew.kernel.block import Block

SCALED = 2.265
"""What the gains of Table I may all be multiplied by under the circle criterion in L*."""

CONTROLLERS: Mapping[str, Block] = {
    **PID,
    **READINGS,
    "ours.pid_scaled": pid(kp=SCALED * pid.params.kp, ki=SCALED * pid.params.ki, kd=SCALED * pid.params.kd),
    **npid_slope.TUNINGS,
    **npid_after.TUNINGS,
    **npid_split.TUNINGS,
    **inverse_feed_forward.TUNINGS,
    **cascade_ppi.TUNINGS,
    **input_dob.TUNINGS,
    **resonant.TUNINGS,
    "ours.resonant_full_185": inverse_feed_forward.inverse_feed_forward(
        resonant.resonant(PID["ours.pid_ms_185"]), share=0.9
    ),
    **adaptive_resonant.TUNINGS,
    **repetitive.TUNINGS,
    **learned_feed_forward.TUNINGS,
    **tracking_differentiator.TUNINGS,
    "ours.pid_dead_zone": dead_zone_inverse.dead_zone_inverse(pid, width=0.02, softness=1e-3),
    "ours.pid_quiet": pid(kp=0.368723, ki=62.219044, kd=0.002937, filter_s=0.001726),
}
"""By name. ``ours.pid_quiet`` is the end of :func:`leadscrew.studies.npid_xytable.split_law.best_linear`."""
