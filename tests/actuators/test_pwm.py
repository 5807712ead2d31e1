"""The PWM timer: whole counts, the shortest pulse, the sign of the direction, and the mean voltage of (7)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.actuators._pwm import mean_voltage, pwm
from leadscrew.util.errors import ValueRefused


def given_out(outputs, **changes):
    block = pwm(**changes)
    s, applied = block.state, []
    for output in outputs:
        s, rho = block.step(block.params, s, output)
        applied.append(rho)
    return applied


@given(st.floats(-2, 2), st.integers(1, 5000))
def test_the_duty_is_the_nearest_whole_count_of_the_period(output, counts):
    (rho,) = given_out([output], counts=counts)
    wanted = max(-1.0, min(1.0, output))
    assert rho * counts == pytest.approx(round(rho * counts), abs=1e-9)
    assert abs(rho - wanted) <= 0.5 / counts * (1 + 1e-9)


def test_both_directions_are_rounded_alike_and_half_a_count_is_a_count():
    assert given_out([0.0005, -0.0005, 0.00049, -0.00049]) == [0.001, -0.001, 0.0, 0.0]
    assert math.copysign(1.0, given_out([-0.0001])[0]) == 1.0


def test_a_pulse_shorter_than_the_bridge_can_make_is_left_out():
    assert given_out([0.0044, 0.0046, -0.0044, -0.0046], minimum_on_counts=5) == [0.0, 0.005, 0.0, -0.005]


def test_full_duty_is_the_most_there_is():
    assert given_out([1.7, -3.0]) == [1.0, -1.0]


@pytest.mark.parametrize("minimum", [0, 1, 5])
@pytest.mark.parametrize("duty", [0.00017, -0.00273, 0.4321])
def test_with_carry_the_mean_duty_is_right_at_any_size(duty, minimum):
    applied = given_out([duty] * 20_000, carry=True, minimum_on_counts=minimum)
    assert np.mean(applied) == pytest.approx(duty, abs=max(minimum, 1) * 1e-3 / 20_000)
    assert set(np.round(1000 * np.array(applied)).astype(int)) != {0}


def test_carry_does_not_wind_up_at_full_duty():
    assert given_out([*[5.0] * 50, 0.0], carry=True)[-1] == 0.0


def test_the_mean_voltage_is_duty_times_supply_with_its_sign():
    """(7) with the 30 V of (2): a quarter of the period on, backwards."""
    assert mean_voltage(-0.25) == -7.5 and mean_voltage(0.5, supply_v=48.0) == 24.0


def test_a_timer_without_counts_is_refused():
    with pytest.raises(ValueRefused, match="counts"):
        pwm(counts=0)
