"""Lines, DGM(1,1), Verhulst and residual correction against polynomials, matrices and differential equations."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from leadscrew.grey import others
from leadscrew.grey.predictors import KINDS, predicted
from leadscrew.grey.vectorised import MODELS, ahead, fit, gm11, limit, predictions
from leadscrew.grey.window import Window
from leadscrew.util.errors import NameUnknown, ValueRefused

FORCES = st.lists(st.floats(1.0, 400.0), min_size=5, max_size=5)
RISE = (60.0, 98.0, 122.0, 135.0, 143.0)


@given(FORCES, st.sampled_from([1, 2, 4]))
def test_the_line_is_a_polynomial_fit_of_the_last_four(y, horizon):
    expected = np.polyval(np.polyfit([-3, -2, -1, 0], y[1:], 1), horizon)
    assert others.line(Window._make([*y, 5]), horizon) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert float(MODELS["line"](y, horizon)) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_the_two_point_predictor_goes_on_as_the_last_two():
    assert others.two_point(Window(0.0, 0.0, 0.0, 3.0, 5.0, 5), 3.0) == 11.0
    assert float(MODELS["two_point"]([9.0, 0.0, 3.0, 5.0], 3)) == 11.0


@given(FORCES, st.sampled_from([1, 3]))
def test_dgm_is_least_squares_of_sums_on_sums(y, horizon):
    sums = np.cumsum(y)
    b, d = np.linalg.lstsq(np.column_stack([sums[:-1], np.ones(4)]), sums[1:], rcond=None)[0]
    step = others.dgm(Window._make([*y, 5]), horizon)
    if b <= 1e-3:
        return
    s = [y[0]]
    for _ in range(4 + horizon):
        s.append(b * s[-1] + d)
    assert step == pytest.approx(s[-1] - s[-2], rel=1e-6, abs=1e-7)


def test_dgm_does_not_alternate():
    """5, 1, -1, 1, -1 has the ratio -1: no exponential."""
    assert others.dgm(Window(5.0, 1.0, -1.0, 1.0, -1.0, 5), 1.0) == -1.0


def test_verhulst_follows_its_differential_equation_from_the_newest_sample():
    y = np.array(RISE)
    m, d = 0.5 * (y[1:] + y[:-1]), np.diff(y)
    a, b = np.linalg.lstsq(np.column_stack([-m, m * m]), d, rcond=None)[0]
    for horizon in (1.0, 3.0):
        solved = solve_ivp(lambda t, v: -a * v + b * v * v, (0.0, horizon), [y[-1]], rtol=1e-11, atol=1e-11)
        assert others.verhulst(Window(*RISE, 5), horizon) == pytest.approx(solved.y[0, -1], rel=1e-8)
        assert float(MODELS["verhulst"](y, horizon)) == pytest.approx(solved.y[0, -1], rel=1e-8)


def test_verhulst_levels_off_where_gm_runs_on():
    """A logistic rise to 150: far ahead one stays near the limit, the other does not."""
    y = 150.0 / (1.0 + 1.5 * np.exp(-0.6 * np.arange(25)))
    near = float(MODELS["verhulst"](y[:5], 20.0))
    assert near == pytest.approx(150.0, rel=0.03)
    assert float(gm11(y[:5], 20.0)) > 1000.0


def test_verhulst_without_growth_or_towards_infinity_gives_the_last_value():
    assert others.verhulst(Window(7.0, 7.0, 7.0, 7.0, 7.0, 5), 1.0) == 7.0
    assert others.verhulst(Window(1.0, 1.2, 1.7, 3.0, 12.0, 5), 3.0) == 12.0


def test_the_residual_model_adds_a_grey_model_of_the_residuals():
    y = np.array([12.5, 38.2, 69.7, 98.4, 120.9])
    fitted = fit(y)
    restored = [float(ahead(y, fitted, j - 4)) for j in range(1, 5)]
    errors = y[1:] - restored
    sizes = np.abs(errors)
    added = min(max(float(gm11(sizes)), 0.0), sizes.max()) * math.copysign(1.0, errors[-1])
    expected = float(gm11(y)) + added
    assert float(MODELS["gm11_residual"](y)) == pytest.approx(expected, rel=1e-12)
    assert predicted(KINDS["gm11_residual"], Window._make([*y.tolist(), 5]), 1.0, 0.0, 0.0) == pytest.approx(
        expected, rel=1e-9
    )
    assert abs(added) > 0.1


def test_predictions_of_a_signal_are_made_from_its_past_alone():
    y = np.cumsum(np.random.default_rng(1).normal(size=40)) + 100.0
    whole = predictions(y, "gm11", length=6, horizon=2)
    assert whole[:5].tolist() == y[:5].tolist()
    for i in range(5, 40):
        assert whole[i] == pytest.approx(float(gm11(y[i - 5 : i + 1], 2)), rel=1e-12)
    changed = y.copy()
    changed[30:] = 0.0
    assert predictions(changed, "gm11", 6, 2)[:30].tolist() == whole[:30].tolist()


def test_what_is_refused():
    with pytest.raises(ValueRefused, match="3 samples: GM"):
        gm11([1.0, 2.0, 3.0])
    with pytest.raises(ValueRefused, match="3 samples"):
        limit(3)
    with pytest.raises(ValueRefused, match="no window of 5"):
        predictions([1.0, 2.0], "gm11")
    with pytest.raises(NameUnknown, match="gm11_shifted"):
        predictions(range(9), "grey")
