"""Dahl's friction against SciPy's solution of its equation, and the hysteresis worked by hand."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.analysis.friction import friction_along, friction_velocity, path_through
from leadscrew.friction.dahl import Dahl, force_after, force_rate, force_slope

DRY = Dahl(viscous=0.0)


@pytest.mark.parametrize("exponent", [0.7, 1.0, 1.5, 2.0, 3.0])
@pytest.mark.parametrize(("travel", "force"), [(4e-6, 0.0), (3e-5, -0.9), (-2e-5, 0.5), (2e-6, 1.4), (-5e-6, -1.2)])
def test_the_closed_form_solves_the_equation(exponent, travel, force):
    f = Dahl(exponent=exponent)
    side = math.copysign(1.0, travel)
    exact = solve_ivp(
        lambda _, y: [side * force_slope(f, travel, y[0])], (0.0, abs(travel)), [force], method="RK45", rtol=1e-9,
        atol=1e-12, max_step=abs(travel) / 200,
    )  # fmt: skip
    assert force_after(f, travel, force) == pytest.approx(exact.y[0, -1], abs=1e-5)


def test_the_slope_is_stiffness_at_zero_force_twice_it_after_a_reversal_and_none_at_the_limit():
    assert (
        force_slope(DRY, 1.0, 0.0) == 1e5 and force_slope(DRY, -1.0, 1.0) == 2e5 and force_slope(DRY, 1.0, 1.0) == 0.0
    )
    assert force_slope(DRY, 1.0, 1.5) == -0.5e5  # above the limit it comes back
    assert force_rate(DRY, -0.2, 0.0) == -0.2e5 and force_rate(DRY, 0.0, 0.7) == 0.0


def test_the_hysteresis_loop_has_the_tip_and_the_area_of_the_closed_form():
    """Between -a and a, with q = sigma a / F_C: the tip is tanh(q), the area 4 F_C (a - tip / sigma)."""
    a = 1.5e-5
    forces = friction_along(DRY, path_through([0.0, a] + [-a, a] * 6, 1e-8), 1e-3)
    loop = slice(-6001, None)
    tip = math.tanh(1e5 * a)
    assert forces[-1] == pytest.approx(tip, rel=1e-9) and forces[-3001] == pytest.approx(-tip, rel=1e-9)
    x = path_through([a, -a, a], 1e-8)
    area = np.trapezoid(forces[loop], x)
    assert area == pytest.approx(4.0 * (a - tip / 1e5), rel=1e-5)


def test_the_force_depends_on_the_path_and_not_on_its_speed():
    path = path_through([0.0, 2e-5, 0.5e-5, 3e-5], 1e-7)
    assert np.allclose(friction_along(DRY, path, 1e-3), friction_along(DRY, path, 10.0), rtol=1e-12, atol=1e-15)


def test_there_is_no_static_friction_above_coulomb():
    forces = friction_along(DRY, path_through([0.0, 2e-4], 1e-7), 1e-3)
    assert forces.max() <= 1.0 and forces[-1] == pytest.approx(1.0, abs=1e-8)
    assert list(friction_velocity(Dahl(), [-1.0, 1e-9, 1.0])) == pytest.approx([-1.4, 1.0, 1.4])
