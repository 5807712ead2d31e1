"""The controllers of the study, by name: an offset of the tangential axis in degrees, every 10 ms.

``paper.*`` is the paper's controller as printed, with what it leaves open reconstructed; ``corrected.*`` the same with
what is wrong put right; ``ours.*`` are for comparison or go beyond it; ``tuned.*`` are controllers of all three with
gains that the same search has found for each (:mod:`leadscrew.studies.sofnn_tangent.tuning`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from leadscrew.controllers._pid import pid
from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.delayed_pd import delayed_pd
from leadscrew.studies.sofnn_tangent.tunings import CURVATURE
from leadscrew.studies.sofnn_tangent.tunings import CURVATURE as FEED_FORWARD
from leadscrew.studies.sofnn_tangent.tunings import CURVATURE as OBSERVER
from leadscrew.studies.sofnn_tangent.tunings import TUNINGS as SOFNN
from leadscrew.studies.tuned import tuned

LAG_S = 0.02
"""Of the derivative of the PIDs."""


def offset_pid(name: str, kp: float, ki: float, kd: float, **values: Any) -> Block:
    """A PID of the deviation; its output is the offset of the tangential axis, held to 15 degrees."""
    law = replace(pid, name=name, unit="deg", drive="", full_scale=15.0)
    return law(kp=kp, ki=ki, kd=kd, lower=-15.0, upper=15.0, **values)


UNTUNED: Mapping[str, Block] = {
    **SOFNN,
    **OBSERVER,
    **FEED_FORWARD,
    **CURVATURE,
    "paper.uncompensated": offset_pid("uncompensated", 0.0, 0.0, 0.0),
    "ours.pid": offset_pid("pid", 0.7, 14.0, 0.005, filter_s=LAG_S),
    "ours.pid_fast": offset_pid("pid", 0.7, 22.0, 0.01, filter_s=LAG_S),
    "ours.pid_mild": offset_pid("pid", 0.3, 6.0, 0.0, filter_s=LAG_S),
    "ours.delayed_pd": delayed_pd,
}
TUNED_FROM = {
    "pi": "ours.pid",
    "pid": "ours.pid",
    "observer": "ours.tangent_dob",
    "delayed_pd": "ours.delayed_pd",
    "network": "paper.sofnn_pnn",
    "accumulating": "ours.sofnn_tuned",
    "sofc": "corrected.sofc",
    "fixed": "corrected.fnn",
    "feed_forward": "ours.curvature_feed_forward",
    "curvature": "ours.curvature_network",
}
"""Files in the folder ``tuned``, and the controllers that the searches began with."""
CONTROLLERS: Mapping[str, Block] = {
    **UNTUNED,
    **{f"tuned.{name}": tuned(Path(__file__).parent, name, UNTUNED[base]) for name, base in TUNED_FROM.items()},
}
"""By name."""
