"""What the lathe study tries with the grating ruler, against numbers that do not come from its code."""

import math

import numpy as np
import pytest

from leadscrew.identify.heydemann import fit_ellipse
from leadscrew.sensors.grating._counting import analytic_counts, counted
from leadscrew.sensors.grating._moire import GRATING, fringe_width
from leadscrew.sensors.grating._quadrature import PERFECT, interpolation_error, quadrature
from leadscrew.studies.vud_lathe.laws import ANGLE_RAD, POINTS, SEED, TRIAL, crossed_period_mm


def test_the_fringe_is_that_of_the_wave_vectors_with_the_pitch_and_not_with_the_number_of_grooves():
    assert crossed_period_mm(100.0, ANGLE_RAD) == pytest.approx(0.01 / (2.0 * math.sin(ANGLE_RAD / 2.0)))
    assert fringe_width(GRATING.pitch_mm, ANGLE_RAD) == pytest.approx(crossed_period_mm(100.0, ANGLE_RAD))


def test_the_counter_and_the_count_in_one_go_agree_both_ways():
    x = np.concatenate([np.linspace(0.0, 1.25, 5000), np.linspace(1.25, -0.35, 5000)])
    for errors, noise in ((PERFECT, 0.0), (TRIAL, 0.02)):
        u, v = quadrature(x, errors=errors, noise=noise, seed=SEED)
        assert np.array_equal(counted(u, v), analytic_counts(x, interpolation_error(x, u, v)))


def test_what_the_correction_leaves_is_the_noise():
    """Noise s on both signals is s pitch / (2 pi) on the position."""
    for noise in (0.005, 0.02):
        x = GRATING.pitch_mm * np.arange(POINTS) / POINTS
        u, v = quadrature(x, errors=TRIAL, noise=noise, seed=SEED)
        left = 1000.0 * interpolation_error(x, *fit_ellipse(u, v).corrected(u, v)).std()
        assert left == pytest.approx(noise * 10.0 / (2.0 * np.pi), rel=0.05)
