"""A positioning sequence in steps: each position for its dwell, the last for good."""

import numpy as np
import pytest

from leadscrew.kernel.loop import Loop
from leadscrew.references._stairs import stairs
from leadscrew.util.errors import LeadscrewError
from tests.kernel import zoo


def commands(seconds, engine="llvm", **params):
    loop = Loop(reference=stairs(**params), controller=zoo.pid, plant=zoo.mass, period=0.001, metrics={})
    return loop.run(seconds, record=("command",), engine=engine)["command"]


def test_each_position_is_held_for_its_dwell_and_the_last_for_good():
    found = commands(0.05, positions=np.array([1.0, -2.0, 5.0]), dwell=0.01)
    assert found.tolist() == [1.0] * 10 + [-2.0] * 10 + [5.0] * 30


def test_a_dwell_that_is_no_whole_number_of_periods_steps_at_the_nearest_one():
    found = commands(0.012, positions=np.array([0.0, 1.0, 2.0]), dwell=0.0034)
    assert np.flatnonzero(np.diff(found)).tolist() == [2, 6]


@pytest.mark.sweep
def test_the_python_engine_gives_the_same_bits():
    way = {"positions": [1, 2, 0], "dwell": 0.017}
    assert commands(0.1, "python", **way).tobytes() == commands(0.1, **way).tobytes()


def test_an_empty_sequence_is_refused():
    with pytest.raises(LeadscrewError, match="positions"):
        stairs([])
    with pytest.raises(LeadscrewError, match="dwell"):
        stairs([1.0], dwell=0.0)
