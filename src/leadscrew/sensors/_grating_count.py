"""An ideal grating counter: the lagged reading of an axis, rounded to whole counts.

    feedback = resolution floor(reading / resolution + 1/2)

With 100 line pairs a millimetre, subdivided 16 times, one count is 0.625 um (Long et al. 2014, section III).
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Gt, Unit


class GratingCountParams(NamedTuple):
    """The size of a count."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("length of one count: pitch over subdivision")] = 0.000625


@sensor(GratingCountParams, unit="mm")
def grating_count(p, actual):
    """The reading as a whole number of counts."""
    return p.resolution_mm * math.floor(actual.reading / p.resolution_mm + 0.5)
