"""Orders of a short run-up, in milliseconds: exact where the model is exact, and against SciPy's curve fit."""

import numpy as np
import pytest
from scipy.optimize import curve_fit

from leadscrew.analysis.harmonics import sampling
from leadscrew.analysis.order_tracking import angle, track_orders, vold_kalman

T = np.arange(1000) / 500.0
RPM = 600.0 + 300.0 * T
THETA = 2.0 * np.pi * (10.0 * T + 2.5 * T**2)
"""From 10 to 20 turns a second in 2 s: 30 turns."""


def test_a_steady_run_up_turns_by_half_of_its_acceleration_times_the_square_of_the_time():
    assert angle(sampling(T), RPM) == pytest.approx(THETA, abs=1e-9)


def test_a_pure_run_up_gives_back_amplitudes_phases_and_speed():
    y = 3.0 + T + 1.5 * np.cos(THETA + 0.4) + 0.25 * np.cos(2.0 * THETA - 1.0)
    found = track_orders(T, y, RPM, (1, 2), revolutions=5.0, overlap=0.5)
    assert len(found.time) == 10, "30 turns, a window of 5 every 2.5: 11, of which the last needs a sample more"
    assert found.amplitudes == pytest.approx(np.repeat([[1.5], [0.25]], 10, axis=1), abs=1e-9)
    assert found.phases == pytest.approx(np.repeat([[0.4], [-1.0]], 10, axis=1), abs=1e-9)
    assert found.rpm == pytest.approx(np.interp(found.time, T, RPM), abs=1e-6)
    assert np.abs(found.sd).max() < 1e-9


def test_the_standard_deviation_of_an_amplitude_is_that_of_scipys_fit_of_amplitude_and_phase():
    y = 1.5 * np.cos(THETA + 0.4) + 0.2 * np.random.default_rng(2).standard_normal(len(T))
    found = track_orders(T, y, RPM, (1,), revolutions=4.0, overlap=0.0)
    turns = THETA / (2.0 * np.pi)
    for k in range(3):
        inside = (turns >= 4.0 * k - 1e-9) & (turns < 4.0 * (k + 1) - 1e-9)

        def model(theta, amplitude, phase, offset, slope):
            return amplitude * np.cos(theta + phase) + offset + slope * np.linspace(-1.0, 1.0, len(theta))

        best, covariance = curve_fit(model, THETA[inside], y[inside], (1.0, 0.0, 0.0, 0.0))
        assert (found.amplitudes[0, k], found.phases[0, k]) == pytest.approx(best[:2], rel=1e-5)
        # the product of cosine and sine over a window is left out: 0.1 %; a freedom more would be 0.6 %
        assert found.sd[0, k] == pytest.approx(np.sqrt(covariance[0, 0]), rel=2e-3)


@pytest.mark.parametrize("poles", [1, 2])
def test_the_filter_passes_half_of_the_power_of_a_change_of_amplitude_at_half_its_bandwidth(poles):
    t = np.arange(1200) / 200.0
    y = (1.0 + 0.1 * np.sin(2.0 * np.pi * 1.0 * t)) * np.cos(2.0 * np.pi * 25.0 * t)
    middle = vold_kalman(t, y, 1500.0, (1,), bandwidth=2.0, poles=poles).amplitudes[0][300:900]
    # of one pole the image of the order, 50 Hz away, still ripples by 1 %
    assert 0.5 * np.ptp(middle) / 0.1 == pytest.approx(np.sqrt(0.5), abs=0.015)
