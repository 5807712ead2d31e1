"""A grating counter sample by sample: signals, comparators, code, direction, reversible counter (16 counts a pitch).

It counts what the plant shows as ``reading``; equations in ``quadrature`` and ``counting``. Like the real one it only
adds up changes: it starts from ``counts`` and ``sector``, and is 16 counts off after every period that moves the
reading by more than 7. At 0.625 um a count and 1 ms that is a speed of 4.4 mm/s, at the lathe's 258.7 mm/s it takes a
period of 16.9 us (``counting.fastest``, ``counting.longest_period``). Loops of 1 ms take ``grating_ruler``, which gives
the same counts without counting.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Le
from leadscrew.sensors.grating._counting import COMPARE_U, COMPARE_V
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

Noise = Annotated[float, Ge(0), Le(0.2), Doc("deviation of the white noise of each signal, in amplitudes of u")]


class GratingCounterParams(NamedTuple):
    """Pitch, errors of the signals, and Heydemann's correction of them; without errors unless set."""

    pitch_mm: Pitch = 0.01
    offset_u: Offset = 0.0
    offset_v: Offset = 0.0
    gain: Gain = 0.0
    phase: Phase = 0.0
    harmonic: Harmonic = 0.0
    noise: Noise = 0.0
    correct_offset_u: Offset = 0.0
    correct_offset_v: Offset = 0.0
    correct_gain: Gain = 0.0
    correct_phase: Phase = 0.0


class GratingCounterState(NamedTuple):
    """The reversible counter and the sector of the last sample."""

    counts: Annotated[int, Doc("counts since the start")] = 0
    sector: Annotated[int, Ge(0), Le(15), Doc("sixteenth of a pitch of the last sample")] = 0


class CounterPlan(NamedTuple):
    """What the step needs."""

    pitch: float
    resolution: float
    noise: float
    signals: SignalPlan


def plan_counter(params: GratingCounterParams, dt: float) -> CounterPlan:
    """Signals made ready.

    Raises:
        ValueRefused: the signals do not surely go round zero.
    """
    return CounterPlan(params.pitch_mm, params.pitch_mm / 16.0, params.noise, plan_of(params, "grating_counter"))


def sector_of(u, v):
    """The sector 0 ... 15 that the eight comparators' code stands for."""
    ones = 0
    for i in range(8):
        ones += 1 if u * COMPARE_U[i] - v * COMPARE_V[i] >= 0.0 else 0
    return ones if u * COMPARE_U[0] - v * COMPARE_V[0] >= 0.0 else (16 - ones) & 15


@sensor(GratingCounterParams, GratingCounterState, prepare=plan_counter, unit="mm")
def grating_counter(p, s, actual, noise):
    """The counter after one more sample, as a length."""
    turns = actual.reading / p.pitch
    angle = TWO_PI * (turns - math.floor(turns + 0.5))
    pair = signals(p.signals, math.sin(angle), math.cos(angle), p.noise * normal(noise, 0), p.noise * normal(noise, 1))
    sector = sector_of(pair.u, pair.v)
    counts = s.counts + ((sector - s.sector + 8) & 15) - 8
    return GratingCounterState(counts, sector), p.resolution * counts
