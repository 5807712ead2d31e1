"""A linear scale: position rounded to its resolution, ``feedback = q floor(actual / q + 1/2)``.

The rounding error is at most ``q/2``; a position exactly between two marks goes to the upper one.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Gt, Unit


class RulerParams(NamedTuple):
    """A scale without noise."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("distance between two readings, after interpolation")] = (
        0.000625
    )


def rounded(x, quantum):
    """``x`` to the nearest multiple of ``quantum``, halves up."""
    return quantum * math.floor(x / quantum + 0.5)


@sensor(RulerParams, unit="mm")
def ruler(p, actual):
    """The nearest mark."""
    return rounded(actual, p.resolution_mm)
