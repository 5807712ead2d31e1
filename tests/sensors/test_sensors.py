"""Sensors, actuators and disturbances against their equations."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.actuators._limits import limits
from leadscrew.actuators._saturation import saturation
from leadscrew.disturbances._pulse_load import pulse_load
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.disturbances._step_load import step_load
from leadscrew.disturbances._white_noise import white_noise
from leadscrew.kernel.noise import Noise
from leadscrew.sensors._counts import noisy_ruler, ruler
from leadscrew.sensors._ideal import ideal
from leadscrew.sensors._lag import lag
from leadscrew.util.errors import ValueRefused


@given(st.floats(-1000, 1000))
def test_ruler_reads_the_nearest_mark(actual):
    reading = ruler.step(ruler.params, actual)
    assert abs(reading - actual) <= 0.5 * 0.000625 * (1 + 1e-6)
    assert reading / 0.000625 == pytest.approx(round(reading / 0.000625), abs=1e-6)


def test_ruler_rounds_halves_up_and_zero_to_zero():
    block = ruler(resolution_mm=0.5)
    assert [block.step(block.params, x) for x in (0.0, 0.25, -0.25, 0.24, -0.26)] == [0.0, 0.5, 0.0, 0.0, -0.5]
    with pytest.raises(ValueRefused, match="resolution_mm"):
        ruler(resolution_mm=0.0)


def test_ideal_shows_what_is():
    assert ideal.step(0.123) == 0.123


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
def test_lag_is_exact_for_a_step_at_any_period(dt):
    block = lag(time_constant=0.004)
    p, s = block.prepare(block.params, dt), block.state
    for k in range(1, 40):
        s, feedback = block.step(p, s, 1.0)
        assert feedback == pytest.approx(1 - math.exp(-k * dt / 0.004), rel=1e-12)


def test_lag_of_nothing_is_ideal_and_its_tail_ends():
    block = lag(time_constant=0.0)
    assert block.step(block.prepare(block.params, 1e-3), block.state, 0.7)[1] == 0.7
    block = lag(time_constant=1e-3).starting(reading=1.0)
    p, s = block.prepare(block.params, 1e-3), block.state
    for _ in range(600):
        s, _ = block.step(p, s, 0.0)
    assert s.reading == 0.0


def test_saturation_cuts_both_ends():
    block = saturation(lower=-2.0, upper=3.0)
    p = block.prepare(block.params, 1e-3)
    assert [block.step(p, x) for x in (-9.0, -1.0, 9.0)] == [-2.0, -1.0, 3.0]


@given(st.lists(st.floats(-100, 100), max_size=30))
def test_limits_keep_size_and_rate(outputs):
    block = limits(lower=-5.0, upper=8.0, rate=1000.0)
    p, s = block.prepare(block.params, 1e-3), block.state
    before = 0.0
    for output in outputs:
        s, value = block.step(p, s, output)
        assert -5.0 <= value <= 8.0 and abs(value - before) <= 1.0 + 1e-12
        if abs(output - before) <= 1.0 and -5.0 <= output <= 8.0:
            assert value == pytest.approx(output, abs=1e-12)
        before = value


@pytest.mark.parametrize("block", [limits, saturation])
def test_limits_in_the_wrong_order_are_refused(block):
    wrong = block(lower=5.0, upper=-5.0)
    with pytest.raises(ValueRefused, match="must not lie above"):
        wrong.prepare(wrong.params, 1e-3)


def test_loads_come_and_go_at_the_nearest_sample():
    load = step_load(size=4.0, time=0.3)
    assert [load.step(load.params, k * 0.1, 0.1) for k in range(5)] == [0, 0, 0, 4.0, 4.0]
    load = pulse_load(size=4.0, start=0.3, duration=0.4)
    assert [load.step(load.params, k * 0.1, 0.1) for k in range(10)] == [0, 0, 0, 4, 4, 4, 4, 0, 0, 0]
    load = sine_load(amplitude=2.0, frequency=5.0, phase=math.pi / 2, offset=1.0)
    assert load.step(load.params, 0.1) == pytest.approx(-1.0)


def test_noise_has_the_deviation_asked_for_and_the_ruler_rounds_it():
    periods = [Noise(seed=3, run=0, block=1, period=k) for k in range(4000)]
    load = white_noise(deviation=2.0, mean=5.0)
    values = np.array([load.step(load.params, noise) for noise in periods])
    assert values.mean() == pytest.approx(5.0, abs=4 * 2.0 / math.sqrt(4000))
    assert values.std() == pytest.approx(2.0, rel=0.05)
    assert abs(np.corrcoef(values[1:], values[:-1])[0, 1]) < 4 / math.sqrt(4000)
    block = noisy_ruler(resolution_mm=0.001, noise_mm=0.003)
    readings = np.array([block.step(block.params, 0.5, noise) for noise in periods])
    assert readings.mean() == pytest.approx(0.5, abs=4 * 0.003 / math.sqrt(4000))
    assert readings.std() == pytest.approx(math.hypot(0.003, 0.001 / math.sqrt(12)), rel=0.05)
    np.testing.assert_allclose(readings * 1000, np.round(readings * 1000), atol=1e-9)
    quiet = noisy_ruler(noise_mm=0.0)
    assert quiet.step(quiet.params, 0.123, periods[0]) == ruler.step(ruler.params, 0.123)
