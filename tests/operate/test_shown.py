"""What the explanations of a controller draw, by hand."""

import math

import pytest

from leadscrew.fuzzy.views import rounded_up, triangles


@pytest.mark.parametrize(
    ("x", "end"),
    [(1.0, 1.0), (1.01, 2.0), (2.0, 2.0), (3.0, 5.0), (0.051, 0.1), (70.0, 100.0), (0.0, 1.0), (math.inf, 1.0)],
)
def test_an_axis_ends_at_the_next_1_2_or_5(x, end):
    assert rounded_up(x) == pytest.approx(end)


@pytest.mark.parametrize(
    ("factor", "expected"),
    [
        (2.0, [[[-5, 1], [-2, 1], [0, 0]], [[-2, 0], [0, 1], [4, 0]], [[0, 0], [4, 1], [5, 1]]]),
        # Turned round: the first set is the one of the largest values.
        (-2.0, [[[0, 0], [2, 1], [5, 1]], [[-4, 0], [0, 1], [2, 0]], [[-5, 1], [-4, 1], [0, 0]]]),
    ],
)
def test_the_outer_sets_are_drawn_to_the_ends_of_the_picture(factor, expected):
    assert triangles((-1.0, 0.0, 2.0), factor, -5.0, 5.0) == expected


def test_a_picture_that_ends_at_the_outer_peaks_has_no_shoulders():
    assert triangles((-1.0, 2.0), 1.0, -1.0, 2.0) == [[[-1, 1], [2, 0]], [[-1, 0], [2, 1]]]
