"""GM(1,1): vectors of 60 digits, exact rationals, least squares, and windows that no model fits."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from leadscrew.grey import gm11, vectorised
from leadscrew.grey.gm11 import Grey, exponential
from leadscrew.grey.predictors import KINDS, predicted
from leadscrew.grey.vectorised import MODELS, dgm11
from leadscrew.grey.window import Window, filled, pushed
from tests.grey.references import exact_fit, exact_prediction, least_squares, samples_of, vectors

ROWS = vectors()
FITTED = [r for r in ROWS if r["c"]]
FORCE = st.floats(1.0, 400.0)
FORCES = st.lists(FORCE, min_size=5, max_size=5)


def window(y):
    return Window._make([*map(float, y), 5])


def close(found, printed, scale):
    """Equal to a number of 13 digits: 1e-9 of it, or of the samples where it is a rounded zero."""
    assert abs(found - printed) <= 1e-9 * max(abs(printed), 1e-3 * scale)


def test_the_table_of_vectors_is_whole():
    assert len(ROWS) == 20 and len(FITTED) == 18


@pytest.mark.parametrize("row", FITTED, ids=lambda r: r["name"])
def test_the_vectors(row):
    y = samples_of(row)
    scale, w = max(map(abs, y)), window(y)
    grey, many = gm11.fit(w), vectorised.fit(y)
    for c, u in ((grey.c, grey.u), (float(many.c), float(many.u))):
        close(c, float(row["c"]), 1.0)
        close(u, float(row["u"]), scale)
    close(gm11.ahead(w, grey, 1.0), float(row["pred_next"]), scale)
    close(float(vectorised.gm11(y)), float(row["pred_next"]), scale)
    shifted = float(row["pred_shift150"])
    close(predicted(KINDS["gm11_shifted"], w, 1.0, 0.0, 150.0), shifted, max(scale, 150.0))
    close(float(vectorised.gm11_shifted(y, shift=150.0)), shifted, max(scale, 150.0))
    close(predicted(KINDS["line"], w, 1.0, 0.0, 0.0), float(row["ls4_line"]), scale)
    assert float(exact_fit(y)[2]) == pytest.approx(float(row["D"]), rel=1e-9)


@pytest.mark.parametrize("row", [r for r in ROWS if not r["c"]], ids=lambda r: r["name"])
def test_windows_that_cannot_be_fitted_give_their_last_value(row):
    y = samples_of(row)
    grey = gm11.fit(window(y))
    assert grey.singular and bool(vectorised.fit(y).singular)
    assert gm11.ahead(window(y), grey, 1.0) == y[-1] == float(vectorised.gm11(y))
    assert exact_fit(y)[2] == 0


@given(FORCES)
def test_the_fit_is_that_of_exact_rationals_and_of_least_squares(y):
    c, u, d = exact_fit(y)
    assume(d > 0)
    grey = gm11.fit(window(y))
    # c and u lose the digits that the spread of z does not have; samples of one sign leave them all.
    assert grey.c == pytest.approx(float(c), rel=1e-9, abs=1e-12)
    assert grey.u == pytest.approx(float(u), rel=1e-9)
    assert gm11.ahead(window(y), grey, 1.0) == pytest.approx(exact_prediction(y), rel=1e-9, abs=1e-9)
    assert [grey.c, grey.u] == pytest.approx(least_squares(y).tolist(), rel=1e-8, abs=1e-10)


@pytest.mark.parametrize("horizon", [1, 2, 5])
@pytest.mark.parametrize("length", [4, 5, 6, 7, 12])
def test_windows_of_other_lengths_and_horizons(length, horizon):
    y = np.random.default_rng(length).uniform(100.0, 150.0, (20, length))
    exact = [exact_prediction(row.tolist(), horizon) for row in y]
    assert vectorised.gm11(y, horizon) == pytest.approx(exact, rel=1e-11)
    fitted = vectorised.fit(y)
    expected = np.array([least_squares(row) for row in y])
    assert np.column_stack([fitted.c, fitted.u]) == pytest.approx(expected, rel=1e-9, abs=1e-11)


@given(st.floats(-1e6, 1e6), st.integers(4, 9), st.integers(1, 5))
def test_a_constant_signal_is_predicted_exactly(value, length, horizon):
    assert predicted(KINDS["gm11"], filled(value), horizon, 0.0, 0.0) == value
    assert float(vectorised.gm11([value] * length, horizon)) == pytest.approx(value, rel=1e-15)


@given(FORCES, st.floats(1e-3, 1e3), st.sampled_from(["gm11", "dgm11", "gm11_exponential", "line", "gm11_residual"]))
def test_prediction_follows_unit_and_sign(y, factor, model):
    """Newtons or kilonewtons, pushed or pulled: the prediction scales with the samples."""
    assume(exact_fit(y)[2] > 0)
    kind = KINDS[model]
    one = predicted(kind, window(y), 1.0, 0.0, 0.0)
    assert predicted(kind, window([-v for v in y]), 1.0, 0.0, 0.0) == -one
    scaled = predicted(kind, window([factor * v for v in y]), 1.0, 0.0, 0.0)
    assert scaled == pytest.approx(factor * one, rel=1e-6, abs=1e-9 * factor)


def test_it_is_not_invariant_to_an_offset():
    y = [100.0, 110.0, 120.0, 130.0, 140.0]
    raised = [v + 1000.0 for v in y]
    assert abs(float(vectorised.gm11(raised)) - 1000.0 - float(vectorised.gm11(y))) > 1.0


@pytest.mark.parametrize(
    ("rate", "percent", "digits"), [(-0.3, -1.74, 2), (-0.1, -0.12, 2), (0.1, -0.046, 3), (0.5, 2.5, 1), (1.0, 29.0, 0)]
)
def test_exponentials_are_predicted_with_their_known_bias(rate, percent, digits):
    y = 100.0 * np.exp(-rate * np.arange(6))
    grey = vectorised.fit(y[:5])
    assert float(grey.c) == pytest.approx(2.0 * math.tanh(rate / 2.0), rel=1e-12)
    assert round(100.0 * float(vectorised.gm11(y[:5]) / y[5] - 1.0), digits) == percent
    assert float(vectorised.gm11_exponential(y[:5])) == pytest.approx(y[5], rel=1e-12)
    assert float(dgm11(y[:5])) == pytest.approx(y[5], rel=1e-12)


def test_dgm_is_the_corrected_model_on_exponentials_only():
    """Both are exact there; on a straight line they weigh the errors differently."""
    y = [100.0, 110.0, 120.0, 130.0, 140.0]
    apart = float(MODELS["gm11_exponential"](y) - MODELS["dgm11"](y))
    assert 1e-3 < abs(apart) < 1e-2


@pytest.mark.parametrize("model", list(KINDS))
@pytest.mark.parametrize("length", range(5))
def test_before_five_samples_the_last_value_is_the_prediction(model, length):
    w = Window()
    for y in (3.0, 8.0, 2.0, 9.0)[:length]:
        w = pushed(w, y)
    assert predicted(KINDS[model], w, 1.0, 150.0, 150.0) == (0.0, 3.0, 8.0, 2.0, 9.0)[length]


@pytest.mark.parametrize("model", list(KINDS))
@pytest.mark.parametrize(
    "y",
    [
        (0, 0, 0, 0, 0), (0, 0, 0, 0, 1), (5, 1, -1, 1, -1), (5, 1, -1, 1, -1 - 1e-9), (0, 0, 0, 1, 5), (1, 0, 0, 0, 0),
        (-2, -1, 0, 1, 2), (1e-200, 1e-200, 0, 0, 1e-200), (1e6, -1e6, 1e6, -1e6, 1e6 + 1e-3), (0.01, 0, 0, 0, 5),
        (3, -1, 1, -1, 1), (1, -2, 2, -2, 2.0001),
    ],
)  # fmt: skip
def test_no_window_gives_anything_but_a_finite_number(model, y):
    w = window(y)
    for horizon in (1.0, 2.0, 8.0):
        step = predicted(KINDS[model], w, horizon, 150.0, 150.0)
        options = {"gm11_shifted": {"shift": 150.0}, "gm11_clamped": {"reference": 150.0}}.get(model, {})
        with np.errstate(all="raise", under="ignore"):
            many = float(MODELS[model](np.array(y, dtype=float), horizon, **options))
        assert math.isfinite(step) and math.isfinite(many)


def test_leading_zeros_and_a_change_of_sign_are_predicted_wildly():
    assert float(vectorised.gm11([0, 0, 0, 0, 1])) == 0.0 and float(vectorised.fit([0, 0, 0, 0, 1]).c) == -2.0
    assert round(float(vectorised.gm11([0, 0, 0, 1, 5]))) == 55 and float(MODELS["line"]([0, 0, 0, 1, 5])) == 5.5
    assert round(float(vectorised.gm11([-2, -1, 0, 1, 2]))) == 121


@given(FORCES, st.sampled_from(list(KINDS)), st.sampled_from([1.0, 2.0, 3.0]))
def test_steps_and_arrays_agree(y, model, horizon):
    options = {"gm11_shifted": {"shift": 150.0}, "gm11_clamped": {"reference": 150.0}}.get(model, {})
    step = predicted(KINDS[model], window(y), horizon, 150.0, 150.0)
    many = float(MODELS[model](np.array(y), horizon, **options))
    assert many == pytest.approx(step, rel=1e-6, abs=1e-6 * max(y))


def test_the_printed_inverse_has_the_wrong_sign():
    y = 100.0 * np.exp(0.1 * np.arange(5))
    assert round(float(vectorised.gm11(y)), 3) == 164.673
    assert float(vectorised.gm11_printed(y)) == pytest.approx(-float(vectorised.gm11(y)), rel=1e-14)
    assert predicted(KINDS["gm11_printed"], window(y), 1.0, 0.0, 0.0) == pytest.approx(-164.673054, rel=1e-8)


def test_the_reading_one_index_late_restores_the_newest_sample():
    y = 100.0 * np.exp(0.1 * np.arange(5))
    late, now = float(MODELS["gm11_off_by_one"](y)), float(vectorised.gm11(y))
    assert now / late == pytest.approx(math.exp(-float(vectorised.fit(y).c)), rel=1e-12)
    assert late == pytest.approx(y[-1], rel=2e-3)


@pytest.mark.parametrize(("rate", "percent"), [(0.1, 5.1), (-0.1, -4.9)])
def test_the_derivative_is_five_percent_off_unless_taken_mid_interval(rate, percent):
    y = 100.0 * np.exp(rate * np.arange(5))
    assert 100.0 * float(MODELS["gm11_derivative"](y) / vectorised.gm11(y) - 1.0) == pytest.approx(percent, abs=0.1)
    assert float(MODELS["gm11_derivative"](y, 0.5)) == pytest.approx(float(vectorised.gm11(y)), rel=1e-3)


def test_the_guards():
    steep, calm = window([12.5, 38.2, 69.7, 98.4, 230.0]), window([150.0, 150.5, 149.8, 150.2, 149.9])
    assert abs(gm11.fit(steep).c) > 0.5
    assert predicted(KINDS["gm11_guarded"], steep, 1.0, 0.0, 0.0) == 230.0
    raw = predicted(KINDS["gm11"], calm, 1.0, 0.0, 0.0)
    assert predicted(KINDS["gm11_guarded"], calm, 1.0, 0.0, 0.0) == raw
    assert predicted(KINDS["gm11_clamped"], calm, 1.0, 150.0, 0.0) == raw
    assert predicted(KINDS["gm11_clamped"], steep, 1.0, 150.0, 0.0) == 300.0
    assert predicted(KINDS["gm11_clamped"], window([-v for v in range(1, 6)]), 1.0, 150.0, 0.0) == 0.0
    assert predicted(KINDS["gm11_clamped"], window([-v for v in range(1, 6)]), 1.0, -1.0, 0.0) == -2.0


@pytest.mark.parametrize("c", [-2.4, -2.0, 2.0, 2.4])
def test_where_no_exponential_has_such_a_coefficient_the_last_sample_is_predicted(c):
    assert exponential(Window(1.0, 2.0, 3.0, 4.0, 7.5), Grey(c, 1.0, False), 1) == 7.5
