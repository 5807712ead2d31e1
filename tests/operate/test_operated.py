"""A machine run by hand: bits, bumps, the ghost, undo, refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.experiment import Experiment
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.operate.bench_study import NAME


def column(operated, rows, name):
    return rows[:, operated.columns.index(name)]


def test_an_untouched_machine_gives_the_bits_of_its_loop(machine):
    operated = machine()
    rows, ghost = operated.advance(800)
    assert ghost is None
    run = Experiment(NAME, "pid", "way").loop().run(0.8, record=("command", "feedback", "output", "actual", "plant"))
    for name, values in run.signals.items():
        assert values.tobytes() == column(operated, rows, name).tobytes(), name
    assert operated.columns[0] == "time"
    assert operated.units["plant.speed"] == "mm/s" and operated.units["output"] == "V"


def played(operated, pieces):
    """A run with every kind of change, advanced in these pieces between them."""
    rows = []

    def on(periods):
        for piece in pieces:
            piece = min(piece, periods)
            if piece:
                rows.append(operated.advance(piece)[0])
            periods -= piece
        if periods:
            rows.append(operated.advance(periods)[0])

    on(37)
    operated.set({"controller.kp": 5.0, "controller.steps": 8})
    on(60)
    operated.disturb("load_pulse", {"size": 0.5, "for_s": 0.05})
    on(30)
    operated.set({"controller.kp": 1.0})
    operated.schedule(operated.period + 23, {"plant.lag_s": 0.04}, "wear")
    on(200)
    operated.undo()
    on(80)
    return np.concatenate(rows)


@settings(max_examples=6, deadline=None)
@given(st.lists(st.integers(1, 90), max_size=12))
def test_pieces_in_which_a_machine_is_advanced_never_change_a_bit(machines, pieces):
    whole, cut = (machines["gain"].restarted() for _ in range(2))
    a, b = played(whole, [10_000]), played(cut, pieces)
    assert a.tobytes() == b.tobytes()
    assert whole.digest == cut.digest
    assert whole.session() == cut.session()


def test_a_gain_moves_in_small_steps_and_leaves_the_integrator_alone(machine):
    operated = machine("pid")
    operated.advance(40)
    change = operated.set({"controller.kp": 6.0})
    rows, ghost = operated.advance(100)
    mine, other = column(operated, rows, "output"), column(operated, ghost, "output")
    unbumped = 3.0 * abs(column(operated, rows, "error")[0])  # the proportional term alone changes
    assert unbumped > 0.1 and change.how == "ramped"
    assert np.abs(np.diff(mine - other, prepend=0.0)).max() < 0.06 * unbumped
    assert operated.session().events[0].by == ""
    integral, error = (column(operated, rows, c) for c in ("controller.integral", "error"))
    assert np.diff(integral) == pytest.approx(1e-3 * error[1:], rel=1e-9)


def test_an_integrator_keeps_its_share_of_the_output_when_its_gain_changes(machine):
    operated = machine("pid")
    operated.set({"disturbance.size": 0.5, "disturbance.start": 0.0, "disturbance.duration": 10.0})
    operated.advance(40)
    share = 20.0 * operated.live.values()["controller.integral"]
    change = operated.set({"controller.ki": 400.0})
    rows, ghost = operated.advance(20)
    event = operated.session().events[-1]
    assert abs(share) > 0.01 and (event.how, event.by) == ("ramped", "controller.integral")
    assert change.after == pytest.approx(change.before, abs=0.05 * abs(share))
    mine, other = column(operated, rows, "output"), column(operated, ghost, "output")
    unbumped = 19.0 * abs(share)
    assert np.abs(np.diff(mine - other, prepend=0.0)).max() < 0.01 * unbumped


def test_an_integrator_that_had_no_share_begins_from_none(machine):
    operated = machine("pid")
    operated.set({"controller.ki": 0.0})
    operated.advance(150)
    assert abs(operated.live.values()["controller.integral"]) > 1e-4
    operated.set({"controller.ki": 20.0})
    assert operated.live.values()["controller.integral"] == 0.0
    operated.advance(150)
    assert operated.session().run(record=()).identical


def test_a_gain_set_again_on_its_way_goes_on_from_where_it_is(machine):
    operated = machine("pid")
    operated.set({"disturbance.size": 0.5, "disturbance.start": 0.0, "disturbance.duration": 10.0})
    operated.advance(40)
    for ki in (200.0, 50.0, 100.0):
        share = operated.loop.parameters["controller.ki"] * operated.live.values()["controller.integral"]
        change = operated.set({"controller.ki": ki})
        assert abs(share) > 0.01 and change.after == pytest.approx(change.before, abs=0.05 * abs(share))
        operated.advance(33)
    operated.advance(100)
    assert operated.loop.parameters["controller.ki"] == 100.0 and operated.session().run(record=()).identical


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_numbers_that_overflow_put_no_warning_of_numpy_on_the_terminal(machine):
    operated = machine("pid")
    operated.advance(50)
    operated.set({"controller.kd": 1e300})
    operated.advance(1)
    operated.set({"controller.ki": 17.0})
    assert operated.session().events[-1].by == ""


def test_at_the_limit_of_the_output_no_integrator_is_touched(machine):
    operated = machine("pid")
    operated.set({"controller.lower": -0.05, "controller.upper": 0.05})
    operated.advance(150)
    before = operated.live.values()["controller.integral"]
    assert abs(column(operated, operated.advance(1)[0], "output")[0]) == 0.05
    operated.set({"controller.ki": 40.0})
    assert operated.session().events[-1].by == ""
    assert operated.live.values()["controller.integral"] == pytest.approx(before, abs=1e-3)


def test_what_is_not_the_controllers_reaches_the_ghost_and_makes_none(machine):
    operated = machine()
    operated.advance(20)
    operated.set({"reference.amplitude": 3.0})
    assert operated.ghost is None and operated.can_undo
    assert operated.advance(20)[1] is None
    operated.set({"controller.kp": 4.0, "plant.gain": 25.0})
    assert operated.ghost.label == "controller.kp = 3"
    rows, ghost = operated.advance(20)
    assert (rows != ghost).any()
    operated.set({"reference.amplitude": 2.0})
    rows, ghost = operated.advance(20)
    assert operated.ghost.since == 40
    assert column(operated, rows, "command").tobytes() == column(operated, ghost, "command").tobytes()
    assert operated.undo().new == {"reference.amplitude": 3.0}
    rows, ghost = operated.advance(20)
    assert column(operated, rows, "command").tobytes() == column(operated, ghost, "command").tobytes()
    assert operated._ghost.axes.lives[0].loop.parameters["plant.gain"] == 25.0


def test_a_controller_without_align_ramps_over_a_tenth_of_a_second(machine):
    operated = machine("gain")
    operated.advance(300)
    change = operated.set({"controller.kp": 6.0, "controller.steps": 50})
    rows, _ = operated.advance(200)
    kp = column(operated, rows, "output") / column(operated, rows, "error")
    assert change.how == "ramped"
    by_hand = 2.0 + 4.0 * (np.minimum(np.arange(200) // 5, 19) + 1) / 20.0
    assert kp == pytest.approx(by_hand, rel=1e-9)
    error = column(operated, rows, "error")
    jumps = np.abs(np.diff(column(operated, rows, "output"))) - np.abs(np.diff(error)) * 6.0
    unbumped = 4.0 * abs(error[0])
    assert jumps.max() < 0.06 * unbumped
    assert operated.values()["controller.kp"] == 6.0 and operated.values()["controller.steps"] == 50


def test_on_a_ramp_the_value_shown_is_where_it_goes(machine):
    operated = machine("gain")
    operated.set({"controller.kp": 6.0})
    operated.advance(10)
    assert operated.values()["controller.kp"] == 6.0
    assert operated.loop.parameters["controller.kp"] < 4.0
    operated.set({"controller.kp": 3.0})
    assert operated.undo().new == {"controller.kp": 6.0}


def test_the_ghost_is_a_run_under_the_old_setting_bit_for_bit(machine):
    operated, plain = machine(), machine()
    operated.compare("previous")
    operated.advance(150)
    operated.set({"controller.kp": 9.0})
    operated.advance(50)
    operated.disturb("load_pulse", {"size": 1.0, "for_s": 0.02})
    operated.disturb("noise", {"deviation": 0.01, "for_s": 0.1})
    mine, ghost = operated.advance(200)
    plain.advance(200)
    plain.disturb("load_pulse", {"size": 1.0, "for_s": 0.02})
    plain.disturb("noise", {"deviation": 0.01, "for_s": 0.1})
    alone, none = plain.advance(200)
    assert none is None
    assert ghost.tobytes() == alone.tobytes() and mine.tobytes() != alone.tobytes()
    assert operated.ghost.since == 150 and "controller.kp = 3" in operated.ghost.label


def test_a_new_change_moves_the_ghost_unless_it_is_pinned(machine):
    previous, pinned = machine(), machine()
    pinned.compare("pinned")
    for operated in (previous, pinned):
        operated.advance(50)
        operated.set({"controller.kp": 4.0})
        operated.advance(50)
        operated.set({"controller.kp": 5.0})
    assert (previous.ghost.since, pinned.ghost.since) == (100, 50)
    rows, ghost = previous.advance(1)
    assert np.isfinite(ghost).all() and not np.shares_memory(rows, ghost)
    mine, other = previous.live, previous._ghost.axes.lives[0]
    for a, b in zip((*mine.state, *mine.params), (*other.state, *other.params), strict=True):
        assert not np.shares_memory(a, b)
    previous.compare("off")
    assert previous.ghost is None and previous.advance(1)[1] is None
    with pytest.raises(ValueRefused, match="allowed are previous, pinned, off"):
        previous.compare("sideways")


def test_a_value_that_is_there_already_is_no_change(machine):
    operated = machine()
    operated.advance(10)
    assert operated.set({"controller.kp": 3.0}).new == {}
    assert operated.ghost is None and not operated.can_undo and not operated.session().events


def test_changes_are_undone_and_done_again(machine):
    operated = machine()
    operated.advance(20)
    operated.set({"controller.kp": 4.0})
    operated.set({"plant.gain": 30.0, "controller.ki": 1.0})
    operated.advance(20)
    assert operated.undo().new == {"plant.gain": 20.0, "controller.ki": 20.0}
    assert operated.undo().new == {"controller.kp": 3.0}
    assert operated.changed() == {} and not operated.can_undo
    with pytest.raises(ValueRefused, match="nothing to undo"):
        operated.undo()
    assert operated.redo().new == {"controller.kp": 4.0}
    assert operated.changed() == {"controller.kp": 4.0}
    operated.set({"controller.kd": 0.0})
    assert not operated.can_redo


def test_a_disturbance_ends_at_its_period_and_is_not_undone(machine):
    operated = machine()
    operated.advance(100)
    operated.disturb("load_pulse", {"size": 2.0, "for_s": 0.03})
    rows, _ = operated.advance(100)
    load = column(operated, rows, "disturbance")
    assert np.flatnonzero(load).size in (30, 31) and set(load) == {0.0, 2.0}
    assert not operated.can_undo


def test_a_later_value_cancels_what_was_scheduled(machine):
    operated = machine()
    operated.schedule(50, {"plant.gain": 1.0}, "wear")
    operated.schedule(60, {"plant.lag_s": 0.01}, "wear")
    operated.advance(10)
    operated.set({"plant.gain": 15.0})
    operated.advance(100)
    assert operated.values()["plant.gain"] == 15.0 and operated.values()["plant.lag_s"] == 0.01
    assert [(e.period, e.why) for e in operated.session().events] == [(10, ""), (60, "wear")]
    with pytest.raises(ValueRefused, match="110 periods are done already"):
        operated.schedule(5, {"plant.gain": 1.0})


def test_the_controller_is_switched_in_the_run_and_back_with_its_values(machine):
    operated = machine()
    operated.advance(200)
    operated.set({"controller.kp": 3.5})
    operated.advance(10)
    before = list(operated.columns)
    change = operated.switch(operated.prepare("gain"))
    assert change.how == "not bumpless"
    assert change.old == {"controller": "pid", "controller.kp": 3.5} and change.new == {"controller": "gain"}
    rows, ghost = operated.advance(50)
    assert rows.shape == ghost.shape == (50, len(operated.columns)) and operated.columns != before
    assert "controller.steps" in operated.sheet and "controller.ki" not in operated.sheet
    plain = machine()
    plain.advance(200)
    plain.set({"controller.kp": 3.5})
    alone = plain.advance(60)[0][10:]
    for name in ("output", "actual", "plant.speed"):
        assert column(operated, ghost, name).tobytes() == column(plain, alone, name).tobytes()
    assert rows[:, 0].tobytes() == alone[:, 0].tobytes()
    back = operated.undo()
    assert operated.columns == before and back.new["controller.kp"] == 3.5
    assert back.how == "aligned" and back.after == pytest.approx(back.before, abs=1e-9)
    operated.advance(10)
    assert operated.redo().new == {"controller": "gain"}


def test_a_ghost_of_another_controller_takes_what_it_knows_of_what_happens(machine):
    operated = machine()
    operated.advance(50)
    operated.switch("gain")
    operated.schedule(80, {"controller.steps": 4, "plant.gain": 22.0}, "wear")
    operated.set({"controller.steps": 3}, compare=False, why="fault")
    rows, ghost = operated.advance(60)
    assert rows.shape == ghost.shape and operated.values()["controller.steps"] == 3
    assert operated._ghost.axes.lives[0].loop.parameters["plant.gain"] == 22.0
    assert operated.session().run(record=()).identical


def test_a_switch_keeps_the_machine_where_it_is(machine):
    operated = machine()
    last = operated.advance(200)[0][-1]
    change = operated.switch("stiff")
    first = operated.advance(1)[0][0]
    assert change.how == "aligned"
    for name in ("actual", "plant.speed", "output"):
        i = operated.columns.index(name)
        assert abs(first[i] - last[i]) < 0.05 * max(1.0, abs(last[i]))


def test_a_controller_of_another_machine_cannot_take_over(machine):
    operated = machine()
    with pytest.raises(ValueRefused, match=r"slow cannot take over .* period of 0.002 s.* 0.001 s; start a new run"):
        operated.switch("slow")
    with pytest.raises(NameUnknown, match="no controller 'pidd'"):
        operated.prepare("pidd")
