"""A hard spot in the work: the specific force rises along a line, stays, and falls again.

    load = size c((t - start) / rise_s) c((start + rise_s + stay_s + fall_s - t) / fall_s),      c(x) = clip(x, 0, 1)

``load`` is the relative rise of the specific force (1.0 doubles it), taken in the middle of each period, because the
plant gets it for a whole period. A rise or fall of 0 is a step. Source: ours;
twice the force within 40 ms is chosen as a hard case.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, Ge, Unit

STEP_S = 1e-9
"""A rise that is a step."""


class HardSpotParams(NamedTuple):
    """Size and times."""

    size: Annotated[float, Ge(-1), Doc("relative rise of the specific force")] = 1.0
    start: Annotated[float, Unit("s"), Ge(0), Doc("when the rise begins")] = 1.5
    rise_s: Annotated[float, Unit("s"), Ge(0), Doc("how long it takes")] = 0.04
    stay_s: Annotated[float, Unit("s"), Ge(0), Doc("how long it stays")] = 0.2
    fall_s: Annotated[float, Unit("s"), Ge(0), Doc("how long the fall takes")] = 0.04


@disturbance(HardSpotParams)
def hard_spot(p, t, dt):
    """The relative rise of the specific force now."""
    middle = t + 0.5 * dt
    end = p.start + p.rise_s + p.stay_s + p.fall_s
    up = min(max((middle - p.start) / max(p.rise_s, STEP_S), 0.0), 1.0)
    down = min(max((end - middle) / max(p.fall_s, STEP_S), 0.0), 1.0)
    return p.size * up * down
