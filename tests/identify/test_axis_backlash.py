"""Lost motion from reversals: is the play found, is none found where there is none, is it said where a log is mute?"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from leadscrew import Loop, controller
from leadscrew.identify.axis.backlash import backlash_of, lost_motion
from leadscrew.identify.axis.cascade import Cascade
from leadscrew.logs.arrays import axis_log
from leadscrew.plants._backlash import backlash_axis
from leadscrew.references._sine import sine
from leadscrew.util.errors import DataError
from tests.identify.axis_exact import KP, KV, PERIOD, VALUES, Exact, recorded, strokes
from tests.identify.test_axis_simulation import PUBLISHED, emps

COUNT = 1e-7


@cache
def record(play: float, closed_on: str = "motor", seed: int = 1) -> tuple[np.ndarray, ...]:
    command = strokes(6.0)
    return (*recorded(Exact(), command, play, closed_on, COUNT, COUNT, seed), command)


def log_of(play: float, closed_on: str = "motor", with_command: bool = True) -> Any:
    _, table, drive, command = record(play, closed_on)
    time = np.arange(len(table)) * PERIOD
    return axis_log(time, drive, table, command if with_command else None)


@controller()
def stiff(command, feedback):
    """A spring from the command to the motor."""
    return 2e7 * (command - feedback.motor)


@pytest.mark.parametrize("play", [0.0, 7e-6])
def test_two_encoders_give_the_play_of_an_axis_with_backlash(play: float) -> None:
    loop = Loop(
        reference=sine(amplitude=0.02, frequency=0.5), controller=stiff, period=PERIOD, metrics={},
        plant=backlash_axis(**{"play.forward_gap": 0.6 * play, "play.backward_gap": 0.4 * play}),
    )  # fmt: skip
    run = loop.run(6.0)
    r = np.random.default_rng(2)
    motor, table = (
        np.round((run[f"actual.{name}"] + COUNT * r.standard_normal(6000)) / COUNT) * COUNT
        for name in ("motor", "position")
    )
    found = lost_motion(motor, table, PERIOD)
    assert found.identifiable and found.method == "two positions" and found.low <= play <= found.high
    assert found.high - found.low < 1e-7


@pytest.mark.parametrize("play", [5e-6, 20e-6])
def test_command_and_drive_give_the_play_where_the_loop_was_closed_on_the_motor(play: float) -> None:
    found = backlash_of(log_of(play), cascade=Cascade(KP, KV, over=2))
    assert found.identifiable and found.method == "command and drive"
    assert found.low <= play <= found.high and found.value == pytest.approx(play, rel=0.01)
    # which speed the loop used decides a micrometre; not known, the interval says so
    free = backlash_of(log_of(play))
    assert free.low <= play <= free.high and free.high - free.low > found.high - found.low


def test_a_loop_closed_on_the_table_is_said_to_hide_the_play_in_its_law() -> None:
    found = backlash_of(log_of(20e-6, "table"))
    assert not found.identifiable and "the loop was closed on this encoder" in found.note and np.isnan(found.low)


@pytest.mark.slow
@pytest.mark.parametrize(("play", "closed_on"), [(0.0, "motor"), (20e-6, "table")])
def test_the_dwell_at_reversals_gives_the_play_where_only_drive_and_table_were_logged(
    play: float, closed_on: str
) -> None:
    found = backlash_of(log_of(play, closed_on, with_command=False), VALUES)
    assert found.identifiable and found.method == "dwell at reversals" and found.low <= play <= found.high
    assert found.value == pytest.approx(play, abs=2e-7)


def test_one_position_alone_does_not_tell_the_play_and_the_reason_is_given() -> None:
    found = backlash_of(log_of(20e-6, with_command=False))
    assert not found.identifiable and found.method == "none" and "log both positions, or the command" in found.note


def test_a_log_without_reversals_says_how_many_strokes_are_needed() -> None:
    log = log_of(5e-6)
    few = log.part(None, 0.6)
    assert "strokes" in backlash_of(few).note and not backlash_of(few).identifiable
    with pytest.raises(DataError, match="a play needs at least 4"):
        lost_motion(few.position, few.position, PERIOD)


@pytest.mark.slow
def test_emps_does_not_tell_a_play_but_bounds_it() -> None:
    found = backlash_of(emps(), PUBLISHED)
    assert not found.identifiable and found.low == 0.0 and found.high < 1e-3
