"""The motor's data against hand calculation and against the plant that uses them."""

import numpy as np
import pytest

from leadscrew.plants._lathe_servo_limited import LatheLimitedParams, chain_matrices
from leadscrew.plants._motor_data import MOTOR_CONTINUOUS, MOTOR_PEAK, SPEED_GAIN, SUPPLY, TOP_SPEED, motor_constants


def test_peak_and_continuous_data_give_the_same_motor():
    assert MOTOR_PEAK.resistance_ohm == MOTOR_CONTINUOUS.resistance_ohm == 6.4
    assert MOTOR_PEAK.torque_constant == pytest.approx(MOTOR_CONTINUOUS.torque_constant, rel=1e-12)
    assert MOTOR_PEAK.torque_constant == pytest.approx(3.0667, abs=1e-4)
    assert (MOTOR_PEAK.heat_w, MOTOR_CONTINUOUS.heat_w) == (360.0, 90.0)


def test_what_follows_is_what_a_pocket_calculator_says():
    found = motor_constants()
    assert found.speed_constant == pytest.approx(0.3261, abs=1e-4)
    assert found.stall_current_a == 4.6875 and found.stall_torque_nm == pytest.approx(14.375)
    assert found.held_duty == pytest.approx(0.8)
    assert found.top_turning_speed == pytest.approx(7.8)
    assert found.inductance_h == pytest.approx(6.4 * 0.0015 * 0.017 / 0.0185)
    assert found.inertia_kg_m2 == pytest.approx(0.0185 * 3.0667**2 / 6.4, rel=1e-4)


def test_the_plant_has_the_motors_limits_and_the_lags_of_3():
    params = LatheLimitedParams()
    assert (params.supply_v, params.current_limit_a) == (SUPPLY.value, MOTOR_PEAK.current.value)
    assert (params.resistance_ohm, params.top_speed_mm_s) == (MOTOR_PEAK.resistance_ohm, TOP_SPEED.value)
    a, _ = chain_matrices(params)
    rates = np.sort(np.linalg.eigvals(a[:3, :3]).real)
    assert rates == pytest.approx([-1 / 0.0008, -1 / 0.0015, -1 / 0.017], rel=1e-9)


def test_every_number_says_where_it_is_from():
    for datum in (*MOTOR_PEAK, *MOTOR_CONTINUOUS, SUPPLY, SPEED_GAIN, TOP_SPEED):
        assert datum.value > 0 and datum.unit and datum.source
