"""LuGre with values for each direction against the one-sided model and SciPy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.analysis.friction import friction_along, friction_velocity
from leadscrew.friction.asymmetric import LuGreSlide, TwoSidedLuGre, one_way_lugre
from leadscrew.friction.static_map import Sliding

FORWARD, BACKWARD = Sliding(1.0, 1.5, 0.001, 0.4), Sliding(0.7, 0.9, 0.003, 0.8)
UNEQUAL = TwoSidedLuGre(forward=FORWARD, backward=BACKWARD)


def test_steady_sliding_has_the_values_of_its_direction():
    for v in (1e-4, 1e-3, 0.3):
        assert friction_velocity(UNEQUAL, [v])[0] == pytest.approx(1.0 + 0.5 * math.exp(-((v / 0.001) ** 2)) + 0.4 * v)
        backward = -(0.7 + 0.2 * math.exp(-((v / 0.003) ** 2)) + 0.8 * v)
        assert friction_velocity(UNEQUAL, [-v])[0] == pytest.approx(backward)


def test_with_equal_sides_it_is_lugre():
    path = 1e-5 * np.sin(np.linspace(0.0, 12.0, 500))
    assert np.array_equal(friction_along(TwoSidedLuGre(), path, 1e-3), friction_along(LuGreSlide(), path, 1e-3))
    assert one_way_lugre(TwoSidedLuGre(), -1.0) == LuGreSlide()


@pytest.mark.slow
def test_reversing_it_follows_scipy_and_the_force_does_not_jump():
    w, a = 4.0, 3e-4

    def level(v):
        return 1.0 + 0.5 * math.exp(-((v / 0.001) ** 2)) if v >= 0.0 else 0.7 + 0.2 * math.exp(-((v / 0.003) ** 2))

    def rate(t, z):
        v = a * w * math.cos(w * t)
        return [v - abs(v) * z[0] * 1e5 / level(v)]

    t = np.linspace(0.0, 4.0, 40001)
    z = solve_ivp(rate, (0.0, 4.0), [0.0], method="Radau", rtol=1e-9, atol=1e-15, t_eval=t, max_step=0.01).y[0]
    forces = friction_along(UNEQUAL, a * np.sin(w * t), t[1])
    v = a * w * np.cos(w * t)
    viscous = np.where(v >= 0.0, 0.4, 0.8) * v
    rates = np.array([rate(*both)[0] for both in zip(t, z[:, None], strict=True)])
    expected = 1e5 * z + math.sqrt(1e5) * rates + viscous
    assert np.abs(forces - expected)[1:].max() < 0.01  # the path's speed is that of half a sample ago
    assert np.abs(np.diff(forces))[1:].max() < 0.02
    assert forces.max() > 1.3 and -0.95 < forces.min() < -0.8
