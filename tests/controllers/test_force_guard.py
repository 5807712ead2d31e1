"""The force guard stepped on readings made by hand: what holds the feed, when, and how it comes back."""

import math
from dataclasses import replace

import pytest

from leadscrew.controllers._guard import (
    HOLDING,
    RUNNING,
    TRIPPED,
    AirCut,
    CellChecks,
    Clock,
    Levels,
    Recovery,
    force_guard,
)
from leadscrew.controllers._guard.watching import (
    BELOW_ZERO,
    JUMP,
    NOT_FINITE,
    OUT_OF_RANGE,
    STUCK,
    TOO_LARGE,
    UNANSWERED,
)
from leadscrew.kernel.block import controller
from leadscrew.studies.grey_turning.tunings import TUNINGS
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.guarded import COMMAND, NO_STILL, ClimbParams, ClimbState, Stepped, climb, climbing, reading

BAD = (math.nan, math.inf, -math.inf)


def test_below_its_levels_the_guard_changes_nothing():
    guarded = Stepped(force_guard(TUNINGS["corrected.tfc_s6"], cell=CellChecks(rise=0.0)))
    bare = Stepped(TUNINGS["corrected.tfc_s6"], 150.0)
    for k in range(200):
        raw = 150.0 - 100.0 * math.exp(-0.05 * k) + 9.0 * math.sin(1.3 * k)
        assert guarded(raw, 0.9 * raw) == bare.take(0.9 * raw)


def test_a_force_above_its_limit_holds_the_feed_in_the_same_step():
    found = climbing()
    assert found(164.9) == pytest.approx(0.5) and found(150.0) == pytest.approx(0.51)
    assert found(180.1, 150.0) == 0.0
    assert (found.guard.mode, found.guard.cause, found.guard.tripped_at) == (HOLDING, TOO_LARGE, pytest.approx(0.51))


def test_the_filtered_force_does_not_hold_the_feed():
    assert climbing()(150.0, 400.0) == pytest.approx(0.5)


def test_between_its_two_levels_the_feed_is_reduced_along_a_line():
    """Half way from 165 to 180 N, half way from 1 to 0.3: 0.65 of the output, and no memory of it."""
    found = climbing()
    assert found(172.5) == pytest.approx(0.65 * 0.5)
    assert found(165.0) == pytest.approx(0.51) and found(180.0) == pytest.approx(0.3 * 0.52)


def test_a_guard_that_is_to_confirm_waits_for_so_many_readings_in_a_row():
    found = climbing(levels=Levels(confirm=3, min_share=1.0))
    assert min(found(200.0), found(200.0), found(150.0), found(200.0), found(200.0)) > 0.4
    assert found(200.0) == 0.0


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("field", ["force", "raw", "travel", "turns"])
def test_a_number_that_is_not_finite_holds_the_feed_and_gets_nowhere(field, bad):
    found = Stepped(force_guard(TUNINGS["corrected.gpfc_b_s6"], cell=NO_STILL), output=0.24)
    for _ in range(8):
        assert found(150.0) > 0.2
    assert found.take(reading(150.0)._replace(**{field: bad})) == 0.0 and found.sound()
    assert (found.guard.mode, found.guard.cause) == (HOLDING, NOT_FINITE)
    assert [found.take(reading(20.0)._replace(**{field: bad})) for _ in range(50)] == [0.0] * 50 and found.sound()
    assert [found(20.0) for _ in range(4)] == [0.0] * 4
    assert found(20.0) > 0.0 and found.sound()


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("field", COMMAND._fields)
@pytest.mark.parametrize("clock", [None, Clock(every=1)])
def test_a_command_that_is_not_finite_holds_the_feed_and_gets_nowhere(field, bad, clock):
    found = Stepped(force_guard(TUNINGS["corrected.gpfc_b_s6"], cell=NO_STILL, clock=clock), output=0.24)
    assert found(150.0) > 0.2
    wrong = COMMAND._replace(**{field: bad})
    assert found.take(reading(150.0), wrong) == 0.0 and found.sound() and found.guard.cause == NOT_FINITE
    assert [found.take(reading(20.0), wrong) for _ in range(50)] == [0.0] * 50 and found.sound()
    assert [found(20.0) for _ in range(12)][-1] > 0.0 and found.sound(), "goes on with the next sound command"


@pytest.mark.parametrize("clock", [None, Clock(every=20)])
def test_a_quiet_cell_of_coarse_counts_in_air_is_not_held(clock):
    """Counts of 2 N in air: 0, now and then 2 or -2 N; or nothing but 0."""
    for raw in (0.0, 2.0, -2.0):
        found = Stepped(force_guard(climb, clock=clock), period=0.001 if clock else 0.02)
        assert [found(raw) for _ in range(800)][-1] > 0.25 and found.guard.mode == RUNNING


def frozen(found, level, calls=600):
    """Outputs while the cell shows a level with 0.2 N of noise."""
    return [found(level + 0.2 * math.sin(7.0 * k)) for k in range(calls)]


def test_a_cell_that_freezes_under_noise_is_held_for_good_and_a_reset_does_not_free_it():
    """The output climbs by 0.01 a period from 0.5; 0.3 above it the cell must have answered within 0.4 s."""
    block = force_guard(climb(by=0.01))
    found = Stepped(block, output=0.5)
    outputs = frozen(found, 140.0)
    assert max(outputs) < 0.75 and set(outputs[100:]) == {0.0} and found.guard.cause == UNANSWERED
    found.p = block.prepare(block(**{"recover.reset": 1}).params, 0.02)
    assert set(frozen(found, 100.0)) == {0.0}


def test_a_sound_cell_that_was_doubted_restarts_because_it_falls_while_the_feed_is_held():
    found = Stepped(force_guard(climb(by=0.01)), output=0.5)
    frozen(found, 140.0, 100)
    assert found.guard.mode == HOLDING
    for k in range(30):
        last = found(1.0 + 0.2 * math.sin(7.0 * k))
    assert last > 0.0 and found.guard.mode == RUNNING


def test_a_force_that_answers_the_feed_is_not_doubted():
    """The force follows the output with its power of 0.8, a period late, while the output triples."""
    found = Stepped(force_guard(climb(by=0.01)), output=0.25)
    found.s, last = found.block.align(found.p, COMMAND, reading(50.0), 0.25), 0.25
    for k in range(50):
        last = found(50.0 * (last / 0.25) ** 0.8 + 0.2 * math.sin(7.0 * k))
    assert last == pytest.approx(0.74) and found.guard.mode == RUNNING


def test_a_mean_force_below_zero_holds_the_feed():
    found = climbing()
    outputs = [found(-100.0) for _ in range(20)]
    assert outputs[-1] == 0.0 and found.guard.cause == BELOW_ZERO


def test_a_first_reading_that_is_not_finite_holds_the_feed():
    found = Stepped(force_guard(climb))
    assert found(math.nan) == 0.0 and found.guard.cause == NOT_FINITE and found.sound()


@pytest.mark.parametrize(("raw", "cause"), [(1000.0, OUT_OF_RANGE), (-1000.0, OUT_OF_RANGE), (8388607.0, OUT_OF_RANGE),
                                            (-211.0, JUMP), (510.5, JUMP), (510.0, TOO_LARGE)])  # fmt: skip
def test_a_reading_that_cannot_be_holds_the_feed_in_the_same_step(raw, cause):
    """From 150 N, 60 N and 15 kN/s for 20 ms are 360 N."""
    found = climbing()
    found(150.0)
    assert found(raw) == 0.0 and found.guard.cause == cause


def test_a_jump_within_what_a_cut_can_do_is_none():
    found = climbing()
    found(150.0)
    assert found(-209.0) > 0.0


def test_a_stuck_load_cell_stops_the_rise_at_the_third_equal_reading_and_the_feed_after_its_time():
    found = climbing(cell=CellChecks(still_s=0.1), by=0.1, output=0.1)
    outputs = [found(150.0) for _ in range(8)]
    assert outputs == pytest.approx([0.1, 0.2, 0.2, 0.2, 0.2, 0.0, 0.0, 0.0])
    assert found.guard.cause == STUCK
    assert [found(100.0) for _ in range(40)] == [0.0] * 40, "stuck at another number"


@pytest.mark.parametrize("cell", [CellChecks(still_s=0.0), CellChecks(still_above_n=160.0)])
def test_a_quiet_load_cell_may_stand_still_where_it_is_allowed_to(cell):
    found = climbing(cell=cell)
    assert min(found(150.0) for _ in range(20)) > 0.4 and found.guard.mode == RUNNING


def test_a_load_cell_that_stands_still_at_the_least_force_of_a_cut_is_stuck():
    found = climbing(cell=CellChecks(still_above_n=150.0))
    assert [found(150.0) for _ in range(8)][-1] == 0.0 and found.guard.cause == STUCK


def test_it_restarts_after_the_quiet_time_at_a_share_of_the_feed_and_climbs_from_there():
    """0.1 s are five readings below 120 N; one above it begins them anew."""
    found = climbing()
    found(150.0)
    assert found(200.0) == 0.0
    quiet = [found(raw) for raw in (119.0, 119.0, 119.0, 121.0, 119.0, 119.0, 119.0, 119.0)]
    assert quiet == [0.0] * 8
    assert [found(119.0) for _ in range(3)] == pytest.approx([0.15, 0.16, 0.17])
    assert found.guard.mode == RUNNING


def test_the_filtered_force_must_be_low_for_a_restart_too():
    found = climbing()
    found(200.0)
    assert [found(10.0, 121.0) for _ in range(30)] == [0.0] * 30
    assert [found(11.0, 119.0) > 0.0 for _ in range(5)] == [False] * 4 + [True]


def test_a_fuzzy_controller_restarts_where_it_was_aligned():
    found = Stepped(force_guard(TUNINGS["corrected.tfc_s6"], cell=NO_STILL), output=0.24)
    found(150.0)
    before = found.guard.output
    found(200.0)
    outputs = [found(100.0) for _ in range(5)]
    assert outputs[:4] == [0.0] * 4 and outputs[4] == pytest.approx(0.3 * before, abs=1e-12)


def again(found):
    """One hold and its quiet time: whether the feed came back."""
    found(200.0)
    return [found(100.0) for _ in range(6)][-1] > 0.0


def test_after_its_retries_a_hold_stays_until_it_is_reset():
    block = force_guard(climb, cell=NO_STILL, recover=Recovery(retries=2))
    found = Stepped(block, output=0.5)
    assert [again(found) for _ in range(3)] == [True, True, False]
    assert found.guard.mode == TRIPPED and found.guard.holds == 3
    assert [found(0.0) for _ in range(500)] == [0.0] * 500
    found.p = block.prepare(block(**{"recover.reset": 1}).params, 0.02)
    assert found(100.0) == 0.0 and (found.guard.mode, found.guard.holds) == (HOLDING, 0)
    assert [found(100.0) > 0.0 for _ in range(5)] == [False] * 4 + [True]


def test_holds_are_forgotten_after_a_while_of_running():
    found = Stepped(force_guard(climb(by=0.0), cell=NO_STILL, recover=Recovery(retries=1, forget_s=1.0)), output=0.5)
    for _ in range(5):
        assert again(found)
        for _ in range(51):
            found(100.0)
    assert again(found) and not again(found)


def test_the_feed_goes_to_zero_within_the_ramp():
    found = climbing(recover=Recovery(ramp_s=0.1), by=0.0)
    found(150.0)
    assert [found(200.0) for _ in range(6)] == pytest.approx([0.4, 0.3, 0.2, 0.1, 0.0, 0.0], abs=1e-12)


def test_without_a_cut_the_feed_is_that_of_air_and_the_cut_starts_from_it():
    found = climbing(air=AirCut(air_n=10.0, air_v=0.3), by=0.05, output=0.1)
    outputs = [found(1.0) for _ in range(50)]
    assert outputs[:5] == pytest.approx([0.1, 0.15, 0.2, 0.25, 0.3]) and max(outputs) == 0.3
    assert found(12.0) == pytest.approx(0.3)


def test_a_quiet_load_cell_without_cut_never_gives_full_feed():
    """A dead one: noise about zero, which a fuzzy controller answers with all the feed it has."""
    found = Stepped(force_guard(TUNINGS["corrected.tfc_s9"]))
    assert max(found(2.0 * math.sin(9.0 * k), 0.0) for k in range(500)) <= 0.3
    bare = Stepped(TUNINGS["corrected.tfc_s9"], 150.0)
    assert max(bare.take(0.0) for _ in range(500)) == 1.0


def test_the_fast_guard_runs_its_controller_at_its_own_period_on_the_force_that_it_filters():
    cell, clock = CellChecks(rise=0.0), Clock(every=20, keep=0.8)
    slow = Stepped(force_guard(TUNINGS["corrected.tfc_s6"], cell=cell))
    fast = Stepped(force_guard(TUNINGS["corrected.tfc_s6"], cell=cell, clock=clock), period=0.001)
    filtered = 0.0
    for k in range(2000):
        raw = 150.0 * (1.0 - math.exp(-0.004 * k)) + 8.0 * math.sin(1.3 * k)
        output = fast(raw, math.sin(k))
        if k % 20 == 0:
            filtered = 0.8 * filtered + (1.0 - 0.8) * raw
            expected = slow(raw, filtered)
        assert output == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("looks", [1, 4, 20])
def test_the_fast_guard_holds_at_its_next_look(looks):
    found = Stepped(force_guard(climb, clock=Clock(every=20, looks=looks), cell=NO_STILL), period=0.001, output=0.5)
    outputs = [found(150.0 if k < 41 else 200.0) for k in range(80)]
    first = next(k for k, u in enumerate(outputs) if u == 0.0)
    assert first == -(-41 // looks) * looks and set(outputs[first:]) == {0.0}


def test_the_fast_guard_restarts_at_its_share_too():
    found = Stepped(force_guard(climb(by=0.01), clock=Clock(every=20), cell=NO_STILL), period=0.001, output=0.5)
    found(150.0)
    found(200.0)
    quiet = [found(20.0) for _ in range(400)]
    first = next(k for k, u in enumerate(quiet) if u > 0.0)
    assert quiet[first] == pytest.approx(0.15) and max(quiet[first : first + 19]) <= 0.16 + 1e-12
    assert first >= 99, "0.1 s below 120 N, the filtered force as well"


def test_the_guard_starts_without_a_jump():
    block = force_guard(TUNINGS["corrected.gpfc_b_s6"])
    assert Stepped(block, output=0.4)(150.0) == pytest.approx(0.4, abs=1e-12)


@controller(ClimbParams(), ClimbState())
def unaligned(p, s, command, feedback, dt):
    """No bumpless start."""
    return s, p.by


@pytest.mark.parametrize(("make", "words", "error"), [
    (lambda: force_guard(unaligned), r"force_guard\(unaligned\): needs a controller with a bumpless start", BlockError),
    (lambda: force_guard(climb, levels=Levels(reduce_n=180.0)), r"reduce_n = 180 N .*hold_n = 180 N", ValueRefused),
    (lambda: force_guard(climb, recover=Recovery(resume_n=300.0)), r"resume_n = 300 N", ValueRefused),
    (lambda: force_guard(climb, clock=Clock(every=20, looks=3)), r"every = 20, clock.looks = 3", ValueRefused),
    (lambda: force_guard(climb)(**{"cell.range_n": -1.0}), r"range_n", ValueRefused),
])  # fmt: skip
def test_what_cannot_work_is_refused_with_one_sentence(make, words, error):
    with pytest.raises(error, match=words):
        make()


def test_values_set_later_are_checked_when_the_loop_is_built():
    block = force_guard(climb)(**{"levels.reduce_n": 200.0})
    with pytest.raises(ValueRefused, match="below hold_n"):
        block.prepare(block.params, 0.02)


def test_a_controller_that_reads_the_whole_cut_gets_it():
    seen = []

    def whole_step(p, s, command, feedback, dt):
        seen.append((command, feedback))
        return s, 0.1

    whole_step.takes_cut = True
    block = replace(climb, step=whole_step)
    found = Stepped(force_guard(block))
    found.take(reading(50.0)._replace(travel=3.0, turns=7.0))
    assert seen == [(COMMAND, (50.0, 50.0, 3.0, 7.0))]
