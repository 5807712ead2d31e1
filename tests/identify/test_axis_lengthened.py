"""Signals that are played are lengthened so that logs of many lengths share compiled code: nothing else may change."""

import numpy as np
import pytest

from leadscrew.identify.axis import replay
from leadscrew.identify.axis.replay import played
from leadscrew.identify.log_player import Starts, lengthened
from tests.identify.axis_truth import truth


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 1000, 1025, 21290, 32768])
def test_a_signal_keeps_its_values_and_repeats_its_last(count):
    values = np.random.default_rng(count).normal(size=count)
    longer = lengthened(values)
    assert count <= len(longer) <= 1.25 * count + 1
    assert np.array_equal(longer[:count], values) and set(longer[count:]) <= {values[-1]}


def test_a_thousand_lengths_share_few():
    assert len({len(lengthened(np.zeros(n))) for n in range(9000, 10000)}) <= 2


@pytest.mark.slow
def test_a_replay_is_the_same_to_the_bit(monkeypatch):
    log = truth(1033).log()
    point = {"mass": 90.0, "friction.forward.coulomb": 20.0, "friction.backward.coulomb": 22.0}
    starts = Starts(np.array([0.0]), np.array([log.position[0]]), np.array([0.0]))
    runs = []
    for change in (lengthened, np.asarray):
        monkeypatch.setattr(replay, "lengthened", change)
        runs.append(played(log).play([point], starts, len(log.time), [1.5 * log.period]))
    assert np.array_equal(runs[0], runs[1]) and np.ptp(runs[0]) > 0.0
