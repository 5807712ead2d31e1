"""Sensors of a position, one formula: a place of the plant, noise before the interpolator, rounding to whole counts.

    feedback = q floor((x + w) / q + 1/2)

The rounding error is at most ``q/2``; a position exactly between two counts goes to the upper one. ``w`` is Gaussian
and white, one independent value for each control period: the noise of the analogue signals. With ``q`` far below its
deviation it is plain additive noise; with a deviation of 0 it is left out, bit for bit.

====================  ==============================  ======================  ====================================
block                 place x                         count q                 noise w
====================  ==============================  ======================  ====================================
``ruler``             what the plant shows            ``resolution_mm``       none
``noisy_ruler``       what the plant shows            ``resolution_mm``       ``noise_mm``
``grating_count``     ``reading``, lagged             ``resolution_mm``       none
``noisy_grating``     ``reading``, lagged             ``resolution_mm``       ``noise_mm``
``encoder_count``     ``position``                    ``resolution_mm``       none
``noisy_encoder``     ``position``                    ``resolution_mm``       ``noise_mm``
``screw_encoder``     ``motor``                       lead / counts per turn  none
``axis_encoder``      ``position`` or ``motor``       ``resolution``, 0: any  none
``axis_reading``      ``position`` or ``motor``       ``resolution``, 0: any  ``noise``
``noisy``             what the plant shows            any                     ``deviation``, in the plant's unit
``noisy_position``    what the plant shows            any                     ``noise_mm``
====================  ==============================  ======================  ====================================

- **Scale**: ``ruler`` and ``noisy_ruler`` are for plants that show one number in mm.
- **Lathe** (Long et al. 2014): 100 line pairs a millimetre, subdivided 16 times, make the grating's count of 0.625 um
  (section III). The paper gives no resolution for the photo-electric encoder of the original servo. One micrometre,
  10,000 counts on a screw of 10 mm lead, is our assumption.
- **On the motor**: ``screw_encoder`` reads the nominal position of the nut (:obj:`leadscrew.plants.lathe_screw`)
  without lag: what the screw adds between nut and table (lead error, backlash, warmth) it cannot see.
- **Either end of an axis**: ``axis_encoder`` and ``axis_reading``, for plants that show both
  (:mod:`leadscrew.plants._backlash`, :obj:`leadscrew.plants.servo_axis`), in the unit in which they show it. On the
  motor the play is outside the loop and stays as a step; on the table it is inside, and the controller has to take it.
  ``axis_reading`` is for machines whose noise was measured.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit

Interpolated = Annotated[float, Unit("mm"), Gt(0), Doc("distance between two readings, after interpolation")]
Subdivided = Annotated[float, Unit("mm"), Gt(0), Doc("length of one count: pitch over subdivision")]
Assumed = Annotated[float, Unit("mm"), Gt(0), Doc("length of one count; assumed, not in the paper")]
Resolution = Annotated[float, Ge(0), Doc("one count, in the unit of the plant; 0 for none")]
OnTable = Annotated[bool, Doc("whether the table is read, not the motor")]
Noise = Annotated[float, Unit("mm"), Ge(0), Doc("standard deviation of the noise of one reading")]


def rounded(x, quantum):
    """``x`` to the nearest multiple of ``quantum``, halves up."""
    return quantum * math.floor(x / quantum + 0.5)


def counted(x, quantum):
    """``x`` in whole counts of ``quantum``; with 0 as it is."""
    return rounded(x, quantum) if quantum > 0.0 else x


def with_noise(x, deviation, noise):
    """``x`` plus this period's noise; ``x`` itself without."""
    return x + deviation * normal(noise, 0) if deviation > 0.0 else x


class RulerParams(NamedTuple):
    """A scale without noise."""

    resolution_mm: Interpolated = 0.000625


@sensor(RulerParams, unit="mm")
def ruler(p, actual):
    """The nearest mark."""
    return rounded(actual, p.resolution_mm)


class NoisyRulerParams(NamedTuple):
    """A scale with noise."""

    resolution_mm: Interpolated = 0.000625
    noise_mm: Noise = 0.0005


@sensor(NoisyRulerParams, unit="mm")
def noisy_ruler(p, actual, noise):
    """The mark nearest to the position plus its noise."""
    return rounded(with_noise(actual, p.noise_mm, noise), p.resolution_mm)


class GratingCountParams(NamedTuple):
    """The size of a count."""

    resolution_mm: Subdivided = 0.000625


@sensor(GratingCountParams, unit="mm")
def grating_count(p, actual):
    """The reading as a whole number of counts."""
    return rounded(actual.reading, p.resolution_mm)


class NoisyGratingParams(NamedTuple):
    """The size of a count, and the noise."""

    resolution_mm: Subdivided = 0.000625
    noise_mm: Noise = 0.0


@sensor(NoisyGratingParams, unit="mm")
def noisy_grating(p, actual, noise):
    """The lagged reading and its noise as a whole number of counts."""
    return rounded(with_noise(actual.reading, p.noise_mm, noise), p.resolution_mm)


class EncoderCountParams(NamedTuple):
    """The size of a count."""

    resolution_mm: Assumed = 0.001


@sensor(EncoderCountParams, unit="mm")
def encoder_count(p, actual):
    """The position as a whole number of counts."""
    return rounded(actual.position, p.resolution_mm)


class NoisyEncoderParams(NamedTuple):
    """The size of a count, and the noise."""

    resolution_mm: Assumed = 0.001
    noise_mm: Noise = 0.0


@sensor(NoisyEncoderParams, unit="mm")
def noisy_encoder(p, actual, noise):
    """The position and its noise as a whole number of counts."""
    return rounded(with_noise(actual.position, p.noise_mm, noise), p.resolution_mm)


class ScrewEncoderParams(NamedTuple):
    """The screw's lead and the counts of a turn."""

    lead_mm: Annotated[float, Unit("mm"), Gt(0), Doc("nominal travel per turn; assumed, not in the paper")] = 10.0
    counts_per_turn: Annotated[float, Gt(0), Doc("counts of a turn after evaluating all edges; assumed")] = 10_000.0


def count_of_a_screw(params: ScrewEncoderParams, dt: float) -> RulerParams:
    """The length of one count."""
    return RulerParams(params.lead_mm / params.counts_per_turn)


@sensor(ScrewEncoderParams, prepare=count_of_a_screw, unit="mm")
def screw_encoder(p, actual):
    """The nut's nominal position as a whole number of counts."""
    return rounded(actual.motor, p.resolution_mm)


class AxisEncoderParams(NamedTuple):
    """Where it sits, and its resolution."""

    on_table: OnTable = True
    resolution: Resolution = 1e-5


@sensor(AxisEncoderParams)
def axis_encoder(p, actual):
    """The nearest count of the table or of the motor."""
    return counted(actual.position if p.on_table else actual.motor, p.resolution)


class AxisReadingParams(NamedTuple):
    """Where it sits, its resolution and its noise."""

    on_table: OnTable = True
    resolution: Resolution = 1e-4
    noise: Annotated[float, Ge(0), Doc("standard deviation of a reading before it is rounded, same unit")] = 0.0


@sensor(AxisReadingParams)
def axis_reading(p, actual, noise):
    """The count nearest to the table, or the motor, plus its noise."""
    return counted(with_noise(actual.position if p.on_table else actual.motor, p.noise, noise), p.resolution)


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
