"""A dead zone: a command below a threshold does nothing, as stiction in the screw or in the motor's brushes has it.

    u = 0                                   |output| < d
    u = output                              otherwise, subtract = False: the command is lost below d, whole above
    u = sign(output) (|output| - d)         otherwise, subtract = True: d of every command is spent on friction

A driver's current that has to exceed static friction alone is the first, Coulomb friction of a moving axis seen at the
duty is the second; the second is continuous, the first jumps by ``d`` at its threshold.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc, Ge


class DeadZoneParams(NamedTuple):
    """Threshold in the unit of the controller's output, and what is left above it."""

    threshold: Annotated[float, Ge(0), Doc("d: least size of the output that does anything")] = 0.01
    subtract: Annotated[bool, Doc("whether the threshold is taken off every output above it")] = False


@actuator(DeadZoneParams)
def dead_zone(p, output):
    """What is left of the output."""
    size = abs(output)
    left = size - p.threshold if p.subtract else size
    return 0.0 if size < p.threshold else left if output > 0.0 else -left
