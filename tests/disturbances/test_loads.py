"""Loads over time, worked by hand sample by sample at 10 ms."""

import math

import pytest

from leadscrew.disturbances._hard_spot import hard_spot
from leadscrew.disturbances._kicked_load import kicked_load
from leadscrew.disturbances._pulse_load import pulse_load
from leadscrew.disturbances._step_load import step_load

DT = 0.01


def over(block, samples):
    """The load of each sample; a step takes time and period, or the time alone."""
    period = (DT,) if "dt" in block.signals else ()
    return [block.step(block.params, k * DT, *period) for k in range(samples)]


@pytest.mark.parametrize(
    ("start", "duration", "on"),
    [(0.02, 0.03, range(2, 5)), (0.0, 0.01, range(1)), (0.024, 0.012, range(2, 4)), (0.026, 0.018, range(3, 4)),
     (0.02, 0.0, range(0))],
)  # fmt: skip
def test_a_pulse_lasts_from_the_sample_nearest_to_its_start_to_the_one_before_its_end(start, duration, on):
    load = over(pulse_load(size=3.0, start=start, duration=duration), 7)
    assert load == [3.0 if k in on else 0.0 for k in range(7)]


@pytest.mark.parametrize(("time", "first"), [(0.0, 0), (0.02, 2), (0.024, 2), (0.026, 3)])
def test_a_step_comes_with_the_sample_nearest_to_its_time(time, first):
    assert over(step_load(size=-2.0, time=time), 5) == [-2.0 if k >= first else 0.0 for k in range(5)]


def test_a_hard_spot_rises_stays_and_falls_by_its_times_as_the_middle_of_each_period_sees_it():
    """From 20 ms: 20 ms up, 20 ms there, 40 ms down; then one with edges."""
    load = over(hard_spot(size=2.0, start=0.02, rise_s=0.02, stay_s=0.02, fall_s=0.04), 12)
    assert load == pytest.approx([0, 0, 0.5, 1.5, 2, 2, 1.75, 1.25, 0.75, 0.25, 0, 0])
    assert over(hard_spot(size=2.0, start=0.02, rise_s=0.0, stay_s=0.02, fall_s=0.0), 6) == [0, 0, 2, 2, 0, 0]


def test_a_slow_load_rises_falls_back_as_fast_and_is_kicked_only_at_the_start():
    load = over(kicked_load(size=1.0, rate=100.0, turn_s=0.03, kick=0.5, kick_hz=25.0, kick_s=0.02), 8)
    assert load == pytest.approx([1.0, 2.0 + 0.5, 3.0, 4.0, 3.0, 2.0, 1.0, 1.0])
    assert over(kicked_load(kick=0.5, kick_hz=10.0, kick_s=1.0), 3)[2] == pytest.approx(0.5 * math.sin(0.4 * math.pi))
