"""The filtered scale against SciPy's simulation of the same low-pass."""

import math

import numpy as np
import pytest
from scipy.signal import lsim

from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._counts import ruler
from leadscrew.sensors._filtered_ruler import filtered_ruler
from leadscrew.util.errors import ValueRefused

DT = 2.5e-4


def read(positions, **changes):
    block = filtered_ruler(**changes)
    p, s, readings = block.prepare(block.params, DT), block.state, []
    for x in positions:
        s, reading = block.step(p, s, x)
        readings.append(reading)
    return np.array(readings)


@pytest.mark.parametrize("hz", [100.0, 1000.0, 5000.0])
def test_between_evenly_moving_samples_it_is_the_low_pass(hz):
    rng = np.random.default_rng(1)
    x = np.cumsum(rng.normal(0.0, 1e-3, 60))
    x -= x[0]
    tau = 1.0 / (2.0 * math.pi * hz)
    _, expected, _ = lsim(([1.0], [tau, 1.0]), x, DT * np.arange(60))
    assert read(x, low_pass_hz=hz, resolution_mm=1e-12) == pytest.approx(expected, abs=2e-12)


def test_at_a_constant_speed_the_reading_is_late_by_the_time_constant():
    x = 2.0 * DT * np.arange(400)
    assert (x - read(x, resolution_mm=1e-9))[-1] == pytest.approx(2.0 / (2.0 * math.pi * 1000.0), rel=1e-5)


def test_without_a_filter_it_is_the_ruler():
    x = np.random.default_rng(2).uniform(-1.0, 1.0, 50)
    plain = [ruler.step(ruler(resolution_mm=1e-3).params, value) for value in x]
    assert read(x, low_pass_hz=0.0, resolution_mm=1e-3).tolist() == plain


def test_it_starts_where_the_axis_stands():
    assert read([7.0, 7.0], resolution_mm=1e-3) == pytest.approx([7.0, 7.0], abs=1e-9)


def test_a_reading_that_dies_away_ends_at_zero():
    block = filtered_ruler()
    p, s = block.prepare(block.params, DT), block.state
    for x in [1.0] + [0.0] * 500:
        s, _ = block.step(p, s, x)
    assert s.x == 0.0


def test_a_negative_corner_is_refused():
    with pytest.raises(ValueRefused, match=r"low_pass_hz = -1.0"):
        filtered_ruler(low_pass_hz=-1.0)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = Loop(reference=sine_motion, controller=pd_dob, plant=ballscrew_stage, sensor=filtered_ruler, period=DT,
                metrics={}, method="rodas")  # fmt: skip
    fast, plain = (loop.run(0.02, record=("feedback", "actual"), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)
