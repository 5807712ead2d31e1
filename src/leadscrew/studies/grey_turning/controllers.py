"""The controllers of the study, by name, for a force in N and a feed voltage, every 20 ms.

The paper prints neither its rules (Table 1 is missing in the text that we have) nor its scaling factors: ``paper.*``
has what is printed, errors included; ``corrected.*`` the paper's laws with the standard table and factors of our own.
``ours.*`` are for comparison; the gains of ``ours.*_tuned`` were found by one search each, with the same budget,
plants, scenarios and goal (``tuned/*.toml``). More of the same kind:
:data:`leadscrew.studies.grey_turning.tunings.TUNINGS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from leadscrew.controllers._force import depth_feed_forward, gain_normalised
from leadscrew.controllers._pid import pid
from leadscrew.kernel.block import Block
from leadscrew.studies.grey_turning.tunings import FORCE
from leadscrew.studies.grey_turning.tunings import TUNINGS as GREY_FUZZY
from leadscrew.studies.tuned import tuned

OTHERS = (
    *("ours.pi_s9", "ours.pi_stfc", "ours.fir_s9", "ours.line_stfc", "ours.smith_f", "ours.smith_n"),
    *(f"ours.two_point_{factors}" for factors in ("s6", "s9", "s9_half", "stfc")),
)
"""Of the comparison controllers those that the study uses."""

feed_pid = replace(pid, unit="V", drive="voltage", full_scale=10.0)
"""A PID in front of the feed drive."""
PI = GREY_FUZZY["ours.pi_stfc"]
KNOWN: dict[str, Block] = {
    **{name: block for name, block in GREY_FUZZY.items() if not name.startswith("ours.")},
    **{name: GREY_FUZZY[name] for name in OTHERS},
    **FORCE,
    "ours.pid": feed_pid(kp=0.0013, ki=0.0145, kd=2e-5, b=0.0, c=0.0, lower=-1.0, upper=1.0),
    "ours.pi_normalised": gain_normalised(PI),
    "ours.pi_ff": depth_feed_forward(PI),
    "ours.pi_normalised_ff": depth_feed_forward(gain_normalised(PI)),
}

FORCE_ONLY = {
    "pi": "ours.pi_stfc",
    "pid": "ours.pid",
    "tfc": "corrected.tfc_stfc",
    "gpfc": "corrected.gpfc_b_stfc",
    "two_point": "ours.two_point_stfc",
    "smith": "ours.smith_f",
    "pi_normalised": "ours.pi_normalised",
}
"""Controllers that get the filtered force and no more, by the name of their tuned gains: what they are tuned from."""
MORE = {
    "inversion": "ours.inversion",
    "pi_ff": "ours.pi_ff",
    "pi_normalised_ff": "ours.pi_normalised_ff",
    "constant_force": "ours.constant_force",
}
"""The same of controllers that get more."""

CONTROLLERS: Mapping[str, Block] = KNOWN | {
    f"ours.{name}_tuned": tuned(Path(__file__).parent, name, KNOWN[start])
    for name, start in (FORCE_ONLY | MORE).items()
}
