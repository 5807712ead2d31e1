"""A grating ruler in one go: the count of the reading with the errors that its two signals give it.

    x        = (1 + scale_error) reading
    error    = P / (2 pi) (atan2(u, v) - phi) + a1 sin(phi + phase) + a2 sin(2 phi + phase) + noise
    feedback = q floor((x + error) / q + 1/2),    q = P / subdivision,  phi = 2 pi x / P

``u`` and ``v`` are the signals of ``quadrature``, with Heydemann's correction where it is set. They may have any error
that still lets them go round zero: then ``|atan2(u, v) - phi|`` stays below half a turn, no count depends on the one
before, and the counts are those of ``grating_counter`` fed finely enough. ``a1``, ``a2`` stand for what an interpolator
leaves over where its signals are not known; ``noise`` is that of the position, ``P / (2 pi)`` times that of a signal.

All errors are zero unless set, and then it is ``grating_count`` bit for bit.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.sensors.grating._quadrature import (
    TWO_PI,
    Gain,
    Harmonic,
    Offset,
    Phase,
    Pitch,
    SignalPlan,
    plan_of,
    signals,
)

Once = Annotated[float, Unit("mm"), Ge(0), Doc("error left by the interpolator, amplitude of one period a pitch")]
Twice = Annotated[float, Unit("mm"), Ge(0), Doc("error left by the interpolator, amplitude of two periods a pitch")]
Turn = Annotated[float, Unit("rad"), Doc("phase of both errors left by the interpolator")]
Noise = Annotated[float, Unit("mm"), Ge(0), Doc("deviation of the white noise of the position, before the rounding")]
Scale = Annotated[float, Gt(-1), Le(1), Doc("relative error of the ruler's own length; 1e-6 is 1 um a metre")]


class GratingRulerParams(NamedTuple):
    """Pitch and subdivision, errors of the signals and their correction, and errors beyond the signals."""

    pitch_mm: Pitch = 0.01
    subdivision: Annotated[int, Ge(1), Le(65536), Doc("counts a pitch; 16 in section III")] = 16
    offset_u: Offset = 0.0
    offset_v: Offset = 0.0
    gain: Gain = 0.0
    phase: Phase = 0.0
    harmonic: Harmonic = 0.0
    correct_offset_u: Offset = 0.0
    correct_offset_v: Offset = 0.0
    correct_gain: Gain = 0.0
    correct_phase: Phase = 0.0
    interpolation_1_mm: Once = 0.0
    interpolation_2_mm: Twice = 0.0
    interpolation_phase: Turn = 0.0
    noise_mm: Noise = 0.0
    scale_error: Scale = 0.0


class RulerPlan(NamedTuple):
    """What the step needs; lengths beside the pitch are in counts."""

    pitch: float
    resolution: float
    scale: float
    counts_per_rad: float
    signals: SignalPlan
    once: float
    twice: float
    turn_sine: float
    turn_cosine: float
    noise: float


def plan_ruler(params: GratingRulerParams, dt: float) -> RulerPlan:
    """Signals made ready and lengths turned into counts.

    Raises:
        ValueRefused: the signals do not surely go round zero.
    """
    resolution = params.pitch_mm / params.subdivision
    return RulerPlan(
        params.pitch_mm, resolution, 1.0 + params.scale_error, params.subdivision / TWO_PI,
        plan_of(params, "grating_ruler"), params.interpolation_1_mm / resolution,
        params.interpolation_2_mm / resolution, math.sin(params.interpolation_phase),
        math.cos(params.interpolation_phase), params.noise_mm / resolution,
    )  # fmt: skip


@sensor(GratingRulerParams, prepare=plan_ruler, unit="mm")
def grating_ruler(p, actual, noise):
    """The reading as a whole number of counts, errors included."""
    shown = p.scale * actual.reading
    turns = shown / p.pitch
    angle = TWO_PI * (turns - math.floor(turns + 0.5))
    sine = math.sin(angle)
    cosine = math.cos(angle)
    pair = signals(p.signals, sine, cosine, 0.0, 0.0)
    ahead = math.atan2(pair.u * cosine - pair.v * sine, pair.v * cosine + pair.u * sine)
    once = sine * p.turn_cosine + cosine * p.turn_sine
    twice = 2.0 * sine * cosine * p.turn_cosine + (cosine * cosine - sine * sine) * p.turn_sine
    error = p.counts_per_rad * ahead + p.once * once + p.twice * twice + p.noise * normal(noise, 0)
    return p.resolution * math.floor(shown / p.resolution + error + 0.5)
