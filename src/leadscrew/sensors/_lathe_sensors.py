"""What the control of a retrofitted lathe sees: load cell with its filter, and three encoders.

    force   after the digital filter, raw before it                       as :obj:`leadscrew.sensors.load_cell`
    rpm_k = 60 (turns_k - turns_(k-1)) / dt                               from the counts of the spindle's encoder
    depth, travel: rounded to a count of their encoders; speed and depth with white noise of their own before that

``spindle_counts = 0``: no rounding, and the speed of the instant. With counts the speed is the mean over the last
control period in steps of ``60 / (counts dt)``: 4,096 counts and 20 ms give 0.73 1/min. In the first period, before
there is a difference, it is the speed of the instant.

Source: load cell and encoders of Figure 1 of the paper of the study ``grey_turning``, which gives no counts.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.sensors._counts import rounded
from leadscrew.sensors._load_cell import LoadCellParams, LoadCellState, counted, weighed


class LatheSensorsParams(NamedTuple):
    """Load cell and encoders."""

    cell: LoadCellParams = LoadCellParams()
    spindle_counts: Annotated[float, Ge(0), Doc("counts a revolution of the spindle; 0: speed of the instant")] = 0.0
    travel_count_mm: Annotated[float, Unit("mm"), Ge(0), Doc("a count of the carriage; 0: no rounding")] = 0.0
    depth_count_mm: Annotated[float, Unit("mm"), Ge(0), Doc("a count of the cross slide; 0: no rounding")] = 0.0
    rpm_noise: Annotated[float, Unit("1/min"), Ge(0), Doc("standard deviation of one reading of the speed")] = 0.0
    depth_noise_mm: Annotated[float, Unit("mm"), Ge(0), Doc("standard deviation of one reading of the depth")] = 0.0


class LatheSensorsState(NamedTuple):
    """The load cell's filter, and the spindle's count."""

    cell: LoadCellState = LoadCellState()
    turns: Annotated[float, Doc("revolutions at the last sample, as counted")] = 0.0
    begun: Annotated[float, Doc("1 after the first sample")] = 0.0


class LatheReading(NamedTuple):
    """What the control sees."""

    rpm: float = 0.0
    """Spindle speed, 1/min."""
    force: float = 0.0
    """Main cutting force after the filter, N."""
    depth: float = 0.0
    """Depth of the tool below the nominal surface, mm."""
    raw: float = 0.0
    """Force before the filter, N."""
    travel: float = 0.0
    """Way of the carriage, mm."""
    turns: float = 0.0
    """Revolutions of the spindle."""


@sensor(LatheSensorsParams, LatheSensorsState)
def lathe_sensors(p, s, actual, dt, noise):
    """Speed, force and depth, with what the force controllers may need besides."""
    cell = weighed(p.cell, s.cell, actual.force, noise)
    has_counts = p.spindle_counts > 0.0
    turn = 1.0 / max(p.spindle_counts, 1e-300)
    turns = rounded(actual.turns, turn) if has_counts else actual.turns
    rpm = 60.0 * (turns - s.turns) / dt if has_counts and s.begun > 0.5 else actual.rpm
    depth = counted(actual.depth + p.depth_noise_mm * normal(noise, 2), p.depth_count_mm)
    reading = LatheReading(
        rpm + p.rpm_noise * normal(noise, 1), cell.force, depth, cell.raw, counted(actual.travel, p.travel_count_mm),
        turns,
    )  # fmt: skip
    return LatheSensorsState(cell, turns, 1.0), reading
