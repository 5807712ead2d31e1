"""Membership functions against formulas written out with NumPy, and the inverses of the monotonic ones."""

import math

import numpy as np
import pytest

from leadscrew.fuzzy.defuzzifiers import INVERSES
from leadscrew.fuzzy.shapes import PREPARED, membership
from leadscrew.fuzzy.system import SHAPES, Term
from leadscrew.fuzzy.tables import peak
from leadscrew.util.errors import ValueRefused

X = np.concatenate([np.linspace(-4.0, 4.0, 161), [-1e300, 1e300, -np.inf, np.inf]])


def logistic(x, i, s):
    return 1.0 / (1.0 + np.exp(-s * (x - i)))


def smooth(x, a, b):
    t = np.clip((x - a) / (b - a), 0.0, 1.0)
    return np.where(t <= 0.5, 2 * t**2, 1 - 2 * (1 - t) ** 2)


CASES = {
    ("triangle", (-1.0, 0.5, 2.0)): lambda x: np.interp(x, [-1.0, 0.5, 2.0], [0, 1, 0]),
    ("triangle", (-math.inf, 0.5, 2.0)): lambda x: np.interp(x, [0.5, 2.0], [1, 0]),
    ("triangle", (-1.0, 0.5, math.inf)): lambda x: np.interp(x, [-1.0, 0.5], [0, 1]),
    ("triangle", (0.5, 0.5, 2.0)): lambda x: np.where(x < 0.5, 0.0, np.interp(x, [0.5, 2.0], [1, 0])),
    ("trapezoid", (-2.0, -1.0, 1.0, 3.0)): lambda x: np.interp(x, [-2, -1, 1, 3], [0, 1, 1, 0]),
    ("trapezoid", (-math.inf, 0.0, 1.0, 3.0)): lambda x: np.interp(x, [1, 3], [1, 0]),
    ("ramp", (-1.0, 2.0)): lambda x: np.interp(x, [-1, 2], [0, 1]),
    ("ramp", (2.0, -1.0)): lambda x: np.interp(x, [-1, 2], [1, 0]),
    ("ramp", (1.0, 1.0)): np.zeros_like,
    ("rectangle", (-1.0, 2.0)): lambda x: ((x >= -1) & (x <= 2)).astype(float),
    ("binary", (0.5, math.inf)): lambda x: (x >= 0.5).astype(float),
    ("binary", (0.5, -math.inf)): lambda x: (x <= 0.5).astype(float),
    ("gaussian", (0.5, 0.7)): lambda x: np.exp(-((x - 0.5) ** 2) / (2 * 0.49)),
    ("gaussian_product", (-1.0, 0.5, 1.0, 0.8)): lambda x: (
        np.where(x < -1, np.exp(-((x + 1) ** 2) / 0.5), 1.0) * np.where(x > 1, np.exp(-((x - 1) ** 2) / 1.28), 1.0)
    ),
    ("bell", (0.5, 1.5, 2.5)): lambda x: 1 / (1 + np.abs((x - 0.5) / 1.5) ** 5.0),
    ("sigmoid", (0.5, -3.0)): lambda x: logistic(x, 0.5, -3.0),
    ("sigmoid_difference", (-1.0, 4.0, 6.0, 1.0)): lambda x: np.abs(logistic(x, -1, 4) - logistic(x, 1, 6)),
    ("sigmoid_product", (-1.0, 4.0, -6.0, 1.0)): lambda x: logistic(x, -1, 4) * logistic(x, 1, -6),
    ("s_shape", (-1.0, 2.0)): lambda x: smooth(x, -1, 2),
    ("z_shape", (-1.0, 2.0)): lambda x: 1 - smooth(x, -1, 2),
    ("pi_shape", (-2.0, -1.0, 1.0, 3.0)): lambda x: smooth(x, -2, -1) * (1 - smooth(x, 1, 3)),
    ("cosine", (0.5, 3.0)): lambda x: np.where(
        np.abs(x - 0.5) <= 1.5, 0.5 * (1 + np.cos(2 * np.pi / 3 * (np.clip(x, -9, 9) - 0.5))), 0.0
    ),
    ("spike", (0.5, 3.0)): lambda x: np.exp(-np.abs(10 / 3 * (x - 0.5))),
    ("concave", (-1.0, 2.0)): lambda x: np.where(x < 2, 3.0 / (5.0 - np.minimum(x, 2)), 1.0),
    ("concave", (2.0, -1.0)): lambda x: np.where(x > -1, -3.0 / (-4.0 - np.maximum(x, -1)), 1.0),
    ("singleton", (0.5,)): lambda x: (x == 0.5).astype(float),
    ("discrete", (-1.0, 0.2, 0.0, 0.9, 2.0, 0.1)): lambda x: np.interp(x, [-1, 0, 2], [0.2, 0.9, 0.1]),
}


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c[0]}{c[1]}")
def test_a_membership_is_its_formula(case):
    shape, parameters = case
    for height in (1.0, 0.3):
        term = Term("t", shape, parameters, height)
        with np.errstate(all="ignore"):
            expected = height * CASES[case](X)
        np.testing.assert_allclose([membership(term, x) for x in X], expected, atol=4e-15, rtol=4e-15)


def test_every_shape_that_is_a_set_is_checked():
    assert {shape for shape, _ in CASES} == set(SHAPES) - {"constant", "linear"} == {*PREPARED, "discrete"}


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c[0]}{c[1]}")
def test_the_membership_of_nan_is_nan(case):
    assert math.isnan(membership(Term("t", *case), math.nan))


@pytest.mark.parametrize(
    ("shape", "parameters"),
    [("ramp", (-1.0, 2.0)), ("ramp", (2.0, -1.0)), ("sigmoid", (0.3, 2.0)), ("sigmoid", (0.3, -2.0)),
     ("s_shape", (-1.0, 2.0)), ("z_shape", (-1.0, 2.0)), ("concave", (-1.0, 2.0)), ("concave", (2.0, -1.0))],
)  # fmt: skip
def test_an_inverse_is_where_the_set_has_that_membership(shape, parameters):
    term = Term("t", shape, parameters)
    for w in np.linspace(0.01, 0.99, 99):
        x = INVERSES[shape](*parameters, -10.0, 10.0, float(w))
        assert membership(term, x) == pytest.approx(w, abs=1e-13)


@pytest.mark.parametrize("case", [c for c in CASES if c[0] != "ramp" or c[1][0] != c[1][1]], ids=lambda c: str(c))
def test_the_peak_is_where_a_set_is_highest(case):
    term = Term("t", *case)
    if case == ("singleton", (0.5,)):
        assert peak(term, -4.0, 4.0) == 0.5
        return
    xs = np.linspace(-4.0, 4.0, 4001)
    mu = np.array([membership(term, x) for x in xs])
    top = xs[mu >= mu.max() - 1e-5]
    assert membership(term, peak(term, -4.0, 4.0)) >= mu.max() - 1e-5
    assert top[0] - 2e-3 <= peak(term, -4.0, 4.0) <= top[-1] + 2e-3


@pytest.mark.parametrize("case", [("gaussian", (0.0, 0.0)), ("bell", (0.0, 0.0, 1.0)), ("cosine", (0.0, 0.0)),
                                  ("spike", (0.0, 0.0)), ("gaussian_product", (0.0, 1.0, 2.0, 0.0))])  # fmt: skip
def test_a_set_without_width_is_refused(case):
    with pytest.raises(ValueRefused, match=f"a {case[0]} with .* = 0: allowed is any number but zero"):
        membership(Term("t", *case), 0.5)
