"""Settings of a tangential knife: places, words and corners at the ends of what is allowed."""

from dataclasses import replace

import pytest

from leadscrew.tangent.settings import RANGES, Settings, nearest_turn, settings_of
from leadscrew.util.errors import DataError, ValueRefused


@pytest.mark.parametrize("prick", ["1,100001", "-100001,1", "nan,0", "0,inf", "1", "1,2,3", "a,b"])
def test_a_mark_with_one_bad_coordinate_is_refused(prick):
    with pytest.raises(ValueRefused, match=f"prick {prick}: expected X,Y, two numbers in mm"):
        Settings(pricks=f"1,2 {prick}")


def test_marks_are_read_in_their_order():
    assert Settings(pricks="1,-2.5 100000,-1e5").places() == [(1.0, -2.5), (1e5, -1e5)]


@pytest.mark.parametrize(("name", "low", "high", "unit"), RANGES)
def test_both_ends_of_a_range_are_allowed_and_nothing_beyond(name, low, high, unit):
    wide = Settings(lift=1000.0, depth=-1000.0)
    for value in (low, high):
        if name not in ("lift", "depth"):
            assert getattr(replace(wide, **{name: value}), name) == value
    for value in (low - 1e-6 * max(1.0, abs(low)), high + 1e-6 * high, float("nan")):
        with pytest.raises(ValueRefused, match=f"{name} = "):
            replace(wide, **{name: value})


def test_the_knife_that_lifts_no_higher_than_it_cuts_is_refused():
    with pytest.raises(ValueRefused, match="depth = 2: expected less than lift, 2 mm"):
        Settings(lift=2.0, depth=2.0)
    with pytest.raises(ValueRefused, match="lift = 0: expected above 0 mm"):
        Settings(lift=0.0).over_the_sheet()
    with pytest.raises(ValueRefused, match="depth = 1: expected 0 mm"):
        Settings(lift=2.0, depth=1.0).over_the_sheet()
    assert Settings(lift=2.0, depth=0.0).over_the_sheet().depth == 0.0


def test_a_corner_as_sharp_as_allowed_is_turned_at_depth_and_a_sharper_one_lifts():
    turns = {20.0: False, -20.0: False, 20.0000005: False, 20.00001: True, -20.00001: True}
    assert {turn: Settings(corner_angle=20.0).lifts(turn) for turn in turns} == turns


def test_lengths_are_rounded_as_they_are_written():
    # 1.23486 mm are 0.0486165 inch.
    assert Settings().rounded(1.23486) == pytest.approx(1.2349, abs=1e-12)
    assert Settings(inch=True).rounded(1.23486) == pytest.approx(0.04862 * 25.4, abs=1e-12)


@pytest.mark.parametrize(("clockwise", "word"), [(False, 30.0), (True, -30.0)])
def test_a_word_of_the_axis_counts_from_its_zero_in_its_own_direction(clockwise, word):
    settings = Settings(zero=90.0, clockwise=clockwise)
    assert settings.word(120.0) == word and settings.angle(word) == 120.0
    assert settings.word(90.0) == 0.0 and settings.angle(0.0) == 90.0


@pytest.mark.parametrize(
    ("angle", "to", "expected"), [(10.0, 365.0, 370.0), (350.0, -5.0, -10.0), (0.0, 179.9, 0.0), (0.0, 180.1, 360.0)]
)
def test_an_angle_is_turned_by_whole_turns_to_the_nearest(angle, to, expected):
    assert nearest_turn(angle, to) == pytest.approx(expected)


def test_settings_come_back_from_the_comments_of_a_program_and_bad_ones_are_refused_by_name():
    chosen = Settings(feed=1234.5, axis="A", clockwise=True, inch=True, overcut=2.0, pricks="1,2 3,4")
    text = "\n".join(["%", *chosen.lines(), "G0 X0"])
    assert settings_of(text, "p.ngc") == chosen and settings_of("G0 X0", "p.ngc") is None
    with pytest.raises(DataError, match=r"p\.ngc: its comment 'clockwise = perhaps' cannot be read"):
        settings_of(text.replace("clockwise = yes", "clockwise = perhaps"), "p.ngc")
    with pytest.raises(DataError, match=r"p\.ngc: its comments say feed = 0: allowed range"):
        settings_of(text.replace("feed = 1234.5", "feed = 0"), "p.ngc")
