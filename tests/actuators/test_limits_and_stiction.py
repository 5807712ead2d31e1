"""A drive command limited in rate and size, and one that is lost below a threshold: sample by sample, by hand."""

import math

import pytest

from leadscrew.actuators._limits import limits
from leadscrew.actuators._stiction import stiction
from leadscrew.util.errors import ValueRefused


def test_a_command_follows_by_the_rate_both_ways_and_stays_within_its_ends():
    """200 a second at 10 ms: 2 a period, from 0; between -3 and 5."""
    block = limits(lower=-3.0, upper=5.0, rate=200.0)
    plan, state, found = block.prepare(block.params, 0.01), block.state, []
    for asked in (1.5, 9.0, 9.0, 9.0, -9.0, -9.0, -9.0, -9.0, -9.0, -2.5):
        state, value = block.step(plan, state, asked)
        found.append(value)
    assert found == pytest.approx([1.5, 3.5, 5.0, 5.0, 3.0, 1.0, -1.0, -3.0, -3.0, -2.5])


def test_ends_may_meet_and_not_cross():
    block = limits(lower=1.0, upper=1.0)
    assert block.step(block.prepare(block.params, 1e-3), block.state, 0.3)[1] == 1.0
    crossed = limits(lower=1.0, upper=0.999)
    with pytest.raises(ValueRefused, match=r"lower = 1\.0 \(limits\): must not lie above upper = 0\.999"):
        crossed.prepare(crossed.params, 1e-3)


def test_stiction_loses_what_is_smaller_than_its_threshold_and_passes_the_rest_whole():
    block = stiction(threshold=0.05)
    asked = (0.0499, -0.0499, 0.05, -0.05, 1.0)
    assert [block.step(block.params, x) for x in asked] == [0.0, 0.0, 0.05, -0.05, 1.0]
    assert math.copysign(1.0, stiction.step(stiction.params, -0.0)) == -1.0
