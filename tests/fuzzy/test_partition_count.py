"""Equation (10) in all its readings, none of them by default."""

import pytest

from leadscrew.fuzzy.grids import equal_sets_for, interpolation_bound, partition_count
from leadscrew.util.errors import ValueRefused

PAPER = (1.96, 1.35)
CENTRES = (-1.0, -0.67, -0.33, 0.33, 0.67, 1.0)


def test_the_papers_numbers_give_three_six_or_five_depending_on_the_reading():
    count = partition_count(PAPER, 0.05)
    assert (count.half, count.full, count.intervals, count.sets_of_intervals) == (3, 6, 5, 6)


def test_a_reading_must_be_named():
    count = partition_count(PAPER, 0.05)
    assert count.under("full") == 6
    with pytest.raises(ValueRefused, match="half, full, intervals"):
        count.under("paper")


def test_the_printed_centres_guarantee_only_0_18_in_the_middle():
    bound = interpolation_bound(PAPER, CENTRES)
    assert max(bound) == bound[2] == pytest.approx(0.180, abs=5e-4)
    assert equal_sets_for(PAPER, 0.05) == 7
    six_equal = [-1 + 0.4 * i for i in range(6)]
    assert max(interpolation_bound(PAPER, six_equal)) == pytest.approx(0.066, abs=5e-4)


def test_the_bound_holds_for_a_function_with_those_curvatures():
    a, b = PAPER

    def f(x, y):
        return 0.5 * a * x * x + 0.5 * b * y * y

    low, high = -0.33, 0.33
    corners = (f(low, low) + f(low, high) + f(high, low) + f(high, high)) / 4
    assert corners - f(0.0, 0.0) == pytest.approx(max(interpolation_bound(PAPER, CENTRES)))


@pytest.mark.parametrize(("curvatures", "accuracy", "width"), [((-1,), 0.1, 1), (PAPER, 0.0, 1), (PAPER, 0.1, 0.0)])
def test_values_without_a_meaning_are_refused(curvatures, accuracy, width):
    with pytest.raises(ValueRefused):
        partition_count(curvatures, accuracy, width)
