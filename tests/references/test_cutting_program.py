"""The depth programme of a turning operation."""

import numpy as np
import pytest

from leadscrew.references._cutting_program import (
    NEVER_S,
    CuttingProgramParams,
    DepthProgram,
    cut_command,
    cutting_program,
    depth_at,
)

FALLING = DepthProgram(1.0, -0.2, 2.0, 3)


def test_the_depth_falls_by_its_stairs():
    times = [0.0, 1.98, 2.0, 3.9, 4.0, 6.0, 100.0]
    assert [depth_at(FALLING, t) for t in times] == pytest.approx([1.0, 1.0, 0.8, 0.8, 0.6, 0.4, 0.4])


def test_every_sample_of_20_ms_is_on_the_right_side_of_a_change():
    depths = [depth_at(FALLING, k * 0.02) for k in range(400)]
    assert np.flatnonzero(np.diff(depths)).tolist() == [99, 199, 299]


def test_the_command_says_the_next_depth_and_when_it_comes():
    now = cut_command(150.0, FALLING, 1.5)
    assert now.next_depth == pytest.approx(0.8) and now.change_in_s == pytest.approx(0.5)
    last = cut_command(150.0, FALLING, 7.0)
    assert (last.depth, last.next_depth, last.change_in_s) == pytest.approx((0.4, 0.4, NEVER_S))
    assert cutting_program(CuttingProgramParams(150.0, FALLING), 1.5) == now


def test_the_tool_enters_and_leaves():
    program = DepthProgram(1.0, entry_s=0.4, leave_s=3.0)
    assert [depth_at(program, t) for t in (0.0, 0.1, 0.4, 2.9, 3.0)] == pytest.approx([0.0, 0.25, 1.0, 1.0, 0.0])


def test_a_staircase_never_goes_below_zero():
    assert depth_at(DepthProgram(0.3, -0.2, 1.0, 5), 4.5) == 0.0
