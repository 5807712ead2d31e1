"""Swept sines: ``offset + amplitude sin(phi(t))``, from one frequency to another, then on at the last one.

With ``f0`` and ``f1`` the frequencies at the ends and ``T`` the duration of the sweep, for ``t <= T``:

linear (``chirp``)
    ``f = f0 + (f1 - f0) t / T``,  ``phi = 2 pi (f0 t + (f1 - f0) t^2 / (2 T))``
logarithmic (``log_chirp``)
    ``f = f0 (f1/f0)^(t/T)``,  ``phi = 2 pi f0 (exp(g t) - 1) / g`` with ``g = ln(f1/f0) / T``

and ``phi(T) + 2 pi f1 (t - T)`` after it, so the phase is continuous. ``phi`` is the integral of ``2 pi f``; the same
definitions as ``scipy.signal.chirp``.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import reference
from leadscrew.kernel.parameters import Doc, Gt, Unit

TWO_PI = 2.0 * math.pi


class ChirpParams(NamedTuple):
    """A sweep in the unit of the loop's command."""

    amplitude: Annotated[float, Doc("half of peak to peak")] = 1.0
    start_frequency: Annotated[float, Unit("Hz"), Gt(0), Doc("frequency at t = 0")] = 1.0
    end_frequency: Annotated[float, Unit("Hz"), Gt(0), Doc("frequency at the end of the sweep and after")] = 100.0
    duration: Annotated[float, Unit("s"), Gt(0), Doc("length of the sweep")] = 10.0
    offset: Annotated[float, Doc("mean of the command")] = 0.0


@reference(ChirpParams)
def chirp(p, t):
    """Frequency linear in time."""
    swept = min(t, p.duration)
    half_slope = 0.5 * (p.end_frequency - p.start_frequency) / p.duration
    cycles = (p.start_frequency + half_slope * swept) * swept + p.end_frequency * max(t - p.duration, 0.0)
    return p.offset + p.amplitude * math.sin(TWO_PI * cycles)


class LogChirpPlan(NamedTuple):
    """What the step of ``log_chirp`` needs."""

    amplitude: float
    start_frequency: float
    end_frequency: float
    duration: float
    offset: float
    growth: float
    """ln(f1/f0) / T, in 1/s."""


def log_plan(params: ChirpParams, dt: float) -> LogChirpPlan:
    """The sweep with its growth worked out."""
    return LogChirpPlan(*params, math.log(params.end_frequency / params.start_frequency) / params.duration)


@reference(ChirpParams, prepare=log_plan)
def log_chirp(p, t):
    """The same number of seconds for every octave."""
    swept = min(t, p.duration)
    exponent = p.growth * swept
    # Two terms of the series where exp(x) - 1 would cancel.
    stretched = (math.exp(exponent) - 1.0) / p.growth if abs(exponent) > 1e-6 else swept * (1.0 + 0.5 * exponent)
    cycles = p.start_frequency * stretched + p.end_frequency * max(t - p.duration, 0.0)
    return p.offset + p.amplitude * math.sin(TWO_PI * cycles)
