"""Steps, ramps, sines and sweeps against their formulas, and the sweeps against SciPy."""

import math

import numpy as np
import pytest
from scipy.signal import chirp as scipy_chirp

from leadscrew.references._chirp import chirp, log_chirp
from leadscrew.references._filtered_step import filtered_step
from leadscrew.references._quintic import quintic
from leadscrew.references._ramp import ramp, ramp_motion
from leadscrew.references._sine import sine, sine_motion
from leadscrew.references._step import step


def test_step_changes_at_the_nearest_sample():
    block = step(initial=-1.0, target=50.0, time=0.3)
    assert [block.step(block.params, k * 0.1, 0.1) for k in (0, 2, 3, 9)] == [-1.0, -1.0, 50.0, 50.0]


def test_ramp_rises_for_its_duration_and_holds():
    block = ramp(initial=1.0, rate=-2.0, start=1.0, duration=3.0)
    assert [block.step(block.params, t) for t in (0.0, 1.0, 2.0, 4.0, 9.0)] == [1.0, 1.0, -1.0, -5.0, -5.0]


def test_sine_and_its_derivatives():
    changes = {"amplitude": 2.0, "frequency": 0.7, "phase": 0.3, "offset": -1.0}
    h = 1e-5
    for t in (0.0, 0.4, 3.3):
        here, before, after = (sine.step(sine(**changes).params, x) for x in (t, t - h, t + h))
        motion = sine_motion.step(sine_motion(**changes).params, t)
        assert here == pytest.approx(-1.0 + 2.0 * math.sin(2 * math.pi * 0.7 * t + 0.3), rel=1e-14)
        assert motion.position == here
        assert motion.velocity == pytest.approx((after - before) / (2 * h), rel=1e-7)
        assert motion.acceleration == pytest.approx((after - 2 * here + before) / h**2, rel=1e-3)


@pytest.mark.parametrize(("block", "method"), [(chirp, "linear"), (log_chirp, "logarithmic")])
@pytest.mark.parametrize("ends", [(1.0, 80.0), (50.0, 2.0), (3.0, 3.0)])
def test_sweeps_agree_with_scipy(block, method, ends):
    block = block(amplitude=1.5, start_frequency=ends[0], end_frequency=ends[1], duration=4.0, offset=0.5)
    p = block.prepare(block.params, 1e-3) if block.prepare else block.params
    t = np.linspace(0, 4, 801)
    expected = 0.5 + 1.5 * scipy_chirp(t, ends[0], 4.0, ends[1], method=method, phi=-90)
    np.testing.assert_allclose([block.step(p, x) for x in t], expected, atol=1e-10)
    later = np.array([block.step(p, x) for x in 4.0 + np.linspace(0, 1 / ends[1], 5)])
    assert later[0] == pytest.approx(later[4], abs=1e-9)
    assert later[0] - 0.5 == pytest.approx(0.5 - later[2], abs=1e-9)


def derivatives(block, t, h=1e-5):
    """Position at t, and its first two central differences."""
    before, here, after = (block.step(block.params, x).position for x in (t - h, t, t + h))
    return here, (after - before) / (2.0 * h), (after - 2.0 * here + before) / h**2


def test_a_ramp_as_a_motion_has_its_speed_while_it_runs():
    block = ramp_motion(initial=1.0, rate=-2.0, start=1.0, duration=3.0)
    seen = [block.step(block.params, t)[:2] for t in (0.5, 2.0, 5.0)]
    assert seen == [(1.0, 0.0), (-1.0, -2.0), (-5.0, 0.0)]


@pytest.mark.parametrize("t", [0.25, 0.3, 0.4, 0.58])
def test_a_quintic_move_has_the_derivatives_that_it_says(t):
    block = quintic(distance=-3.0, duration=0.4, start=0.2, initial=1.0)
    position, velocity, acceleration = derivatives(block, t)
    motion = block.step(block.params, t)
    assert motion.velocity == pytest.approx(velocity, rel=1e-6)
    assert motion.acceleration == pytest.approx(acceleration, rel=1e-3, abs=1e-3)
    assert -2.0 < position < 1.0


def test_a_quintic_move_rests_at_both_ends_and_is_fastest_in_the_middle():
    block = quintic(distance=2.0, duration=0.4, start=0.2)
    first, middle, last, later = (block.step(block.params, t) for t in (0.2, 0.4, 0.6 + 1e-12, 9.0))
    assert first == (0.0, 0.0, 0.0) and later == (2.0, 0.0, 0.0)
    assert middle.position == pytest.approx(1.0) and middle.velocity == pytest.approx(1.875 * 2.0 / 0.4)
    assert last.position == pytest.approx(2.0, abs=1e-12) and abs(last.velocity) < 1e-9
    accelerations = [block.step(block.params, t).acceleration for t in np.linspace(0.2, 0.6, 4001)]
    assert max(accelerations) == pytest.approx(10.0 / math.sqrt(3.0) * 2.0 / 0.16, rel=1e-5)


def test_a_quintic_move_of_no_duration_is_a_bare_step():
    block = quintic(distance=2.0, duration=0.0, start=0.1)
    assert block.step(block.params, 0.0999) == (0.0, 0.0, 0.0) and block.step(block.params, 0.1) == (2.0, 0.0, 0.0)


def test_a_filtered_step_solves_its_differential_equation():
    block = filtered_step(distance=-2.0, rate=50.0, start=0.1, initial=3.0)
    for t in (0.11, 0.13, 0.2):
        motion = block.step(block.params, t)
        left = motion.acceleration + 100.0 * motion.velocity + 2500.0 * motion.position
        assert left == pytest.approx(2500.0 * 1.0, rel=1e-12)
        assert motion.velocity == pytest.approx(derivatives(block, t)[1], rel=1e-6)
    assert block.step(block.params, 0.05) == (3.0, 0.0, 0.0)
    assert block.step(block.params, 0.1 + 6.64 / 50.0).position == pytest.approx(3.0 - 2.0 * 0.99, abs=1e-3)
    assert block.step(block.params, 1e6) == pytest.approx((1.0, 0.0, 0.0), abs=1e-200)
