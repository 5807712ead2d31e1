"""A parameter that a disturbance holds for a while: disturbed again, set by hand, undone."""

import pytest

from leadscrew.operate.operated import Operated, Start

KEY = "plant.full_duty_speed_mm_s"


@pytest.fixture(scope="module")
def lathe():
    """The lathe's servo, on the Python engine."""
    return Operated(Start("vud_lathe", "ours.pd", "fig11a_step_m50", engine="python"))


def test_a_disturbance_twice_ends_where_it_began(lathe):
    operated = lathe.restarted()
    first = operated.values()[KEY]
    for _ in range(2):
        operated.disturb("speed_loss", {"loss": 20.0, "for_s": 0.02})
        operated.advance(10)
        assert operated.values()[KEY] == pytest.approx(0.8 * first)
    operated.advance(30)
    assert operated.values()[KEY] == first


def test_what_was_set_while_a_disturbance_held_it_is_undone_to_the_value_before_the_disturbance(lathe):
    operated = lathe.restarted()
    first = operated.values()[KEY]
    operated.disturb("speed_loss", {"loss": 20.0, "for_s": 0.05})
    operated.advance(10)
    change = operated.set({KEY: 300.0})
    assert change.old == {KEY: pytest.approx(0.8 * first)}
    operated.advance(100)
    assert operated.values()[KEY] == 300.0
    assert operated.undo().new == {KEY: first}
    operated.advance(10)
    assert operated.values()[KEY] == first
    assert operated.redo().new == {KEY: 300.0}
    assert operated.session().run(record=()).identical
