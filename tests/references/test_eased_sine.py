"""A sine that grows from rest: its ends, and its derivatives against differences."""

import math

import pytest

from leadscrew.references._eased_sine import EasedSineParams, eased_sine, eased_sine_motion

P = EasedSineParams(amplitude=2.0, frequency=0.7, ease_s=1.0)


@pytest.mark.parametrize("t", [0.0, 0.2, 0.5, 0.93, 1.0, 1.7])
def test_speed_and_acceleration_are_the_slopes_of_what_came_before(t):
    h, at = 1e-5, eased_sine_motion.step
    for field, slope in (("position", "velocity"), ("velocity", "acceleration")):
        difference = (getattr(at(P, t + h), field) - getattr(at(P, t - h), field)) / (2.0 * h)
        if t > 0.0:
            assert getattr(at(P, t), slope) == pytest.approx(difference, abs=2e-3)
    assert eased_sine.step(P, t) == at(P, t).position


def test_it_starts_at_rest_and_is_the_plain_sine_from_the_end_of_its_growth_on():
    assert eased_sine_motion.step(P, 0.0) == (0.0, 0.0, 0.0)
    assert eased_sine.step(P, 3.3) == pytest.approx(2.0 * math.sin(2.0 * math.pi * 0.7 * 3.3), rel=1e-14)
    at_once = eased_sine_motion.step(P._replace(ease_s=0.0), 0.0)
    assert at_once.velocity == pytest.approx(2.0 * 1.4 * math.pi, rel=1e-14)
