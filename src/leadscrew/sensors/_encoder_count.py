"""An ideal screw encoder: the slide's position, rounded to whole counts, without lag.

    feedback = resolution floor(position / resolution + 1/2)

It stands for the photo-electric encoder of the original servo in Long et al. (2014); the paper gives no resolution.
One micrometre a count is our assumption: 10,000 counts on a screw of 10 mm lead. What the screw adds to the slide's
position (lead error, backlash, warmth) is not in it.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Gt, Unit


class EncoderCountParams(NamedTuple):
    """The size of a count."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("length of one count; assumed, not in the paper")] = 0.001


@sensor(EncoderCountParams, unit="mm")
def encoder_count(p, actual):
    """The position as a whole number of counts."""
    return p.resolution_mm * math.floor(actual.position / p.resolution_mm + 0.5)
