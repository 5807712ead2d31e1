"""The converter against NumPy's rounding, and its effect on the lathe."""

import math

import numpy as np
import pytest

from leadscrew.actuators._dac import DacParams, dac, lathe_dac, plan_dac, plan_lathe_dac
from leadscrew.references._lathe_program import LatheDrive
from leadscrew.util.errors import ValueRefused


def test_twelve_bits_give_the_nearest_of_4096_values():
    values = np.linspace(-10.0, 10.0, 4097)[:-1]
    plan = plan_dac(DacParams(), 0.02)
    for asked in np.random.default_rng(3).uniform(-12.0, 12.0, 200):
        given = dac.step(plan, float(asked))
        assert given == pytest.approx(values[np.abs(values - asked).argmin()], abs=1e-12)


def test_without_bits_only_the_range_holds():
    plan = plan_dac(DacParams(bits=0, lower=0.0, upper=1.0), 0.02)
    assert [dac.step(plan, x) for x in (-0.3, 0.123456789, 7.0)] == [0.0, 0.123456789, 1.0]


@pytest.mark.parametrize("bits", [0, 12])
@pytest.mark.parametrize("asked", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_taken_as_zero_within_the_range(bits, asked):
    assert dac.step(plan_dac(DacParams(bits=bits), 0.02), asked) == 0.0
    assert dac.step(plan_dac(DacParams(bits=bits, lower=1.0, upper=5.0), 0.02), asked) == 1.0


def test_the_largest_numbers_end_at_the_range():
    assert [dac.step(plan_dac(DacParams(), 0.02), x) for x in (1e308, -1e308)] == [10.0 - 20.0 / 4096.0, -10.0]


def test_the_top_of_the_range_is_a_step_short():
    assert dac.step(plan_dac(DacParams(bits=2, lower=-2.0, upper=2.0), 0.02), 9.0) == 1.0


def test_three_converters_have_resolutions_of_their_own():
    block = lathe_dac(**{"spindle.bits": 3, "feed.bits": 0, "radial.bits": 1})
    found = lathe_dac.step(plan_lathe_dac(block.params, 0.02), LatheDrive(3.0, 0.321, 4.0))
    assert found == LatheDrive(2.5, 0.321, 0.0)


def test_a_range_the_wrong_way_round_is_refused():
    with pytest.raises(ValueRefused, match=r"lower = 1.0 \(dac\): must lie below upper = 1.0"):
        plan_dac(DacParams(lower=1.0, upper=1.0), 0.02)
