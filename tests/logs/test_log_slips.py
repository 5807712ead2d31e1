"""Stick-slip is not an encoder that jumps: slips begin and end at rest, with a drive that had been rising."""

import re

import numpy as np
import pytest

from leadscrew.logs import axis_log
from leadscrew.util.errors import DataError

STICKS = 0.1
"""Seconds from slip to slip."""


def stick_slip(period, counts=1e-7, lasts=4e-4, leap=2e-4, seconds=1.0):
    """A move with its reversal, then slips: rests while the drive rises by 20 N, and a leap within 2 ms as it falls."""
    time = np.arange(round(2.0 * seconds / period)) * period
    moving = time < seconds
    phase = np.mod(time - seconds + 1e-9, STICKS)
    number = np.floor((time - seconds + 1e-9) / STICKS)
    slid = 1.0 - np.exp(-phase / lasts)
    slipped = leap * (number - 1.0 + slid) * (number >= 1.0)
    position = np.where(moving, 0.02 * (1.0 - np.cos(2.0 * np.pi * time / seconds)), slipped)
    speed = np.gradient(position, period)
    drive = np.where(moving, 20.0 * np.gradient(speed, period) + 15.0 * np.sign(speed), 10.0 + 20.0 * phase / STICKS)
    return time, drive, np.round(position / counts) * counts


def found(time, drive, position):
    return {f.kind: f for f in axis_log(time, drive, position).findings}


@pytest.mark.parametrize("period", [2.5e-4, 5e-4, 1e-3])
def test_slips_are_read_and_said_with_how_to_tell(period):
    said = found(*stick_slip(period))["slip"]
    assert said.severity == "warning"
    assert re.search(r"jumps 9 times, by \+0\.000(2|19\d) m at .* \(it did before 9 of 9\)", said.sentence)


def test_a_scale_that_slips_while_the_axis_stands_under_an_even_drive_is_told_apart():
    time, drive, position = stick_slip(1e-3, leap=0.0)
    drive = np.where(time < 1.0, drive, 12.0)
    said = found(time, drive, np.where(time >= 1.5, position + 2e-4, position))["slip"]
    assert "once" in said.sentence and "(it did before 0 of 1)" in said.sentence
    assert "encoder lost counts" in said.sentence


def test_in_a_fast_log_a_leap_within_one_sample_is_no_slip():
    time, drive, position = stick_slip(2.5e-4, leap=0.0)
    with pytest.raises(DataError, match=r"jumps once, by \+0\.0002 m at sample 6001 .* speed before and after"):
        axis_log(time, drive, np.where(time >= 1.5, position + 2e-4, position))


@pytest.mark.parametrize("period", [2.5e-4, 1e-3])
def test_a_jump_in_motion_is_refused_beside_slips_and_the_slips_may_stay_in_the_part_that_is_proposed(period):
    time, drive, position = stick_slip(period)
    with pytest.raises(DataError, match=r"jumps once, by .* \(0\.25 s\).* --start 0\.25 --end 1\.99") as error:
        axis_log(time, drive, np.where(time >= 0.25, position + 2e-3, position))
    assert "stand-still" not in str(error.value)


def test_one_bad_sample_at_rest_is_a_fault_and_no_slip():
    time, drive, position = stick_slip(1e-3)
    position[1550] += 2e-4
    with pytest.raises(DataError, match=r"jumps once, .* at sample 1551 \(1\.55 s, back in the next\)"):
        axis_log(time, drive, position)
