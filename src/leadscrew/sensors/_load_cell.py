"""The load cell under the tool with its digital filter, alone and with the encoders of spindle and carriage.

    raw_k = q floor((F + w_k) / q + 1/2),      y_k = keep y_(k-1) + (1 - keep) raw_k

``w`` is Gaussian and white, one value a control period; ``q`` the smallest force that the converter tells apart (0:
any). The filter passes a constant force unchanged, keeps ``sqrt((1 - keep) / (1 + keep))`` of white noise (a third at
0.8), and delays slow changes by ``keep / (1 - keep)`` samples (four).

Source: section 5 and Figure 5 of the paper of the study ``grey_turning`` (coefficient 0.8); noise and counts are ours.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Lt, Unit
from leadscrew.sensors._counts import counted, rounded

TINY = 1e-30
"""Below this a settled reading is 0: its tail would end in denormal numbers, which are slow."""

Noise = Annotated[float, Unit("N"), Ge(0), Doc("standard deviation of one reading before the filter")]
Keep = Annotated[float, Ge(0), Lt(1), Doc("coefficient of the filter, alpha; 0: none")]
Count = Annotated[float, Unit("N"), Ge(0), Doc("resolution of the force; 0: none")]


class LoadCellParams(NamedTuple):
    """Noise, resolution and filter."""

    noise_n: Noise = 2.0
    keep: Keep = 0.8
    count_n: Count = 0.0


class LoadCellState(NamedTuple):
    """The filtered force, and the last reading."""

    force: Annotated[float, Unit("N"), Doc("after the filter")] = 0.0
    raw: Annotated[float, Unit("N"), Doc("before it")] = 0.0


def weighed(p, s, force, noise):
    """The next reading of a force."""
    raw = counted(force + p.noise_n * normal(noise, 0), p.count_n)
    kept = p.keep * s.force + (1.0 - p.keep) * raw
    return LoadCellState(kept if abs(kept) > TINY else 0.0, raw)


@sensor(LoadCellParams, LoadCellState, unit="N")
def load_cell(p, s, actual, noise):
    """The main cutting force after the digital filter."""
    now = weighed(p, s, actual.force, noise)
    return now, now.force


class LatheReadingParams(NamedTuple):
    """Load cell and encoders."""

    noise_n: Noise = 2.0
    keep: Keep = 0.8
    count_n: Count = 0.0
    travel_count_mm: Annotated[float, Unit("mm"), Ge(0), Doc("resolution of the carriage's encoder; 0: none")] = 0.0
    turn_counts: Annotated[float, Ge(0), Doc("counts a revolution of the spindle's encoder; 0: no rounding")] = 0.0


class CutReading(NamedTuple):
    """What the control sees of the cut."""

    force: Annotated[float, Unit("N"), Doc("main cutting force after the filter")] = 0.0
    raw: Annotated[float, Unit("N"), Doc("the same before the filter")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("travel of the carriage")] = 0.0
    turns: Annotated[float, Unit("rev"), Doc("angle of the spindle")] = 0.0


@sensor(LatheReadingParams, LoadCellState)
def lathe_reading(p, s, actual, noise):
    """Filtered and raw force, carriage and spindle."""
    now = weighed(p, s, actual.force, noise)
    turn = 1.0 / max(p.turn_counts, 1e-300)
    turns = rounded(actual.turns, turn) if p.turn_counts > 0.0 else actual.turns
    return now, CutReading(now.force, now.raw, counted(actual.travel, p.travel_count_mm), turns)
