"""What a control reads of an identified axis: a linear scale on the table or an encoder on the motor, with noise.

    feedback = q floor((x + w) / q + 1/2),    x = actual.position on the table, actual.motor on the motor

``w`` is Gaussian and white, one value a period. The counterpart of :obj:`leadscrew.sensors.axis_encoder` for machines
whose noise was measured; in the unit in which the plant shows its position.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge
from leadscrew.sensors._ruler import rounded


class AxisReadingParams(NamedTuple):
    """Where it sits, its resolution and its noise."""

    on_table: Annotated[bool, Doc("whether the table is read, not the motor")] = True
    resolution: Annotated[float, Ge(0), Doc("one count, in the unit of the plant; 0 for none")] = 1e-4
    noise: Annotated[float, Ge(0), Doc("standard deviation of a reading before it is rounded, same unit")] = 0.0


@sensor(AxisReadingParams)
def axis_reading(p, actual, noise):
    """The count nearest to the table, or the motor, plus its noise."""
    place = (actual.position if p.on_table else actual.motor) + p.noise * normal(noise, 0)
    return rounded(place, p.resolution) if p.resolution > 0.0 else place
