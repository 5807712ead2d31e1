"""A logged command, played again."""

import numpy as np
import pytest

from leadscrew.references._logged import logged_command
from leadscrew.util.errors import DataError, ValueRefused


def at(block, t):
    return block.step(block.params, t)


def test_it_is_the_log_at_its_samples_and_a_straight_line_between():
    block = logged_command([0.0, 1.0, 4.0, 9.0], 0.5)
    assert [at(block, t).position for t in (0.0, 0.5, 1.0, 1.25)] == pytest.approx([0.0, 1.0, 4.0, 6.5])
    assert at(block, 0.5).velocity == pytest.approx(4.0) and at(block, 1.0).velocity == pytest.approx(8.0)
    assert at(block, 1.5).position == pytest.approx(9.0) and at(block, 7.0).position == pytest.approx(9.0)
    assert at(block, 7.0).velocity == at(block, 7.0).acceleration == 0.0


def test_of_a_parabola_it_knows_speed_and_acceleration():
    t = np.arange(100) * 0.01
    block = logged_command(3.0 * t * t, 0.01)
    assert at(block, 0.5).velocity == pytest.approx(3.0) and at(block, 0.5).acceleration == pytest.approx(6.0)


def test_what_is_no_log_is_refused():
    for bad, complaint in (([0.0, 1.0], "2 samples"), ([0.0, np.nan, 1.0], "sample 2")):
        with pytest.raises(DataError, match=complaint):
            logged_command(bad, 0.1)
    with pytest.raises(ValueRefused, match="interval"):
        logged_command([0.0, 1.0, 2.0], 0.0)
