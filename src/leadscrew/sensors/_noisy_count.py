"""The counters of a lathe axis with noise before the rounding: ``feedback = q floor((x + w) / q + 1/2)``.

``w`` is Gaussian and white, one independent value for each control period, and not asked for where ``noise_mm`` is 0:
then they are ``grating_count`` and ``encoder_count`` bit for bit. The first reads the lagged reading, the second the
position.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.sensors._ruler import rounded

Noise = Annotated[float, Unit("mm"), Ge(0), Doc("standard deviation of the noise of one reading")]


class NoisyGratingParams(NamedTuple):
    """The size of a count, and the noise."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("length of one count: pitch over subdivision")] = 0.000625
    noise_mm: Noise = 0.0


class NoisyEncoderParams(NamedTuple):
    """The size of a count, and the noise."""

    resolution_mm: Annotated[float, Unit("mm"), Gt(0), Doc("length of one count; assumed, not in the paper")] = 0.001
    noise_mm: Noise = 0.0


def with_noise(x, size, noise):
    """``x`` plus this period's noise; ``x`` itself without."""
    return x + size * normal(noise, 0) if size > 0.0 else x


@sensor(NoisyGratingParams, unit="mm")
def noisy_grating(p, actual, noise):
    """The lagged reading and its noise as a whole number of counts."""
    return rounded(with_noise(actual.reading, p.noise_mm, noise), p.resolution_mm)


@sensor(NoisyEncoderParams, unit="mm")
def noisy_encoder(p, actual, noise):
    """The position and its noise as a whole number of counts."""
    return rounded(with_noise(actual.position, p.noise_mm, noise), p.resolution_mm)
