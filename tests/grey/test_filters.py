"""What GM(1,1) is near a set-point: a fixed filter, whose numbers are worked by hand or simulated."""

import numpy as np
import pytest

from leadscrew.grey.filters import lead, linearised, noise_gain, response
from leadscrew.grey.vectorised import MODELS, gm11, limit
from leadscrew.util.errors import ValueRefused

WEIGHTS = [0.0, -0.5, 0.0, 0.5, 1.0]


@pytest.mark.parametrize("level", [150.0, -150.0, 1e-3, 1e6])
def test_near_any_level_the_model_has_the_weights_of_the_line(level):
    assert linearised(level) == pytest.approx(WEIGHTS, abs=1e-8)
    assert linearised(level, 4) == pytest.approx([0.0, -2 / 3, 1 / 3, 4 / 3], abs=1e-8)
    for length, horizon in ((5, 2.0), (7, 1.0), (9, 3.0)):
        assert linearised(level, length, horizon) == pytest.approx(limit(length, horizon), abs=1e-7)


@pytest.mark.parametrize("model", ["dgm11", "gm11_exponential"])
def test_the_models_without_bias_have_the_same_limit(model):
    assert linearised(150.0, model=MODELS[model]) == pytest.approx(WEIGHTS, abs=1e-8)


def test_noise_at_a_set_point_is_amplified_by_the_root_of_one_and_a_half():
    assert noise_gain(WEIGHTS) == pytest.approx(np.sqrt(1.5), rel=1e-15)
    assert noise_gain(limit(4)) == pytest.approx(1.53, abs=0.005)
    assert noise_gain([-1.0, 2.0]) == pytest.approx(2.24, abs=0.005)
    noise = 0.5 * np.random.default_rng(3).normal(size=(200_000, 5))
    measured = (gm11(150.0 + noise) - 150.0).std() / 0.5
    assert measured == pytest.approx(np.sqrt(1.5), rel=0.01)


def test_gain_and_lead_of_the_filter():
    frequency = np.linspace(1e-4, np.pi, 100_001)
    h = response(WEIGHTS, frequency)
    low = frequency < np.pi / 4
    assert abs(h).max() == pytest.approx(1.80, abs=0.005)
    assert np.degrees(np.angle(h[low])).max() == pytest.approx(12.1, abs=0.05)
    # sin 3w = sin w: the phase crosses zero at 45 and 135 degrees a sample.
    assert np.angle(response(WEIGHTS, [np.pi / 4, 3 * np.pi / 4])) == pytest.approx([0.0, 0.0], abs=1e-15)
    assert lead(WEIGHTS) == 1.0 and lead(limit(7, 3.0)) == pytest.approx(3.0, rel=1e-14)


def test_the_response_is_that_of_a_filtered_sine():
    w = 0.6
    k = np.arange(400)
    signal = np.cos(w * k)
    filtered = np.convolve(signal, WEIGHTS[::-1])[:400]
    fitted = np.linalg.lstsq(np.column_stack([np.cos(w * k), -np.sin(w * k)])[10:], filtered[10:], rcond=None)[0]
    assert complex(*fitted) == pytest.approx(complex(response(WEIGHTS, w)), abs=1e-12)


@pytest.mark.parametrize("level", [0.0, np.inf, np.nan])
def test_there_is_no_filter_around_zero(level):
    with pytest.raises(ValueRefused, match="level"):
        linearised(level)
