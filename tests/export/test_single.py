"""Single precision in plain Python against exact fractions: what a ``float`` export is held against."""

import math
from fractions import Fraction

import numpy as np
import pytest

from leadscrew.export.single import F, _floor_divide, _modulo


def test_floor_division_and_remainder_are_exact_whatever_the_rounding_of_the_quotient():
    rng = np.random.default_rng(2)
    for _ in range(2000):
        a, b = F(rng.normal() * 10.0 ** rng.uniform(0, 4)), F(rng.normal() * 10.0 ** rng.uniform(-1, 2))
        exact = Fraction(float(a)) / Fraction(float(b))
        assert float(_floor_divide(a, b)) == math.floor(exact)
        # One rounding where signs differ.
        rest = float(Fraction(float(a)) - math.floor(exact) * Fraction(float(b)))
        assert float(_modulo(a, b)) == pytest.approx(rest, rel=1.2e-7)


@pytest.mark.parametrize(
    ("a", "b", "whole", "rest"), [(7, -2, -4, -1), (-7, 2, -4, 1), (6, 3, 2, 0), (5, 0, 0, 0), (-6, 3, -2, 0)]
)
def test_whole_numbers_divide_as_in_python_and_by_0_give_0(a, b, whole, rest):
    assert (_floor_divide(a, b), _modulo(a, b)) == (whole, rest)
