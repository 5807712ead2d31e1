"""Saturation: ``min(max(output, lower), upper)``."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc
from leadscrew.util.errors import ValueRefused


class SaturationParams(NamedTuple):
    """Limits in the unit of the controller's output; +-10 is the analogue drive command in volt."""

    lower: Annotated[float, Doc("least value that reaches the plant")] = -10.0
    upper: Annotated[float, Doc("largest value that reaches the plant")] = 10.0


def check_order(params: SaturationParams, dt: float) -> SaturationParams:
    """The limits as they are.

    Raises:
        ValueRefused: ``lower`` lies above ``upper``.
    """
    if params.lower > params.upper:
        raise ValueRefused(f"lower = {params.lower!r} (saturation): must not lie above upper = {params.upper!r}")
    return params


@actuator(SaturationParams, prepare=check_order)
def saturation(p, output):
    """The output inside the limits."""
    return min(max(output, p.lower), p.upper)
