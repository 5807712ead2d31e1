"""The grating ruler's fringe, its signals with errors, and Heydemann's correction of a logged pair."""

import math

import numpy as np
import pytest

from leadscrew.identify.heydemann import fit_ellipse, fit_log
from leadscrew.kernel.noise import Noise
from leadscrew.plants._lathe_servo import LathePosition
from leadscrew.sensors.grating._moire import GRATING, fringe_width, magnification, small_angle_error
from leadscrew.sensors.grating._quadrature import (
    PERFECT,
    SignalErrors,
    first_order_error,
    interpolation_error,
    quadrature,
)
from leadscrew.sensors.grating._ruler import grating_ruler
from leadscrew.util.errors import DataError, ValueRefused

ONE_PITCH = 0.01 * np.arange(720) / 720
SPREAD_OVER = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
TRIAL = SignalErrors(0.05, -0.03, 0.1, math.radians(5.0))


@pytest.mark.parametrize("degrees", [0.5, 5.0, 60.0])
def test_the_fringe_is_as_wide_as_the_dark_bands_of_two_gratings_laid_over_each_other(degrees):
    angle, pitch = math.radians(degrees), 0.01
    width = fringe_width(pitch, angle)
    y = np.linspace(0.0, 8.0 * width, 1 << 16)  # along the bisector's normal: both gratings cross it alike
    first = np.cos(2.0 * np.pi * y * math.sin(+0.5 * angle) / pitch)
    second = np.cos(2.0 * np.pi * y * math.sin(-0.5 * angle) / pitch + 1.0)
    spectrum = np.abs(np.fft.rfft((first - second) ** 2 - np.mean((first - second) ** 2)))
    assert np.argmax(spectrum) == 8  # eight bands in eight widths


def test_magnification_by_hand_and_where_the_short_form_ends():
    assert magnification(math.radians(0.1)) == pytest.approx(572.958, abs=1e-3)
    assert fringe_width(0.01, math.pi) == pytest.approx(0.005)  # lines against each other: half a pitch
    for angle in (1e-3, 0.05, 0.3):
        assert small_angle_error(angle) == pytest.approx(angle**2 / 24.0, rel=angle**2)


def test_an_angle_or_a_pitch_that_no_grating_has_is_refused():
    for angle in (0.0, -0.1, 4.0, math.nan):
        with pytest.raises(ValueRefused, match="angle_rad"):
            fringe_width(0.01, angle)
    for pitch in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ValueRefused, match="pitch_mm"):
            fringe_width(pitch, 0.1)


def test_the_data_of_the_ruler_give_the_count_and_the_rates():
    assert GRATING.pitch_mm == 0.01 and GRATING.resolution_mm == 0.000625
    assert GRATING.fringe_rate_hz(-258.7) == pytest.approx(25870.0)
    assert GRATING.count_rate_hz(258.7) == pytest.approx(413920.0)


@pytest.mark.parametrize("name", SignalErrors._fields)
def test_the_first_order_formula_is_the_slope_of_the_exact_error(name):
    small = SignalErrors(**{name: 1e-6})
    exact = interpolation_error(ONE_PITCH, *quadrature(ONE_PITCH, errors=small))
    formula = first_order_error(ONE_PITCH, errors=small)
    assert np.abs(formula).max() > 5e-10
    np.testing.assert_allclose(exact, formula, atol=2e-5 * np.abs(formula).max())


def test_signals_are_what_their_equations_say_at_points_worked_by_hand():
    errors = SignalErrors(offset_u=0.1, offset_v=-0.2, gain=0.5, phase=math.pi / 6, harmonic=0.02)
    u, v = quadrature([0.0, 0.0025, -0.0025], errors=errors)  # phi = 0, 90, -90 degrees
    np.testing.assert_allclose(u, [0.1, 0.1 + 1.0 - 0.02, 0.1 - 1.0 + 0.02], atol=1e-12)
    np.testing.assert_allclose(v, [-0.2 + 1.5 * math.sqrt(0.75) + 0.02, -0.2 - 0.75, -0.2 + 0.75], atol=1e-12)


def test_far_from_zero_the_signals_are_those_of_the_same_place_in_the_pitch():
    near, far = quadrature([0.0031]), quadrature([170.0031])
    np.testing.assert_allclose(far, near, atol=1e-8)


@pytest.mark.parametrize("volts", [1.0, 2.5])
@pytest.mark.parametrize("errors", [PERFECT, TRIAL, SignalErrors(-0.2, 0.3, -0.3, -0.5)])
def test_the_ellipse_gives_back_the_errors_that_made_it(volts, errors):
    u, v = quadrature(ONE_PITCH, errors=errors)
    fit = fit_ellipse(volts * u, volts * v)
    found = (fit.offset_u, fit.offset_v, fit.amplitude_u, fit.amplitude_v / fit.amplitude_u - 1.0, fit.phase)
    expected = (volts * errors.offset_u, volts * errors.offset_v, volts, errors.gain, errors.phase)
    assert found == pytest.approx(expected, abs=1e-12)
    assert fit.scatter < 1e-12
    assert np.abs(interpolation_error(ONE_PITCH, *fit.corrected(volts * u, volts * v))).max() < 1e-12


def test_five_samples_are_enough_and_noise_averages_out():
    places = [0.0, 0.0017, 0.0041, 0.0066, 0.0084]
    assert fit_ellipse(*quadrature(places, errors=TRIAL)).phase == pytest.approx(TRIAL.phase, abs=1e-9)
    x = np.linspace(0.0, 0.05, 20_000)
    u, v = quadrature(x, errors=TRIAL, noise=0.005, seed=1)
    raw = interpolation_error(x, u, v)
    left = interpolation_error(x, *fit_ellipse(u, v).corrected(u, v))
    assert raw.std() > 10.0 * left.std()
    assert left.std() == pytest.approx(0.01 / (2 * math.pi) * 0.005, rel=0.06)  # the noise alone


def test_the_centre_is_right_where_most_samples_lie_on_one_side():
    """Two of three samples in one sixth of the turn, so that their mean is far from the centre of (3, -2) V."""
    phi = np.radians([*range(0, 60, 3), *range(60, 360, 30)])
    fit = fit_ellipse(3.0 + 1.5 * np.sin(phi), -2.0 + 0.8 * np.cos(phi + 0.2))
    assert fit[:5] == pytest.approx((3.0, -2.0, 1.5, 0.8, 0.2), abs=1e-12)
    assert fit.scatter < 1e-12
    correction = fit.parameters()
    assert correction["correct_offset_u"] == pytest.approx(2.0) and correction["correct_offset_v"] == pytest.approx(
        -4.0 / 3.0
    ), "in amplitudes of u"


@pytest.mark.parametrize("turned", [0.0, 100.0, 200.0, 300.0])
def test_an_empty_arc_of_a_third_of_a_turn_is_the_largest_wherever_it_lies(turned):
    for gap, fits in ((119.0, True), (121.0, False)):
        phi = np.radians(turned + np.linspace(0.0, 360.0 - gap, 60))
        if fits:
            assert fit_ellipse(np.sin(phi), np.cos(phi)).amplitude_u == pytest.approx(1.0)
        else:
            with pytest.raises(DataError, match="leave 121 degrees of the ellipse empty, 120 are allowed"):
                fit_ellipse(np.sin(phi), np.cos(phi))


def test_scatter_is_allowed_up_to_a_fifth_of_the_radius():
    """Radii of 1 - s and 1 + s in turn: least squares of r^2 / R^2 = 1 gives R^2 = mean(r^4) / mean(r^2)."""
    for s, fits in ((0.19, True), (0.21, False)):
        r = 1.0 + s * (-1.0) ** np.arange(40)
        radius = math.sqrt((1.0 + 6.0 * s**2 + s**4) / (1.0 + s**2))
        scatter = math.sqrt(0.5 * (((1.0 - s) / radius - 1.0) ** 2 + ((1.0 + s) / radius - 1.0) ** 2))
        if fits:
            fit = fit_ellipse(r * np.sin(SPREAD_OVER), r * np.cos(SPREAD_OVER))
            assert (fit.amplitude_u, fit.amplitude_v, fit.scatter) == pytest.approx((radius, radius, scatter))
        else:
            with pytest.raises(DataError, match=r"scatter by 0\.21 of the ellipse's radius, 0\.2 is allowed"):
                fit_ellipse(r * np.sin(SPREAD_OVER), r * np.cos(SPREAD_OVER))


def test_a_third_harmonic_looks_like_an_ellipse_and_the_correction_doubles_its_error():
    h = 0.02  # the radius is 1 + h cos(2 phi): an ellipse with v larger by 2h, whose removal adds h sin(2 phi)
    u, v = quadrature(ONE_PITCH, errors=SignalErrors(harmonic=h))
    fit = fit_ellipse(u, v)
    before, after = (interpolation_error(ONE_PITCH, *pair) for pair in ((u, v), fit.corrected(u, v)))
    assert fit.amplitude_v / fit.amplitude_u - 1.0 == pytest.approx(2.0 * h, rel=0.05)
    assert np.abs(after).max() == pytest.approx(2.0 * np.abs(before).max(), rel=0.05)


def test_a_ruler_with_the_correction_of_its_own_log_reads_as_if_it_had_no_errors():
    fit = fit_ellipse(*quadrature(ONE_PITCH, errors=TRIAL))
    quiet = Noise(0, 0, 0, 0)

    def read(block, x):
        return block.step(block.prepare(block.params, 1e-3), LathePosition(0.0, x), quiet)

    wrong = grating_ruler(subdivision=4096, **TRIAL._asdict())
    right = wrong(**fit.parameters())
    off = np.array([[abs(read(block, x) - x) for block in (wrong, right)] for x in np.linspace(-0.01, 0.01, 101)])
    assert off[:, 0].max() > 1.9e-4 and off[:, 1].max() <= 0.5 * 0.01 / 4096 * 1.0001


ANGLES = np.linspace(0.0, math.pi / 2, 50)
REFUSED = {
    "at least 5": (np.sin(ANGLES[:4]), np.cos(ANGLES[:4])),
    "6 values of u but 5 of v": (np.arange(6.0), np.arange(5.0)),
    "not finite": (np.array([0.0, 1.0, 2.0, 3.0, np.nan]), np.arange(5.0)),
    "all samples are equal": (np.full(9, 2.0), np.full(9, 3.0)),
    "on a line": (np.linspace(-1.0, 1.0, 50), np.linspace(-2.0, 2.0, 50)),
    "fewer than five places": (np.tile([0.0, 1.0, 0.0, -1.0], 9), np.tile([1.0, 0.0, -1.0, 0.0], 9)),
    "do not lie on an ellipse": (np.cosh(ANGLES), np.sinh(ANGLES)),
    "degrees of the ellipse empty": (np.sin(ANGLES), np.cos(ANGLES)),
    "scatter": (
        (1.0 + 0.6 * (np.arange(40) % 2)) * np.sin(SPREAD_OVER),
        (1.0 + 0.6 * (np.arange(40) % 2)) * np.cos(SPREAD_OVER),
    ),
}


@pytest.mark.parametrize("said", REFUSED)
def test_samples_that_carry_no_ellipse_are_refused_with_the_reason(said):
    with pytest.raises(DataError, match=f"my log: .*{said}"):
        fit_ellipse(*REFUSED[said], where="my log")


def test_a_logged_pair_of_signals_is_read_and_fitted(tmp_path):
    u, v = quadrature(ONE_PITCH, errors=TRIAL)
    path = tmp_path / "signals.csv"
    rows = [f"{k / 1e5!r},{a!r},{b!r}" for k, (a, b) in enumerate(zip(u.tolist(), v.tolist(), strict=True))]
    path.write_text("\n".join(["time,u,v", *rows]), encoding="utf-8")
    assert fit_log(path).phase == pytest.approx(TRIAL.phase, abs=1e-9)
    path.write_text("\n".join(["time,u,v", *rows[:100]]), encoding="utf-8")
    with pytest.raises(DataError, match=r"signals\.csv: the samples leave \d+ degrees"):
        fit_log(path)
    path.write_text("time,u\n0.0,1.0\n", encoding="utf-8")
    with pytest.raises(DataError, match="the column 'v' is missing"):
        fit_log(path)
