"""Generalised Maxwell slip against the rules of Masing worked by hand, closed forms and SciPy."""

import math

import numpy as np
import pytest

from leadscrew.analysis.friction import friction_along, friction_velocity, path_through
from leadscrew.friction.asymmetric import LuGreSlide
from leadscrew.friction.lugre import level
from leadscrew.friction.maxwell_slip import Elements, MaxwellSlip, checked, elements_force, move_elements, unloaded
from leadscrew.util.errors import ValueRefused

THREE = MaxwellSlip(
    share=np.array([1.0, 2.0, 3.0]) / 6.0,
    stiffness=np.full(3, 1000.0),
    damping=0.0,
    viscous=0.0,
    coulomb=6.0,
    static=6.0,
)
"""Elements that slip at 1, 2 and 3 N after 1, 2 and 3 mm."""


def along(f, points, step=1e-4, dt=1e-3):
    path = path_through(points, step)
    return path, friction_along(f, path, dt)


def at(points, **more):
    """Force at the last point."""
    return along(THREE, points, **more)[1][-1]


def test_the_first_loading_is_the_sum_of_springs_that_yield_one_after_the_other():
    expected = {0.0005: 1.5, 0.001: 3.0, 0.002: 5.0, 0.0025: 5.5, 0.003: 6.0, 0.01: 6.0}
    for x, force in expected.items():
        assert at([0.0, x]) == pytest.approx(force, rel=1e-12)
        assert at([0.0, -x]) == pytest.approx(-force, rel=1e-12)


def test_a_branch_after_a_reversal_is_the_first_loading_doubled():
    for back, drop in ((0.001, 3.0), (0.002, 6.0), (0.004, 10.0), (0.006, 12.0), (0.009, 12.0)):
        assert at([0.0, 0.004, 0.004 - back]) == pytest.approx(6.0 - drop, abs=1e-11)


def test_it_remembers_a_turning_point_until_that_is_passed_again():
    assert at([0.0, 0.004, 0.001]) == pytest.approx(-2.0)  # 6 - 2 * first loading of 1.5 mm
    assert at([0.0, 0.004, 0.001, 0.0025]) == pytest.approx(2.5)  # -2 + 2 * first loading of 0.75 mm
    assert at([0.0, 0.004, 0.001, 0.0025, 0.001]) == pytest.approx(-2.0)  # the inner loop closes
    assert at([0.0, 0.004, 0.001, 0.0025, 0.0]) == pytest.approx(-4.0)  # and the outer branch goes on
    assert at([0.0, 0.004, 0.0]) == pytest.approx(-4.0)


def test_lugre_has_no_such_memory():
    f = LuGreSlide(stiffness=3000.0, damping=0.0, viscous=0.0, coulomb=6.0, static=6.0, stribeck_speed=1.0)
    once = along(f, [0.0, 0.004, 0.001])[1][-1]
    again = along(f, [0.0, 0.004, 0.001, 0.0025, 0.001])[1][-1]
    assert abs(again - once) > 0.5


def test_the_force_before_sliding_depends_on_the_path_and_not_on_its_speed_or_its_steps():
    points = [0.0, 0.0025, -0.001, 0.0015]
    slow, fast, coarse = at(points, dt=10.0), at(points), at(points, step=1.0)
    assert slow == pytest.approx(fast, abs=1e-11) and coarse == pytest.approx(fast, abs=1e-11)


def test_steady_sliding_is_the_stribeck_map():
    f = MaxwellSlip(attraction=1e4)
    for v in (-0.2, 3e-4, 2e-3, 0.05):
        forces = friction_along(f, v * 1e-2 * np.arange(101), 1e-2)
        assert forces[-1] == pytest.approx(friction_velocity(f, [v])[0], rel=1e-9)
        assert friction_velocity(f, [v])[0] == pytest.approx(math.copysign(level(f, v), v) + 0.4 * v)


def test_sliding_friction_lags_behind_a_change_of_speed_by_the_time_of_its_attraction():
    """From the level at a crawl to the one at 1 m/s: the difference decays as exp(-C t / s)."""
    f = MaxwellSlip(attraction=50.0, viscous=0.0)
    e = unloaded(f)
    for _ in range(400):
        e = move_elements(f, e, 1e-5, 0.1)
    assert elements_force(e) == pytest.approx(1.5, rel=1e-4)
    before = elements_force(e)
    e = move_elements(f, e, 1.0, 0.03)
    assert elements_force(e) == pytest.approx(1.0 + (before - 1.0) * math.exp(-50.0 * 0.03), rel=1e-9)


def test_one_step_at_a_constant_speed_is_as_good_as_a_thousand():
    f = MaxwellSlip(attraction_per_travel=2e4)
    start = (np.array([0.02, -0.1, 0.25, 0.0, 0.3, -0.4]), np.array([0.0, -1.0, 1.0, 0.0, 1.0, 0.0]))
    one = move_elements(f, Elements(*(a.copy() for a in start)), 2e-3, 5e-3)
    many = Elements(*(a.copy() for a in start))
    for _ in range(1000):
        many = move_elements(f, many, 2e-3, 5e-6)
    assert np.allclose(one.force, many.force, rtol=1e-9) and np.array_equal(one.slips, many.slips)


def test_elements_that_slip_stick_again_when_the_motion_turns_or_stops():
    f = THREE
    e = move_elements(f, unloaded(f), 1.0, 0.0025)
    assert list(e.slips) == [1.0, 1.0, 0.0] and list(e.force) == pytest.approx([1.0, 2.0, 2.5])
    stopped = move_elements(f, Elements(e.force.copy(), e.slips.copy()), 0.0, 1.0)
    assert list(stopped.slips) == [0.0, 0.0, 0.0] and list(stopped.force) == list(e.force)
    turned = move_elements(f, e, -1.0, 0.0001)
    assert list(turned.slips) == [0.0, 0.0, 0.0] and list(turned.force) == pytest.approx([0.9, 1.9, 2.4])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"share": np.array([0.5, 0.5])}, r"share has the shape \(2,\), friction.stiffness \(6,\)"),
        ({"share": np.array([0.5, 0.6]), "stiffness": np.ones(2)}, r"sums to 1.1; .* must sum to 1"),
        ({"share": np.array([1.5, -0.5]), "stiffness": np.ones(2)}, r"share\[1\] = -0.5"),
        ({"share": np.ones(1), "stiffness": np.array([np.inf])}, r"stiffness\[0\] = inf"),
        ({"share": np.ones(0), "stiffness": np.ones(0)}, r"shape \(0,\)"),
    ],
)
def test_elements_that_make_no_sense_are_refused(changes, words):
    with pytest.raises(ValueRefused, match=words):
        checked(MaxwellSlip(**changes))


def test_shares_that_sum_to_less_or_more_than_one_are_refused():
    for last in (0.4, 0.6):
        with pytest.raises(ValueRefused, match=f"sums to {0.5 + last:g}; the shares of all elements must sum to 1"):
            checked(MaxwellSlip(share=np.array([0.5, last]), stiffness=np.array([1.0, 1.0])))
