"""The feed override stepped by hand: its ceiling, rapids, and that a hold is a feed hold."""

import math

import pytest

from leadscrew.controllers._guard import HOLDING, TRIPPED, FeedCommand, Recovery, feed_override, force_guard
from leadscrew.studies.grey_turning.tunings import TUNINGS
from leadscrew.util.errors import BlockError
from tests.controllers.guarded import NO_STILL, Stepped, climb, reading

CUT = FeedCommand(150.0, 1.0, 1.0, 1e9, 75.0, 0.0)
RAPID = CUT._replace(rapid=1.0)


def overridden(inner, command=CUT, **more):
    return Stepped(feed_override(inner, machine=True, **more), command)


def under_guard(**recover):
    return force_guard(climb(by=0.05), cell=NO_STILL, recover=Recovery(**recover))


def test_the_override_is_the_feed_in_parts_of_the_programmed_one():
    """0.05 V more each time, 150 mm/min a volt, 75 mm/min programmed."""
    found = overridden(under_guard())
    assert [found(100.0) for _ in range(3)] == pytest.approx([0.1, 0.2, 0.3])
    found.take(reading(100.0), CUT._replace(feed=150.0))
    assert found.take(reading(100.0), CUT._replace(feed=150.0)) == pytest.approx(0.25)


@pytest.mark.parametrize("inner", [climb(by=0.05), under_guard()])
def test_the_programmed_feed_is_the_ceiling_and_nothing_winds_up_against_it(inner):
    found = overridden(inner)
    outputs = [found(100.0) for _ in range(200)]
    assert outputs[:9] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]) and set(outputs[10:]) == {1.0}
    found.command = CUT._replace(feed=150.0)
    assert 0.5 <= found(100.0) < 0.56, "goes on from the old ceiling"


def test_a_fuzzy_controller_comes_down_from_the_ceiling_at_once():
    """Without being told of the ceiling it would first have to come down from 1 V."""
    found = overridden(TUNINGS["corrected.tfc_s6"])
    for _ in range(300):
        last = found(20.0)
    assert last == 1.0 and found(200.0) < 1.0


@pytest.mark.parametrize("inner", [climb(by=0.05), under_guard()])
@pytest.mark.parametrize("feed", [0.0, -75.0, math.nan, math.inf, -math.inf])
def test_without_a_sound_programmed_feed_the_feed_is_held(inner, feed):
    found = overridden(inner)
    assert found(100.0) > 0.0
    wrong = CUT._replace(feed=feed)
    assert [found.take(reading(100.0), wrong) for _ in range(20)] == [0.0] * 20 and found.sound()
    assert found(100.0) == pytest.approx(0.1), "from 0"
    assert found.take(reading(0.0), wrong._replace(rapid=1.0)) == (1.0 if feed == 0.0 else 0.0) and found.sound()


@pytest.mark.parametrize("inner", [climb(by=0.05), under_guard()])
def test_a_flag_for_rapids_that_is_no_number_holds_the_feed(inner):
    found = overridden(inner)
    assert found.take(reading(100.0), CUT._replace(rapid=math.nan)) == 0.0 and found.sound()
    assert [found(100.0) for _ in range(3)][-1] > 0.0


def test_the_feed_of_the_parameter_counts_where_the_machine_is_not_asked():
    fixed = Stepped(feed_override(under_guard(), programmed_feed=300.0))
    assert fixed(100.0) == pytest.approx(0.025)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_without_guard_a_number_that_is_not_finite_holds_one_period_and_stays_nowhere(bad):
    found = overridden(TUNINGS["corrected.gpfc_b_s6"])
    for _ in range(10):
        before = found(100.0)
    wrong = [found(bad), found.take(reading(100.0), CUT._replace(force=bad))]
    assert before > 0.0 and wrong == [0.0, 0.0] and found.sound() and found(100.0) > 0.5 * before


@pytest.mark.parametrize("inner", [climb(by=0.05), under_guard()])
def test_on_rapids_it_is_one_and_the_controller_waits(inner):
    found = overridden(inner)
    cut = [found(100.0) for _ in range(4)]
    assert [found.take(reading(0.0), RAPID) for _ in range(100)] == [1.0] * 100
    assert found(100.0) == pytest.approx(cut[-1], abs=1e-12)


def test_after_a_rapid_the_next_cut_starts_with_the_feed_of_air():
    found = overridden(under_guard())
    for _ in range(9):
        found(100.0)
    found.take(reading(0.0), RAPID)
    assert found(100.0) == pytest.approx(0.3 / 0.5)


def test_a_hold_is_a_hold_on_rapids_too():
    found = overridden(under_guard())
    found(100.0)
    assert found.take(reading(250.0), RAPID) == 0.0, "a collision"
    assert found.s.inner.guard.mode == HOLDING
    assert [found.take(reading(0.0), RAPID) for _ in range(5)] == [0.0] * 4 + [1.0]
    assert found.take(reading(math.nan), RAPID) == 0.0


def test_a_rapid_does_not_reset_a_hold_that_stays():
    found = overridden(under_guard(retries=0))
    found(200.0)
    assert found.s.inner.guard.mode == TRIPPED
    assert [found.take(reading(0.0), RAPID) for _ in range(50)] == [0.0] * 50 and found(0.0) == 0.0


def test_a_broken_load_cell_gives_no_override_whatever_comes():
    found = overridden(force_guard(TUNINGS["corrected.gpfc_b_s9"]))
    for bad in (math.nan, math.inf, -math.inf, 1e30, -1e30):
        assert found(bad) == 0.0 and found.s.last == 0.0


def test_the_override_starts_without_a_jump():
    found = Stepped(feed_override(force_guard(TUNINGS["corrected.tfc_s6"]), machine=True), CUT, output=0.4)
    assert found(150.0) == pytest.approx(0.4, abs=1e-12)


def test_it_needs_a_controller_that_can_be_aligned():
    from tests.controllers.test_force_guard import unaligned

    with pytest.raises(BlockError, match=r"feed_override\(unaligned\): needs a controller with a bumpless start"):
        feed_override(unaligned)
