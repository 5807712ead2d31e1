"""What the linear stage does to a log before it fits: differences, windows, signs, delays."""

from __future__ import annotations

import numpy as np
import pytest

from leadscrew.identify.axis.record import (
    choose_length,
    corner_of,
    held,
    length_of,
    record,
    samples,
    smoothed,
    touched,
    window,
)
from leadscrew.util.errors import DataError

DT = 1e-3


def test_a_parabola_has_its_acceleration_at_every_sample_and_under_every_window():
    t = np.arange(1000) * DT
    s = samples(record(DT, 0.02 + 0.1 * t + 0.5 * 3.0 * t**2, np.ones(1000)))
    assert np.allclose(s.acceleration, 3.0, rtol=1e-6)
    assert np.allclose(s.speed, 0.1 + 3.0 * t[1:-1], rtol=1e-9)
    assert np.allclose(smoothed(s.acceleration, 50, 7), 3.0, rtol=1e-6)


def test_a_steplike_force_and_the_motion_it_makes_belong_together_exactly():
    """A mass of 2 kg under a held force that jumps at random: every row says 2 kg, whatever the window."""
    rng = np.random.default_rng(1)
    force = rng.normal(0.0, 10.0, 2000)
    v = np.concatenate([[0.0], np.cumsum(force / 2.0 * DT)])[:-1]
    x = np.concatenate([[0.0], np.cumsum(v * DT + 0.5 * force / 2.0 * DT**2)])[:-1]
    s = samples(record(DT, x, force))
    assert np.allclose(2.0 * s.acceleration, held(force), atol=1e-6)
    for length in (5, 40):
        assert np.allclose(2.0 * smoothed(s.acceleration, length, 3), smoothed(held(force), length, 3), atol=1e-6)


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 2.75])
def test_a_held_force_that_acts_late_is_weighed_by_the_time_it_acts(delay):
    """Against the triangle integrated over the force in a thousand parts of a period."""
    force = np.random.default_rng(2).normal(size=30)
    fine = (np.arange(30_000) + 0.5) / 1000.0
    acting = force[np.clip(np.floor(fine - delay).astype(int), 0, None)]
    expected = [np.mean(acting * np.maximum(1.0 - np.abs(fine - k), 0.0)) * 30.0 for k in range(5, 28)]
    assert np.allclose(held(force, delay)[4:27], expected, atol=2e-3)


@pytest.mark.parametrize("length", [20, 75])
def test_the_window_has_its_corner_where_it_says(length):
    from scipy.signal import freqz

    _, gain = freqz(window(length), worN=[2.0 * np.pi * corner_of(length, DT) * DT])
    assert 20.0 * np.log10(abs(gain[0])) == pytest.approx(-3.01, abs=0.03)
    assert length_of(corner_of(length, DT), DT) == length


def test_a_noisier_scale_gets_a_longer_window():
    t = np.arange(8000) * DT
    x = 0.05 * np.sin(2.0 * np.pi * 0.8 * t)
    lengths = []
    for count in (1e-8, 1e-6, 1e-5):
        lengths.append(choose_length(record(DT, np.round(x / count) * count, np.ones(8000))))
    assert lengths[0] < lengths[1] < lengths[2]


def test_rows_that_touch_a_standstill_are_found_to_the_sample():
    flags = np.zeros(30, dtype=bool)
    flags[12] = True
    rows = touched(flags, 5, 1)
    assert np.flatnonzero(rows).tolist() == [8, 9, 10, 11, 12]


def test_an_axis_at_rest_counts_as_slow_and_a_moving_one_does_not():
    t = np.arange(3000) * DT
    x = np.where(t < 1.0, 0.0, 0.1 * (t - 1.0))
    slow = samples(record(DT, np.round(x / 1e-6) * 1e-6, np.ones(3000))).slow
    assert slow[:950].all() and not slow[1100:].any()


def test_the_noise_of_a_scale_is_that_of_rounding_and_of_what_is_added():
    rng = np.random.default_rng(3)
    x = 0.03 * np.sin(2.0 * np.pi * np.arange(9000) * DT)
    counts = record(DT, np.round(x / 1e-6) * 1e-6, np.ones(9000))
    assert counts.count == pytest.approx(1e-6) and counts.noise == pytest.approx(1e-6 / np.sqrt(12.0), rel=0.3)
    noisy = record(DT, x + rng.normal(0.0, 2e-6, 9000), np.ones(9000))
    assert noisy.noise == pytest.approx(2e-6, rel=0.25)


def test_a_standstill_and_a_short_log_are_refused():
    with pytest.raises(DataError, match="is constant"):
        record(DT, np.ones(500), np.ones(500))
    with pytest.raises(DataError, match="at least 300"):
        record(DT, np.arange(20.0), np.ones(20))
