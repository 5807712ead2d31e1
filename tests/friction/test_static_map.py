"""Static friction maps against numbers worked by hand."""

import math

import pytest

from leadscrew.analysis.friction import friction_velocity
from leadscrew.friction.static_map import Sliding, TwoSided, resting_friction, sliding_friction, speed_after

UNEQUAL = TwoSided(Sliding(6.0, 9.0, 0.002, 10.0), Sliding(4.0, 5.0, 0.001, 30.0))
COULOMB = TwoSided(Sliding(2.0, 2.0, 1.0, 0.0), Sliding(2.0, 2.0, 1.0, 0.0))


def test_friction_falls_from_static_to_coulomb_and_then_rises_with_the_viscous_part():
    assert sliding_friction(UNEQUAL, 1e-12) == pytest.approx(9.0)
    assert sliding_friction(UNEQUAL, 0.002) == pytest.approx(6.0 + 3.0 / math.e + 0.02)
    assert sliding_friction(UNEQUAL, 0.5) == 6.0 + 5.0


def test_each_direction_has_its_own_values():
    assert sliding_friction(UNEQUAL, -1e-12) == pytest.approx(-5.0)
    assert sliding_friction(UNEQUAL, -0.001) == pytest.approx(-(4.0 + 1.0 / math.e + 0.03))
    assert list(friction_velocity(UNEQUAL, [-0.5, 0.0, 0.5])) == [-4.0 - 15.0, 0.0, 11.0]


def test_without_static_and_viscous_parts_it_is_coulomb_and_without_levels_it_is_viscous():
    assert list(friction_velocity(COULOMB, [-3.0, -1e-9, 1e-9, 3.0])) == [-2.0, -2.0, 2.0, 2.0]
    oil = Sliding(0.0, 0.0, 1.0, 7.0)
    assert list(friction_velocity(TwoSided(oil, oil), [-2.0, 1.0])) == [-14.0, 7.0]


def test_at_rest_friction_is_the_push_up_to_the_static_friction_of_its_direction():
    assert [resting_friction(UNEQUAL, push) for push in (3.0, 12.0, -3.0, -12.0)] == [3.0, 9.0, -3.0, -5.0]


def test_a_mass_at_rest_stays_until_the_push_exceeds_the_static_friction_of_that_direction():
    for push in (8.999, -4.999, 0.0):
        assert speed_after(UNEQUAL, 0.0, push, 1.0, 1e-3) == 0.0
    assert speed_after(UNEQUAL, 0.0, 9.5, 1.0, 1e-3) == pytest.approx(0.5e-3 / (1.0 + 10.0 * 1e-3))
    assert speed_after(UNEQUAL, 0.0, -6.0, 1.0, 1e-3) == pytest.approx(-1.0e-3 / (1.0 + 30.0 * 1e-3))


def test_a_mass_that_stops_within_a_step_stops_and_does_not_turn():
    assert speed_after(COULOMB, 1e-3, -1.5, 1.0, 1e-3) == 0.0  # free it would turn to -0.5e-3; 2 N can hold 1.5 N
    assert speed_after(COULOMB, 1.0, 0.0, 1.0, 0.1) == pytest.approx(0.8)
    assert speed_after(COULOMB, 1e-3, -50.0, 1.0, 1e-3) == pytest.approx(-0.047)
