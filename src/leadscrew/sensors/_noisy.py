"""A sensor that adds noise and nothing else: ``feedback = actual + w``, for a plant that shows one number.

``w`` is Gaussian and white, one independent value for each control period. Without noise it is no sensor at all, bit
for bit. ``noisy_position`` is the same for a plant that shows a position in mm.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.parameters import Doc, Ge
from leadscrew.sensors._noisy_count import Noise, with_noise


class NoisyParams(NamedTuple):
    """Noise in the unit of what the plant shows."""

    deviation: Annotated[float, Ge(0), Doc("standard deviation of one reading, in the unit of the plant")] = 0.0


@sensor(NoisyParams)
def noisy(p, actual, noise):
    """What the plant shows, and noise."""
    return with_noise(actual, p.deviation, noise)


class NoisyPositionParams(NamedTuple):
    """Noise of a position."""

    noise_mm: Noise = 0.0


@sensor(NoisyPositionParams, unit="mm")
def noisy_position(p, actual, noise):
    """The position, and noise."""
    return with_noise(actual, p.noise_mm, noise)
