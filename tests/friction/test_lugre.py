"""LuGre friction against SciPy's solution of its equation and against hand formulas."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from leadscrew.friction.lugre import (
    HAT,
    LuGre,
    bristle_after,
    bristle_rate,
    friction,
    level,
    level_slope,
    rate_by_bristle,
    rate_by_speed,
    steady_bristle,
    steady_friction,
)
from leadscrew.friction.observer import held_friction

TRUE = LuGre()


def test_friction_falls_from_static_to_coulomb_with_speed():
    assert level(TRUE, 0.0) == 9.36 and level(TRUE, 1e3) == 6.24
    assert level(TRUE, 1e-3) == pytest.approx(6.24 + 3.12 / math.e)
    assert steady_friction(TRUE, -2.0) == pytest.approx(6.24 + 0.8)
    assert steady_bristle(TRUE, 1.0) == 6.24e-5 and steady_bristle(TRUE, -1.0) == -6.24e-5
    assert steady_bristle(TRUE, 0.0) == 0.0


def test_in_steady_sliding_the_bristles_rest_and_the_force_is_the_curve():
    for v in (-3.0, -1e-3, 2e-4, 0.5):
        z = steady_bristle(TRUE, v)
        assert bristle_rate(TRUE, v, z) == pytest.approx(0.0, abs=1e-12)
        assert friction(TRUE, v, z, 0.0) == pytest.approx(math.copysign(steady_friction(TRUE, v), v), rel=1e-12)


@pytest.mark.parametrize("v", [-4.0, -2e-3, -1e-7, 0.0, 3e-5, 0.8])
def test_the_bristles_at_constant_speed_follow_the_equation(v):
    def rate(_, z):
        return [bristle_rate(HAT, v, z[0])]

    for dt in (1e-5, 2.5e-4, 0.05):
        exact = solve_ivp(rate, (0.0, dt), [2e-5], method="Radau", rtol=1e-11, atol=1e-16).y[0, -1]
        assert bristle_after(HAT, v, 2e-5, dt) == pytest.approx(exact, rel=1e-7, abs=1e-13)


@pytest.mark.parametrize("v", [-0.7, -1e-3, -3e-4, 4e-4, 2e-3, 0.1])
def test_the_partial_derivatives_are_those_of_finite_differences(v):
    z, h = 3e-5, 1e-6 * abs(v)
    assert level_slope(TRUE, v) == pytest.approx(
        (level(TRUE, v + h) - level(TRUE, v - h)) / (2 * h), rel=1e-6, abs=1e-6
    )
    slope = (bristle_rate(TRUE, v + h, z) - bristle_rate(TRUE, v - h, z)) / (2 * h)
    assert rate_by_speed(TRUE, v, z) == pytest.approx(slope, rel=1e-6)
    by_bristle = (bristle_rate(TRUE, v, z + 1e-7) - bristle_rate(TRUE, v, z - 1e-7)) / 2e-7
    assert rate_by_bristle(TRUE, v) == pytest.approx(by_bristle, rel=1e-6)


@pytest.mark.parametrize(("v", "a"), [(-0.003, 24.0), (0.002, -5.0), (1.0, 3.0), (-1e-4, 0.05)])
def test_the_held_friction_is_the_mean_of_the_models_force_over_the_period(v, a):
    dt, z0 = 2.5e-4, steady_bristle(HAT, v)

    def rate(t, z):
        return [bristle_rate(HAT, v + a * t, z[0])]

    exact = solve_ivp(rate, (0.0, dt), [z0], method="Radau", rtol=1e-10, atol=1e-15, dense_output=True)
    z = lambda t: exact.sol(t)[0]  # noqa: E731
    mean = quad(lambda t: friction(HAT, v + a * t, z(t), rate(t, [z(t)])[0]), 0.0, dt, limit=200, epsabs=1e-12)[0] / dt
    held = held_friction(HAT, z0, v, a, 1.0, 200, dt)
    assert held.bristle == pytest.approx(z(dt), rel=2e-4, abs=1e-10)
    assert held.torque == pytest.approx(mean, rel=1e-3)
    assert held_friction(HAT, z0, v, a, 1.0, 20, dt).torque == pytest.approx(mean, rel=0.02)


def test_without_pieces_the_friction_is_the_one_at_the_sample():
    z, v = 1e-5, 0.02
    at_once = friction(HAT, v, z, bristle_rate(HAT, v, z))
    assert held_friction(HAT, z, v, 9.0, 1.0, 0, 1e-3).torque == at_once
    undamped = at_once - HAT.damping * bristle_rate(HAT, v, z)
    assert held_friction(HAT, z, v, 9.0, 0.0, 0, 1e-3).torque == pytest.approx(undamped, rel=1e-12)


def test_bristles_stay_inside_the_level_at_any_speed_and_period():
    for v in np.geomspace(1e-9, 1e4, 14):
        assert abs(bristle_after(TRUE, v, -9.36e-5, 1.0)) <= 9.36e-5
        assert math.isfinite(held_friction(TRUE, 0.0, v, -v, 1.0, 3, 1e-3).torque)
