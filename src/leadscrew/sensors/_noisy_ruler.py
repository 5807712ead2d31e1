"""A linear scale with noise before its interpolator: ``feedback = q floor((actual + w) / q + 1/2)``.

``w`` is Gaussian and white, one independent value for each control period: the noise of the analogue signals, which the
interpolator then rounds. With a resolution far below ``noise_mm`` it is plain additive noise.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.sensors._ruler import rounded


class NoisyRulerParams(NamedTuple):
    """A scale with noise."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("distance between two readings, after interpolation")] = (
        0.000625
    )
    noise_mm: Annotated[float, Unit("mm"), Ge(0), Doc("standard deviation of the noise of one reading")] = 0.0005


@sensor(NoisyRulerParams, unit="mm")
def noisy_ruler(p, actual, noise):
    """The mark nearest to the position plus its noise."""
    return rounded(actual + p.noise_mm * normal(noise, 0), p.resolution_mm)
