"""A stand-in for the servo controller that the paper replaced, fitted by us to the paper's Table 1.

    rho = -sgn(e) min(1, c |e|^p),    e = (command - feedback) / 190 mm

Long et al. (2014) print no law of their original controller, only its moves in Table 1. Of the simple laws this one
reproduces them best: with ``c = 0.929``, ``p = 0.618`` and 289 mm/s at full duty within 1.6 % of each move. It is our
fit, not a correction of anything printed. Its gain grows without bound towards ``e = 0``.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit


class PowerLawParams(NamedTuple):
    """The fitted law."""

    error_full_scale_mm: Annotated[float, Unit("mm"), Gt(0), Doc("position error that makes e = 1")] = 190.0
    gain: Annotated[float, Gt(0), Doc("duty at e = 1, before the limit of 1")] = 0.929
    exponent: Annotated[float, Ge(0), Doc("exponent of the error")] = 0.618


@controller(PowerLawParams, unit="1", drive="duty", full_scale=1.0, sense=-1)
def power_law(p, command, feedback):
    """The duty against the error."""
    e = (command - feedback) / p.error_full_scale_mm
    size = min(1.0, p.gain * abs(e) ** p.exponent)
    return -size if e > 0.0 else size if e < 0.0 else 0.0
