"""The table added to a controller's output: NumPy's periodic interpolation, at and between its values."""

from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.controllers._feed_forward_table import feed_forward_table
from leadscrew.kernel.block import controller


class Gain(NamedTuple):
    kp: float = 2.0


class Past(NamedTuple):
    output: float = 0.0


def align(params, command, feedback, output):
    return Past(output)


@controller(Gain(), Past(), align=align)
def proportional(p, s, command, feedback, dt):
    return Past(p.kp * (command - feedback)), p.kp * (command - feedback)


@pytest.mark.parametrize("dt", [0.5, 0.25, 0.4, 1.0, 7.5])
def test_the_table_starts_again_after_its_period_and_is_a_straight_line_between_its_values(dt):
    # With steps of 0.5 s the places of 6 values over 3 s are met exactly, the end of the table too.
    table, period = np.array([0.0, 1.0, 4.0, -2.0, 3.0, 0.5]), 3.0
    block = feed_forward_table(proportional, table, period)
    plan, state, found = block.prepare(block.params, dt), block.state, []
    for _ in range(40):
        state, u = block.step(plan, state, 3.0, 1.0, dt)
        found.append(u)
    t = np.arange(40) * dt
    # Sums of 40 steps: some 1e-14 of a place.
    np.testing.assert_allclose(found, 4.0 + np.interp(t, np.arange(6) * 0.5, table, period=period), atol=1e-12)


def test_a_bumpless_start_is_at_the_first_value_of_the_table():
    block = feed_forward_table(proportional, (0.75, -1.0), 1.0)
    state = block.align(block.params, 3.0, 1.0, 5.0)
    assert (state.inner.output, state.place) == (4.25, 0.0)
