"""Steps, ramps, sines and sweeps against their formulas, and the sweeps against SciPy."""

import math

import numpy as np
import pytest
from scipy.signal import chirp as scipy_chirp

from leadscrew.references.chirp import chirp, log_chirp
from leadscrew.references.ramp import ramp
from leadscrew.references.sine import sine, sine_motion
from leadscrew.references.step import step


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
