"""An encoder on the motor of a ball screw: its turns in whole counts, shown as millimetres of nominal lead.

    q = lead / counts_per_turn,    feedback = q floor(motor / q + 1/2)

It reads ``actual.motor``, the nominal position of the nut (:obj:`leadscrew.plants.lathe_screw`), without lag: what the
screw adds between nut and table it cannot see. 10,000 counts on 10 mm of lead, 1 um a count, are assumed; Long et al.
(2014) give neither for the photo-electric encoder of their old servo.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Gt, Unit


class ScrewEncoderParams(NamedTuple):
    """The screw's lead and the counts of a turn."""

    lead_mm: Annotated[float, Unit("mm"), Gt(0), Doc("nominal travel per turn; assumed, not in the paper")] = 10.0
    counts_per_turn: Annotated[float, Gt(0), Doc("counts of a turn after evaluating all edges; assumed")] = 10_000.0


class ScrewEncoderPlan(NamedTuple):
    """What the step needs."""

    resolution: float


def plan_screw_encoder(params: ScrewEncoderParams, dt: float) -> ScrewEncoderPlan:
    """The length of one count."""
    return ScrewEncoderPlan(params.lead_mm / params.counts_per_turn)


@sensor(ScrewEncoderParams, prepare=plan_screw_encoder, unit="mm")
def screw_encoder(p, actual):
    """The nut's nominal position as a whole number of counts."""
    return p.resolution * math.floor(actual.motor / p.resolution + 0.5)
