"""The pictures of an identified axis: what they show is what the fit says."""

import matplotlib
import numpy as np
import pytest
from scipy.stats import multivariate_normal

from leadscrew.report import identified_axis as picture
from leadscrew.report.identified_axis import QUANTILE, band, friction_map, medians, resistance, shown_by_log
from tests.report.axis_fits import KEYS, alike, made_up, stretch

matplotlib.use("Agg")


def test_the_map_is_coulomb_viscous_and_offset_by_direction():
    at = resistance(made_up().values, np.array([-0.2, -1e-6, 1e-6, 0.2]))
    assert at == pytest.approx([-22.0 - 0.2 * 55.0 - 1.5, -22.0 - 1.5, 18.0 - 1.5, 18.0 + 0.2 * 60.0 - 1.5], abs=1e-3)


def test_a_map_without_static_friction_has_no_stribeck_curve_and_one_with_it_has():
    plain = {"friction.forward.coulomb": 5.0, "friction.forward.viscous": 2.0}
    assert friction_map(plain).backward == friction_map(plain).forward
    assert friction_map(plain).forward.static == 5.0
    steep = plain | {"friction.forward.static": 9.0, "friction.forward.stribeck_speed": 0.01}
    assert resistance(steep, np.array([0.01])) == pytest.approx([5.0 + 4.0 / np.e + 0.02])


def test_the_band_is_the_scatter_of_maps_drawn_from_the_parameters():
    """Against 20,000 draws of the parameters, correlated as the fit says."""
    fit = made_up()
    for a, b, r in (("mass", "offset", 0.3), ("friction.forward.coulomb", "friction.forward.viscous", -0.8),
                    ("offset", "friction.backward.coulomb", 0.5)):  # fmt: skip
        fit.correlation[a][b] = fit.correlation[b][a] = r
    error = np.array([(fit.parameters[k].high - fit.parameters[k].low) / 2.0 / QUANTILE for k in KEYS])
    corr = np.array([[fit.correlation[a][b] for b in KEYS] for a in KEYS])
    drawn = multivariate_normal([fit.values[k] for k in KEYS], corr * np.outer(error, error), seed=3).rvs(20_000)
    speeds = np.array([-0.2, -0.05, 0.05, 0.2])
    maps = [np.where(speeds > 0.0, d[2] + d[4] * speeds, -d[3] + d[5] * speeds) + d[1] for d in drawn]
    assert band(fit, speeds) == pytest.approx(QUANTILE * np.std(maps, axis=0), rel=0.03)


def test_a_band_of_friction_alike_both_ways_counts_each_parameter_once():
    fit = alike()
    speeds = np.array([-0.1, 0.1])
    expected = np.sqrt(0.2**2 + 0.2**2 + (0.1 * 2.0) ** 2)
    assert band(fit, speeds) == pytest.approx([expected, expected], rel=1e-6)


def test_no_band_is_drawn_where_a_correlation_is_unknown():
    assert band(made_up(correlation={}), np.array([0.1])) is None


def test_medians_follow_the_samples_and_few_samples_give_none():
    speeds = np.concatenate([np.full(100, -0.1), np.full(100, 0.1), [0.0]])
    forces = np.concatenate([np.linspace(-3.0, -1.0, 100), np.linspace(4.0, 6.0, 100), [50.0]])
    middle, low, median, high = medians(speeds, forces, bins=5)
    assert middle == pytest.approx([-0.1, 0.1]) and median == pytest.approx([-2.0, 5.0])
    assert low == pytest.approx([-2.5, 4.5]) and high == pytest.approx([-1.5, 5.5])


def test_what_the_log_shows_of_friction_is_force_minus_inertia():
    fit = made_up()
    j = stretch()
    acceleration = np.gradient(j.speed, j.time)
    force = 20.0 * acceleration + resistance(fit.values, j.speed) + j.force_left
    assert shown_by_log(fit, j) == pytest.approx(force - 20.0 * acceleration)


def test_the_autocorrelation_of_a_first_order_process_falls_as_its_pole():
    lags = picture.autocorrelation(stretch(colour=0.9, seed=5).force_left, 20)
    assert lags[0] == 1.0 and lags[:8] == pytest.approx(0.9 ** np.arange(8), abs=0.08)
    white = picture.autocorrelation(stretch(seed=5).force_left, 100)
    assert np.mean(np.abs(white[1:]) < 1.96 / np.sqrt(5000)) > 0.85


def test_samples_that_the_fit_left_out_are_left_out_of_the_pictures_too():
    j = stretch(colour=0.9, seed=5)
    whole = picture.autocorrelation(j.force_left, 20)
    j.force_left[::7] = np.nan
    assert picture.autocorrelation(j.force_left, 20) == pytest.approx(whole, abs=0.03)
    fit = made_up(judged=[j])
    assert set(picture.pictures(fit)) == {"position", "residual", "friction", "parameters"}
    assert all(np.isfinite(line.get_ydata()).all() for line in picture.friction_figure(fit).axes[0].get_lines())


def test_measured_and_simulated_are_those_of_the_hold_out():
    figure = picture.position_figure(made_up())
    above, below = figure.axes[0], figure.axes[2]
    measured, simulated = above.get_lines()
    assert above.get_title() == "hold-out: 20 µm rms" and above.get_ylabel() == "position (mm)"
    hold = made_up().judgement("hold-out")
    assert measured.get_ydata() == pytest.approx(1e3 * hold.measured)
    assert below.get_ylabel() == "error (µm)"
    assert below.get_lines()[0].get_ydata() == pytest.approx(1e6 * (hold.measured - hold.simulated))
    assert simulated.get_linestyle() == "--", "told apart without colour"
    assert figure.axes[1].get_title() == "whole log, closed loop: 200 nm rms"


def test_a_parameter_without_an_interval_is_drawn_without_one():
    figure = picture.interval_figure(made_up())
    words = {t.get_text() for t in figure.axes[0].texts}
    assert words == {"given: no interval", "fixed: no interval", "fitted: no interval"}
    marks = [line.get_marker() for line in figure.axes[0].get_lines() if len(line.get_xdata()) == 1]
    assert marks.count("o") == 5 and marks.count("D") == 1, "hollow diamond: not identifiable"


def test_without_a_stretch_there_are_only_intervals():
    assert set(picture.pictures(made_up(judged=[]))) == {"parameters"}
