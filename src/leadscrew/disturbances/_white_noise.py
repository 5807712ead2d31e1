"""A random load: Gaussian, one independent value for each control period, held over it.

``deviation`` is that of one period's value; its one-sided power spectral density is ``2 deviation^2 dt`` well
below the control rate, so the same deviation at a shorter period shakes the plant less.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge


class WhiteNoiseParams(NamedTuple):
    """A load in the unit of the plant's load."""

    deviation: Annotated[float, Ge(0), Doc("standard deviation of one period's value")] = 1.0
    mean: Annotated[float, Doc("mean of the load")] = 0.0


@disturbance(WhiteNoiseParams)
def white_noise(p, noise):
    """``mean`` plus ``deviation`` times this period's normal number."""
    return p.mean + p.deviation * normal(noise, 0)
