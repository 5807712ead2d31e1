"""A controller of numbers behind a motion, or on an axis that shows more than its position.

A user who puts a PID behind an S-curve, the first thing that most try, would be told that a number is not a motion.
"""

from typing import NamedTuple

import numpy as np
import pytest

import leadscrew as ls
from leadscrew.controllers import pid, torque_pid
from leadscrew.kernel.block import controller, reference, sensor
from leadscrew.plants import servo_axis
from leadscrew.references import s_curve, sine
from leadscrew.util.errors import BlockError

MOVE = s_curve(distance=5.0, max_velocity=50.0, max_acceleration=500.0, max_jerk=1e4)
GAINS = {"kp": 5.0, "ki": 20.0, "kd": 0.1, "filter_s": 1e-3}


@sensor()
def table(actual):
    """The table alone."""
    return actual.position


def loop(block, **parts):
    return ls.Loop(**{"reference": MOVE, "controller": block, "plant": servo_axis, "period": 1e-3, **parts})


def test_a_pid_follows_a_motion_as_the_one_that_reads_motions():
    expected = loop(torque_pid(**GAINS), sensor=table).run(0.3, record=("output", "actual"))
    found = loop(pid(**GAINS)).run(0.3, record=("output", "actual"))
    for name in ("output", "actual.position"):
        np.testing.assert_array_equal(found[name], expected[name])
    assert np.ptp(found["actual.position"]) > 4.0


def test_all_engines_give_the_same_bits_and_a_live_loop_takes_over_without_a_bump():
    fast, plain = (loop(pid(**GAINS)).run(0.1, record=("output",), engine=e)["output"] for e in ("llvm", "python"))
    assert np.array_equal(fast, plain)
    live = loop(torque_pid(**GAINS), sensor=table).start()
    before = live.advance(100)["output"][-1]
    live = live.switch(pid(**GAINS))
    assert live.bumpless and live.advance(1)["output"][0] == pytest.approx(before, rel=0.05)


@pytest.mark.parametrize("parts", [{"reference": sine(amplitude=1.0)}, {"sensor": table}], ids=["feedback", "command"])
def test_only_what_is_a_record_is_read_by_its_position(parts):
    both = loop(pid(**GAINS), **parts).run(0.1, record=("output",))["output"]
    one = loop(pid(**GAINS), **parts, **({} if "sensor" in parts else {"sensor": table})).run(0.1, record=("output",))
    assert np.array_equal(both, one["output"])


class Gain(NamedTuple):
    """A gain."""

    k: float = 2.0


@controller(Gain())
def simple(p, command, feedback):
    """Neither state nor period."""
    return p.k * (command - feedback)


@controller()
def bare(command, feedback):
    """Nothing but signals."""
    return 2.0 * (command - feedback)


def test_a_controller_without_parameters_or_state_is_read_alike():
    first, second = (loop(block).run(0.1, record=("output",))["output"] for block in (simple, bare))
    assert np.array_equal(first, second) and np.abs(first).max() > 0.0


class Pair(NamedTuple):
    """Two numbers without a position."""

    a: float = 0.0
    b: float = 0.0


@reference()
def pairs(t):
    """Two commands."""
    return Pair(t, t)


def test_a_record_without_a_position_is_refused_as_before():
    with pytest.raises(BlockError, match=r"command Pair\(a, b\)"):
        loop(simple, reference=pairs).run(0.1)


@controller(Gain())
def wrong(p, command, feedback):
    """Takes numbers, and fails on them too."""
    return p.k * (command - feedback) + len(feedback)


def test_a_controller_that_fails_on_numbers_too_says_so():
    with pytest.raises(BlockError, match="'wrong', in the first period: TypeError"):
        loop(wrong).run(0.1)
