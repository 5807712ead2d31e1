"""The controllers of the study, by name, for a command and a feedback in mm, at 2 kHz.

``paper.*`` is as printed: the error inside the gain in mm, where the gain never leaves 1. ``corrected.*`` has it in um,
the one change that makes Table I mean something. ``ours.*`` are for comparison.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from leadscrew.controllers import (
    _adaptive_resonant as adaptive_resonant,
)
from leadscrew.controllers import (
    _cascade_ppi as cascade_ppi,
)
from leadscrew.controllers import (
    _dead_zone_inverse as dead_zone_inverse,
)
from leadscrew.controllers import (
    _input_dob as input_dob,
)
from leadscrew.controllers import (
    _inverse_feed_forward as inverse_feed_forward,
)
from leadscrew.controllers import (
    _learned_feed_forward as learned_feed_forward,
)
from leadscrew.controllers import (
    _npid_after as npid_after,
)
from leadscrew.controllers import (
    _npid_slope as npid_slope,
)
from leadscrew.controllers import (
    _npid_split as npid_split,
)
from leadscrew.controllers import (
    _repetitive as repetitive,
)
from leadscrew.controllers import (
    _resonant as resonant,
)
from leadscrew.controllers import (
    _tracking_differentiator as tracking_differentiator,
)
from leadscrew.controllers._filters import lead_lag, low_pass
from leadscrew.controllers._npid import READINGS, npid
from leadscrew.controllers._pid import TUNINGS as PID
from leadscrew.controllers._pid import pid
from leadscrew.controllers._series import series
from leadscrew.kernel.block import Block
from leadscrew.studies.tuned import tuned

SCALED = 2.265
"""What the gains of Table I may all be multiplied by under the circle criterion in L*."""

FILTERED = series(pid(filter_s=0.0), low_pass)
LINEAR: dict[str, Block] = {"pid": pid, "pid_low_pass": FILTERED, "pid_lag": series(FILTERED, lead_lag, name="pid_lag")}
"""Linear laws that are tuned: the PID, a PID behind a low-pass of second order, and that with a lag."""

BOUNDS = ("rest", "work")
"""Where the drives of tuned controllers are equally active."""


def _tuned() -> dict[str, Block]:
    """What it found: ``ours.LAW_BOUND``, with feed-forward ``ours.LAW_BOUND_ff``; gains in the folder ``tuned``."""
    home, found = Path(__file__).parent, {}
    for bound in BOUNDS:
        for law, block in (LINEAR | {"npid": npid, "npid_split": npid_split.npid_split}).items():
            found[f"ours.{law}_{bound}"] = plain = tuned(home, f"{law}_{bound}", block)
            if law in ("pid_low_pass", "pid_lag"):
                continue  # the rows of a linear loop do not depend on the command
            fed = inverse_feed_forward.inverse_feed_forward(plain)
            found[f"ours.{law}_{bound}_ff"] = fed if law == "pid" else tuned(home, f"{law}_{bound}_ff", fed)
    return found


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
    "ours.pid_low_pass": FILTERED,
    "ours.pid_lag": LINEAR["pid_lag"],
    "ours.npid_split_ff": inverse_feed_forward.inverse_feed_forward(npid_split.npid_split),
    **_tuned(),
}
"""By name. The rows of a linear loop do not depend on the command: ``ours.pid_*_ff`` have the gains without ``_ff``."""
