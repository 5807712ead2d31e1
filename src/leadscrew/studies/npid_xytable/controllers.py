"""The controllers of the study, by name, for a command and a feedback in mm, at 2 kHz.

Those of :mod:`leadscrew.studies.npid_xytable.tunings`, and those that a search has tuned.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from leadscrew.controllers import lead_lag, low_pass, npid, npid_split
from leadscrew.controllers._series import series
from leadscrew.kernel.block import Block
from leadscrew.studies.npid_xytable.tunings import TUNINGS, fed_forward, table_pid
from leadscrew.studies.tuned import tuned

FILTERED = series(table_pid(filter_s=0.0), low_pass)
LINEAR: dict[str, Block] = {
    "pid": table_pid,
    "pid_low_pass": FILTERED,
    "pid_lag": series(FILTERED, lead_lag, name="pid_lag"),
}
"""Linear laws that are tuned: the PID, a PID behind a low-pass of second order, and that with a lag."""

BOUNDS = ("rest", "work")
"""Where the drives of tuned controllers are equally active."""


def _tuned() -> dict[str, Block]:
    """What it found: ``ours.LAW_BOUND``, with feed-forward ``ours.LAW_BOUND_ff``; gains in the folder ``tuned``."""
    home, found = Path(__file__).parent, {}
    for bound in BOUNDS:
        for law, block in (LINEAR | {"npid": npid, "npid_split": npid_split}).items():
            found[f"ours.{law}_{bound}"] = plain = tuned(home, f"{law}_{bound}", block)
            if law in ("pid_low_pass", "pid_lag"):
                continue  # the rows of a linear loop do not depend on the command
            fed = fed_forward(plain)
            found[f"ours.{law}_{bound}_ff"] = fed if law == "pid" else tuned(home, f"{law}_{bound}_ff", fed)
    return found


CONTROLLERS: Mapping[str, Block] = {
    **TUNINGS,
    "ours.pid_low_pass": FILTERED,
    "ours.pid_lag": LINEAR["pid_lag"],
    "ours.npid_split_ff": fed_forward(npid_split),
    **_tuned(),
}
"""By name. The rows of a linear loop do not depend on the command: ``ours.pid_*_ff`` have the gains without ``_ff``."""
