"""A constant added to the output, ``u = output + bias``: an amplifier that is off zero, or a load that drifts the axis.

An axis whose speed is ``K_v u`` drifts with ``K_v bias``: 0.1 mm/s on the lathe axis of 289 mm/s is a bias of 3.46e-4.
A controller without integral action answers with a standing error.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc


class OffsetParams(NamedTuple):
    """What is added, in the unit of the controller's output."""

    bias: Annotated[float, Doc("added to every output; 0.1/289: 0.1 mm/s of drift on the lathe axis")] = 0.1 / 289.0


@actuator(OffsetParams)
def offset(p, output):
    """The output and the bias."""
    return output + p.bias
