"""The two signals of a grating reader, their errors, and the error of position that follows.

With ``phi = 2 pi x / P`` for the position ``x`` and the pitch ``P``, and with ``u`` of unit amplitude,

    u = a + sin(phi) + h sin(3 phi) + n_u
    v = b + (1 + g) cos(phi + d) + h cos(3 phi) + n_v

``a``, ``b`` offsets, ``g`` gain error, ``d`` phase error, ``h`` third harmonic, ``n`` white noise. An interpolator
takes ``atan2(u, v)`` for ``phi``. To first order it is then wrong by

    dx = P / (2 pi) [a cos(phi) - b sin(phi) - (g/2) sin(2 phi) + (d/2) (1 - cos(2 phi)) + h sin(2 phi)]

Heydemann's correction puts ``(u - a', (v - b')/(1 + g'))`` on a circle and takes the skew ``d'`` out of it.

:class:`SignalPlan` and :func:`signals` are the same equations for the step of a block.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused

Floats = NDArray[np.float64]
TWO_PI = 6.283185307179586

Pitch = Annotated[float, Unit("mm"), Gt(0), Doc("length of one pair of lines; 100 pairs a millimetre, section III")]
Offset = Annotated[float, Ge(-0.5), Le(0.5), Doc("offset of the signal, in amplitudes of u")]
Gain = Annotated[float, Ge(-0.5), Le(0.5), Doc("amplitude of v over that of u, less 1")]
Phase = Annotated[float, Unit("rad"), Ge(-1), Le(1), Doc("how far v is ahead of 90 degrees before u")]
Harmonic = Annotated[float, Ge(-0.2), Le(0.2), Doc("third harmonic of both signals, in amplitudes of u")]


class SignalErrors(NamedTuple):
    """What is wrong with the two signals; all zero is a perfect reader."""

    offset_u: Offset = 0.0
    offset_v: Offset = 0.0
    gain: Gain = 0.0
    phase: Phase = 0.0
    harmonic: Harmonic = 0.0


PERFECT = SignalErrors()


class SignalPlan(NamedTuple):
    """The errors and the correction, made ready for :func:`signals`."""

    offset_u: float
    offset_v: float
    size_v: float
    phase_sine: float
    phase_cosine: float
    harmonic: float
    correct_u: float
    correct_v: float
    correct_size: float
    """1 over the corrected relative amplitude of v."""
    skew: float
    """Tangent of the corrected phase."""
    stretch: float
    """1 over its cosine."""


def plan_signals(errors: SignalErrors, correction: SignalErrors, where: str) -> SignalPlan:
    """What the step needs of errors and correction.

    Raises:
        ValueRefused: the signals do not surely go round zero, so that counts would be lost every pitch. Sure is: the
            distance of the ellipse's centre from zero, and the harmonic, together stay below its smaller half axis.
    """
    tangent, secant = math.tan(correction.phase), 1.0 / math.cos(correction.phase)
    size = 1.0 / (1.0 + correction.gain)
    phase_sine, phase_cosine = math.sin(errors.phase), math.cos(errors.phase)
    # corrected v = p sin(phi) + q cos(phi) + offset, corrected u = sin(phi) + offset
    q = (1.0 + errors.gain) * phase_cosine * size * secant
    p = tangent - (1.0 + errors.gain) * phase_sine * size * secant
    smaller = _smaller_axis(1.0, 0.0, p, q)
    larger_turn = abs(size * secant) / _smaller_axis(1.0, 0.0, tangent, size * secant)
    u0 = errors.offset_u - correction.offset_u
    away = math.hypot(u0, (errors.offset_v - correction.offset_v) * size * secant + u0 * tangent)
    if not away + abs(errors.harmonic) * larger_turn < smaller:
        raise ValueRefused(
            f"{where}: offsets and harmonic of {away + abs(errors.harmonic) * larger_turn:.3g} reach the smaller half "
            f"axis of the signals, {smaller:.3g}: they must stay below it, or the signals do not go round zero and "
            "counts are lost"
        )
    return SignalPlan(
        errors.offset_u, errors.offset_v, 1.0 + errors.gain, phase_sine, phase_cosine, errors.harmonic,
        correction.offset_u, correction.offset_v, size, tangent, secant,
    )  # fmt: skip


def plan_of(params, where: str) -> SignalPlan:
    """What the step needs of a block's parameters.

    Raises:
        ValueRefused: as :func:`plan_signals`.
    """
    errors = SignalErrors(params.offset_u, params.offset_v, params.gain, params.phase, params.harmonic)
    correction = SignalErrors(
        params.correct_offset_u, params.correct_offset_v, params.correct_gain, params.correct_phase
    )
    return plan_signals(errors, correction, where)


def _smaller_axis(a: float, b: float, c: float, d: float) -> float:
    """The smaller singular value of [[a, b], [c, d]]."""
    total, product = a * a + b * b + c * c + d * d, abs(a * d - b * c)
    larger = math.sqrt(0.5 * (total + math.sqrt(max(0.0, total * total - 4.0 * product * product))))
    return product / larger


class Pair(NamedTuple):
    """The two signals."""

    u: float
    v: float


def signals(p, sine, cosine, noise_u, noise_v):
    """The corrected pair of signals at an angle, from its sine and cosine; ``p`` is a :class:`SignalPlan`."""
    third_sine = sine * (3.0 - 4.0 * sine * sine)
    third_cosine = cosine * (4.0 * cosine * cosine - 3.0)
    shifted = cosine * p.phase_cosine - sine * p.phase_sine
    u = (p.offset_u + sine + p.harmonic * third_sine + noise_u) - p.correct_u
    v = (p.offset_v + p.size_v * shifted + p.harmonic * third_cosine + noise_v) - p.correct_v
    return Pair(u, p.correct_size * v * p.stretch + p.skew * u)


def angle_of(position_mm: ArrayLike, pitch_mm: float = 0.01) -> Floats:
    """``phi`` in rad, reduced to one turn before it is multiplied: exact far from zero too."""
    turns = np.asarray(position_mm, dtype=np.float64) / pitch_mm
    return TWO_PI * (turns - np.floor(turns + 0.5))


def quadrature(
    position_mm: ArrayLike,
    pitch_mm: float = 0.01,
    errors: SignalErrors = PERFECT,
    noise: float = 0.0,
    seed: int = 0,
) -> tuple[Floats, Floats]:
    """The signals ``u`` and ``v`` at each position, shapes as given; ``noise`` is a deviation in amplitudes of u."""
    phi = angle_of(position_mm, pitch_mm)
    u = errors.offset_u + np.sin(phi) + errors.harmonic * np.sin(3.0 * phi)
    v = errors.offset_v + (1.0 + errors.gain) * np.cos(phi + errors.phase) + errors.harmonic * np.cos(3.0 * phi)
    if noise > 0.0:
        rng = np.random.default_rng(seed)
        u, v = u + noise * rng.standard_normal(phi.shape), v + noise * rng.standard_normal(phi.shape)
    return u, v


def interpolation_error(position_mm: ArrayLike, u: ArrayLike, v: ArrayLike, pitch_mm: float = 0.01) -> Floats:
    """What an interpolator reads from the signals, less the true position, in mm; at most half a pitch.

    ``P / (2 pi)`` times the angle by which ``(v, u)`` is ahead of ``phi``.
    """
    phi = angle_of(position_mm, pitch_mm)
    sine, cosine, u, v = np.sin(phi), np.cos(phi), np.asarray(u), np.asarray(v)
    ahead: Floats = np.arctan2(u * cosine - v * sine, v * cosine + u * sine)
    return pitch_mm / TWO_PI * ahead


def first_order_error(position_mm: ArrayLike, pitch_mm: float = 0.01, errors: SignalErrors = PERFECT) -> Floats:
    """The first-order formula for :func:`interpolation_error`, in mm."""
    phi = angle_of(position_mm, pitch_mm)
    once = errors.offset_u * np.cos(phi) - errors.offset_v * np.sin(phi)
    twice = (errors.harmonic - 0.5 * errors.gain) * np.sin(2.0 * phi) + 0.5 * errors.phase * (1.0 - np.cos(2.0 * phi))
    error: Floats = pitch_mm / TWO_PI * (once + twice)
    return error
