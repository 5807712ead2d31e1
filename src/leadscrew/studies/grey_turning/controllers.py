"""The controllers of the study, by name, for a force in N and a feed voltage, every 20 ms.

The paper prints neither its rules (Table 1 is missing in the text that we have) nor its scaling factors: ``paper.*``
has what is printed, errors included; ``corrected.*`` the paper's laws with the standard table and factors of our own.
``ours.*`` are for comparison. More of the same kind: :data:`leadscrew.controllers.grey_fuzzy.tunings.TUNINGS`.
"""

from __future__ import annotations

from collections.abc import Mapping

from leadscrew.controllers.force.tunings import TUNINGS as FORCE
from leadscrew.controllers.grey_fuzzy.tunings import TUNINGS as GREY_FUZZY
from leadscrew.kernel.block import Block

OTHERS = (
    *("ours.pi_s9", "ours.pi_stfc", "ours.fir_s9", "ours.line_stfc", "ours.smith_f", "ours.smith_n"),
    *(f"ours.two_point_{factors}" for factors in ("s6", "s9", "s9_half", "stfc")),
)
"""Of the comparison controllers those that the study uses."""

CONTROLLERS: Mapping[str, Block] = {
    **{name: block for name, block in GREY_FUZZY.items() if not name.startswith("ours.")},
    **{name: GREY_FUZZY[name] for name in OTHERS},
    **FORCE,
}
