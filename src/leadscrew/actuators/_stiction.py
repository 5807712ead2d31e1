"""Stiction seen at the command: what is smaller than a threshold does nothing, everything else passes unchanged.

    u = 0 where |output| < d,      u = output elsewhere

The ``dead_zone`` that does not subtract; with ``threshold = 0`` it is no actuator at all, bit for bit: the sign of a
zero passes too.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc, Ge


class StictionParams(NamedTuple):
    """The threshold in the unit of the controller's output."""

    threshold: Annotated[float, Ge(0), Doc("d: least size of the output that does anything")] = 0.0


@actuator(StictionParams)
def stiction(p, output):
    """The output, or 0 below the threshold."""
    return 0.0 if abs(output) < p.threshold else output
