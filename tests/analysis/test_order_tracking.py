"""Orders of a turning spindle: amplitudes that follow a speed, known, measured or estimated."""

import numpy as np
import pytest

from leadscrew.analysis.order_tracking import angle, speed_trace, track_orders, vold_kalman
from leadscrew.util.errors import DataError, ValueRefused

pytestmark = pytest.mark.slow

RATE, SECONDS = 2000.0, 10.0
T = np.arange(int(RATE * SECONDS)) / RATE
RPM = 1000.0 * (1.0 + 0.02 * np.sin(2 * np.pi * 0.1 * T))
THETA = 2 * np.pi * 1000.0 / 60.0 * (T + 0.02 * (1.0 - np.cos(2 * np.pi * 0.1 * T)) / (2 * np.pi * 0.1))
"""The integral of the speed in closed form."""
RUNOUT = 1.0 + 0.05 * T


def record(noise=0.0):
    y = RUNOUT * np.cos(THETA + 0.3) + 0.4 * np.cos(2 * THETA - 1.0)
    return y + noise * np.random.default_rng(1).normal(size=len(T))


def test_the_angle_is_the_integral_of_the_speed():
    assert np.max(np.abs(angle_of(RPM) - THETA)) < 1e-5
    assert angle_of(1200.0)[-1] == pytest.approx(2 * np.pi * 20.0 * T[-1])


def angle_of(rpm):
    from leadscrew.analysis.harmonics import sampling

    return angle(sampling(T), rpm)


def test_windows_follow_amplitude_and_phase_through_a_changing_speed():
    found = track_orders(T, record(), RPM, (1, 2))
    assert found.amplitudes[0] == pytest.approx(1.0 + 0.05 * found.time, abs=2e-3)
    assert found.amplitudes[1] == pytest.approx(np.full(len(found.time), 0.4), abs=2e-3)
    assert found.phases[0] == pytest.approx(np.full(len(found.time), 0.3), abs=3e-3)
    assert found.phases[1] == pytest.approx(np.full(len(found.time), -1.0), abs=3e-3)
    assert found.rpm == pytest.approx(np.interp(found.time, T, RPM), abs=0.5)


def test_without_the_speed_a_plain_spectrum_smears_what_the_tracking_tells():
    from leadscrew.analysis.harmonics import spectrum

    smeared = spectrum(T, record(), "hann").amplitude((2000.0 / 60.0,))[0]
    assert smeared < 0.2
    assert track_orders(T, record(), RPM, (1, 2)).amplitudes[1].mean() == pytest.approx(0.4, abs=1e-3)


def test_the_standard_deviation_is_the_scatter_over_windows():
    found = track_orders(T, record(0.2), RPM, (1, 2), overlap=0.0)
    assert found.amplitudes[1].std() == pytest.approx(found.sd[1].mean(), rel=0.35)


def test_vold_kalman_follows_at_every_sample():
    found = vold_kalman(T, record(0.05), RPM, (1, 2), bandwidth=1.0)
    inner = slice(2000, -2000)
    assert np.max(np.abs(found.amplitudes[0] - RUNOUT)[inner]) < 0.02
    assert np.max(np.abs(found.amplitudes[1] - 0.4)[inner]) < 0.02
    assert np.mean(found.phases[0][inner]) == pytest.approx(0.3, abs=5e-3)
    assert np.isnan(found.sd).all()


@pytest.mark.parametrize("poles", [1, 2])
def test_the_bandwidth_is_where_a_change_of_amplitude_is_halved_in_power(poles):
    for frequency, kept in ((0.25, 0.85), (0.5, 1.0 / np.sqrt(2.0)), (2.0, 0.0)):
        y = (1.0 + 0.1 * np.sin(2 * np.pi * frequency * T)) * np.cos(2 * np.pi * 20.0 * T)
        middle = vold_kalman(T, y, 1200.0, (1,), bandwidth=1.0, poles=poles).amplitudes[0][4000:16000]
        swing = (middle.max() - middle.min()) / 0.2
        if kept == 0.0:
            assert swing < 0.15
        elif frequency == 0.5:
            assert swing == pytest.approx(kept, abs=0.01)
        else:
            assert swing > kept


def test_close_orders_part():
    y = np.cos(THETA) + 0.5 * np.cos(1.1 * THETA + 1.0)
    assert track_orders(T, y, RPM, (1, 1.1), revolutions=20.0).amplitudes[1] == pytest.approx(0.5, abs=1e-3)
    middle = vold_kalman(T, y, RPM, (1, 1.1), bandwidth=0.5).amplitudes[1][4000:-4000]
    assert middle == pytest.approx(np.full(len(middle), 0.5), abs=0.01)


def test_an_unknown_speed_within_two_percent_is_found_and_then_serves_the_tracking():
    trace = speed_trace(T, record(0.1), 1000.0, (1, 2), within=0.03, window=1.0)
    assert np.max(np.abs(trace.rpm - np.interp(trace.time, T, RPM))) < 0.6
    assert np.all(trace.sd < 0.3)
    found = track_orders(T, record(0.1), trace.at(T), (1, 2))
    assert found.amplitudes[1] == pytest.approx(np.full(len(found.time), 0.4), abs=0.03)


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"rpm": 24000.0, "orders": (1, 4)}, "order 4 at 24000 1/min is 1600 Hz, .* folds to 400 Hz"),
        ({"rpm": -1.0}, "expected positive speeds"),
        ({"rpm": np.ones(5)}, r"one a sample \(20000\)"),
        ({"orders": (1, 1)}, "each once"),
        ({"revolutions": 0.5}, "at least 1 revolutions"),
        ({"orders": (1, 1.1)}, "at least 10 revolutions"),
        ({"revolutions": 500.0}, "the record holds 167 revolutions"),
        ({"overlap": 1.0}, "overlap"),
    ],
)
def test_what_the_record_cannot_tell_is_refused(asked, says):
    with pytest.raises(ValueRefused, match=says):
        track_orders(**({"t": T, "y": record(), "rpm": 1000.0, "orders": (1, 2)} | asked))


def test_bad_filters_and_speeds_are_refused():
    with pytest.raises(ValueRefused, match=r"allowed range is \[0.2, 1000\) Hz"):
        vold_kalman(T, record(), 1000.0, (1,), bandwidth=0.1)
    with pytest.raises(ValueRefused, match="poles = 3"):
        vold_kalman(T, record(), 1000.0, (1,), poles=3)
    with pytest.raises(ValueRefused, match="one record at a time"):
        vold_kalman(T, np.zeros((2, len(T))), 1000.0, (1,))
    with pytest.raises(ValueRefused, match="window = 20"):
        speed_trace(T, record(), 1000.0, (1,), window=20.0)
    with pytest.raises(DataError, match="no fundamental within 1 %"):
        speed_trace(T, np.cos(2 * np.pi * 20.0 * T), 1170.0, (1,), within=0.01, window=1.0)
