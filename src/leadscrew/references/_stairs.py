"""Positioning in steps: from one position to the next, each held for a dwell, and the last for good.

    command(t) = positions[k],    k = min(floor(t / dwell), n - 1)

A command without a profile, as the steps of a positioning test are; :obj:`leadscrew.references.waypoints` has the one
with limited speed and acceleration.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.util.errors import ValueRefused, entry_point


class StairsParams(NamedTuple):
    """The positions, in the unit of the loop's command, and how long each is held."""

    positions: Annotated[NDArray[np.float64], Unit("mm"), Doc("commanded one after the other")]
    dwell: Annotated[float, Unit("s"), Gt(0), Doc("time from one step of the command to the next")] = 3.0


class StairsPlan(NamedTuple):
    """What the step needs."""

    positions: NDArray[np.float64]
    dwell: float
    last: float


def plan_stairs(params: StairsParams, dt: float) -> StairsPlan:
    """The positions and the index of the last one."""
    return StairsPlan(params.positions, params.dwell, float(params.positions.size - 1))


def stairs_step(p, t, dt):
    """The position of the dwell that the sample at ``t`` lies in, to the nearest period."""
    k = int(min(math.floor((t + 0.5 * dt) / p.dwell), p.last))
    return p.positions[k]


@entry_point
def stairs(positions: Any, dwell: float = 3.0) -> Block:
    """A reference that steps through ``positions``, each held for ``dwell`` seconds, and stays at the last.

    Raises:
        ValueRefused: no positions, or a value out of range.
    """
    places = np.array(positions, dtype=np.float64)
    if places.ndim != 1 or places.size < 1:
        raise ValueRefused(f"positions = {positions!r} (stairs): expected one number or more in a row")
    empty = StairsParams(places)
    block = reference(empty, prepare=plan_stairs, name="stairs", unit="mm")(stairs_step)
    return block.using(positions=places, dwell=dwell)
