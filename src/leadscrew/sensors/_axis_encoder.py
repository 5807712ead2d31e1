"""The encoder that a loop of an axis with backlash is closed on: a linear scale on the table, or one on the motor.

    feedback = q floor(x / q + 1/2),    x = actual.position on the table, actual.motor on the motor

For plants that show both (:mod:`leadscrew.plants._backlash`), in the unit in which they show it. On the motor the play
is outside the loop and stays as a step; on the table it is inside, and the controller has to take it.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Ge
from leadscrew.sensors._ruler import rounded


class AxisEncoderParams(NamedTuple):
    """Where it sits, and its resolution."""

    on_table: Annotated[bool, Doc("whether the table is read, not the motor")] = True
    resolution: Annotated[float, Ge(0), Doc("one count, in the unit of the plant; 0 for none")] = 1e-5


@sensor(AxisEncoderParams)
def axis_encoder(p, actual):
    """The nearest count of the table or of the motor."""
    place = actual.position if p.on_table else actual.motor
    return rounded(place, p.resolution) if p.resolution > 0.0 else place
