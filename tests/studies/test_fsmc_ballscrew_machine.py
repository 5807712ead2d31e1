"""Circles, backlash, drives and learning of fsmc_ballscrew: against another solver, hand work and made-up runs."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew import resolve
from leadscrew.analysis.circular.paths import CircularTest, Turn
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.analysis.friction import break_away
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.studies.fsmc_ballscrew import backlash, drives
from leadscrew.studies.fsmc_ballscrew.circles import CIRCLES, both, circle_of, jumps_um, one
from leadscrew.studies.fsmc_ballscrew.friction_experiments import peak_friction
from leadscrew.studies.fsmc_ballscrew.learned import FIXED, passes_um, slip_foreseen_wrong
from leadscrew.studies.fsmc_ballscrew.scenarios import sine_of
from leadscrew.studies.lab import Lab

MM = 1.5923
"""Travel of the table per radian, Table 1."""
LAB = Lab(resolve.study("fsmc_ballscrew"))


def by_scipy(way, cosine, when):
    """Position, mm, of the stage under conventional sliding mode in continuous time, written down here."""
    inertia, lam, phi, eta = 2.12e-4 + 62.4 * 1.5923e-3**2, 150.0, 0.1, 120.0
    size, w = way.radius_mm / MM, way.rate_rad_s
    ahead = 0.5 * math.pi if cosine else 0.0

    def level(v, v_s):
        return 6.24 + 3.12 * math.exp(-((v / v_s) ** 2))

    def rates(t, s):
        angle, v, z, believed = s
        r, r1 = size * math.sin(w * t + ahead), size * w * math.cos(w * t + ahead)
        r2 = -w * w * r
        z1 = v - abs(v) * 1e5 * z / level(v, 1e-3)
        b1 = r1 - abs(r1) * 2e5 * believed / level(r1, 5e-3)
        friction = 1e5 * z + 316.2 * z1 + 0.4 * v
        hat = 2e5 * believed + 632.5 * b1 + 1.2 * r1
        gain = (level(v, 5e-3) + 1.0 * abs(v)) / inertia + eta
        inside = max(-1.0, min(1.0, (v - r1 + lam * (angle - r)) / phi))
        torque = hat + inertia * (r2 - lam * (v - r1) - gain * inside)
        return [v, (torque - friction) / inertia, z1, b1]

    v = 0.0 if cosine else size * w
    start = [size if cosine else 0.0, v, level(v, 1e-3) / 1e5 * (v > 0.0), level(v, 5e-3) / 2e5 * (v > 0.0)]
    found = solve_ivp(rates, (0.0, when[-1]), start, method="Radau", rtol=1e-8, atol=1e-11, t_eval=when)
    assert found.success
    return MM * found.y[0]


@pytest.mark.slow
def test_a_circle_in_continuous_time_is_that_of_another_solver():
    way = CIRCLES["r1"]
    phi = 2.0 * math.pi * (1.0 + np.arange(1800) / 1800)
    x, y = (by_scipy(way, cosine, phi / way.rate_rad_s) for cosine in (True, False))
    other = quantities(CircularTest(1.0, Turn("ccw", x, y), None)).ccw
    ours = one(circle_of(LAB, "corrected.smc", way))
    assert ours.circular == pytest.approx(other.circular, abs=2e-4)
    assert ours.mean_radial == pytest.approx(other.mean_radial, abs=2e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("controller", "within"), [("corrected.smc", 1e-4), ("ours.pd_dob_robust", 0.012)])
def test_clockwise_is_the_mirror_image_but_for_counts_of_the_scale(controller, within):
    found = quantities(circle_of(LAB, controller, CIRCLES["r1"], both=True))
    assert found.cw.circular == pytest.approx(found.ccw.circular, abs=within)
    mirrored = both(circle_of(LAB, controller, CIRCLES["r1"]))
    assert found.both.circular == pytest.approx(mirrored.circular, abs=within)


def test_jumps_are_placed_by_their_distance_from_the_nearest_axis():
    phi = 2.0 * np.pi * np.arange(1800) / 1800
    radius = 10.0 + 0.001 * (np.degrees(phi) > 280.05)
    where, change = jumps_um(CircularTest(10.0, Turn("ccw", radius * np.cos(phi), radius * np.sin(phi)), None))
    assert np.argmax(change) == 1400 and change.max() == pytest.approx(1.0, abs=1e-6)
    assert where[1400] == pytest.approx(10.0, abs=0.01)


def test_reversals_are_read_as_they_are():
    """Error 0.5 um and after each reversal 2 um for 30 ms, then -0.5 um: height 2, 30 ms, offset 0.5."""

    class Made(dict):
        time = np.arange(0.0, 8.0, 1e-3)
        diverged = None

    t = Made.time
    way = np.where(np.floor((t - 0.5 * math.pi) / math.pi) % 2.0 == 0.0, 1.0, -1.0)
    since = (t - 0.5 * math.pi) % math.pi
    e = np.where(since < 0.03, 2.0 * way, 0.05 * way)
    run = Made({"actual.position": 1e-3 * e, "command.position": np.zeros_like(t)})
    found = backlash.reversed_by(run, 1.0)
    assert found.height_um == pytest.approx(2.0) and found.offset_um == pytest.approx(0.05)
    assert found.duration_s == pytest.approx(0.03, abs=1.1e-3)


def test_a_slip_foreseen_half_a_step_wrong_is_the_momentum_that_its_damping_leaves():
    """Speed ``c dx / J`` at once, ``c`` the damping of the last element; then friction 1080 1/s slows it down."""
    slip = slip_foreseen_wrong(5.0)
    damping = math.sqrt(1e5) * 9802.0 / 1e5
    speed = damping * 5e-6 / TRAVEL_MM_PER_RAD / INERTIA
    rate = 0.4 / INERTIA
    assert slip.travel == pytest.approx(1e3 * TRAVEL_MM_PER_RAD * 2.0 * 0.3189 * 6.24 / 9802.0, rel=1e-6)
    free = [1e3 * TRAVEL_MM_PER_RAD * speed * -math.expm1(-rate * t) / rate for t in (2.5e-4, 5e-4)]
    assert 0.6 * free[0] < slip.one < free[0] and 0.6 * free[1] < slip.two < free[1]
    assert slip_foreseen_wrong(0.0).two < 1e-3


@pytest.mark.slow
def test_the_peak_of_the_friction_is_that_of_the_analysis():
    """Another loop, another integration in time: held forces and 8000 samples a rise."""
    other = break_away(mass_lugre, [1.0, 20.0])
    assert [peak_friction(LAB, rate) for rate in (1.0, 20.0)] == pytest.approx(other, abs=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sine_wide", "sine_fast"])
def test_the_gap_is_crossed_on_a_parabola_from_where_the_guide_presses(name):
    """sqrt(2 (b + F / k) / (R w^2)): the screw turns, the table stands."""
    radius, rate = {"sine_wide": (5e-3, 1.0), "sine_fast": (1e-3, 2.0 * math.pi)}[name]
    by_hand = math.sqrt(2.0 * (2e-6 + 20.0 / 1e8) / (radius * rate**2))
    assert backlash.impact(LAB, name, backlash.HARD).crossing_s == pytest.approx(by_hand, rel=0.006)


def test_the_least_lag_is_mass_over_damping():
    """62.4 kg over the joint's damping at e = 0.9, zeta = 0.0343, and the guide's 50 N s/m."""
    by_hand = 62.4 / (2.0 * 0.0343 * math.sqrt(1e8 / (1.0 / 62.4 + 1.5923e-3**2 / 2.12e-4)) + 50.0)
    assert backlash.least_lag_s() == pytest.approx(by_hand, rel=0.02)


@pytest.mark.slow
def test_a_loop_with_play_that_diverges_says_when():
    found = backlash.reversals_with(LAB, "ours.pd_dob", "sine_wide", "play", backlash.TABLE)
    assert found.diverged.startswith("diverged at t = 1.5") and math.isnan(found.height_um)


@pytest.mark.slow
def test_a_filter_that_the_controller_does_not_know_costs_its_lag_times_the_speed():
    """1 mm at 2 pi rad/s behind 1 / (2 pi 1000 Hz): 1 um at full speed."""
    assert drives.largest_um(LAB, "ours.pd_dob", "sine_fast", "filter") == pytest.approx(1.0, rel=0.02)


@pytest.mark.slow
def test_with_a_sample_of_delay_the_gains_made_for_it_hold_and_others_by_chance():
    """Eight runs on sin 2 pi t whose amplitudes differ by 1e-4; one that stays within 10 um never leaves the track."""

    def survivors(controller):
        size = sine_of("sine_fast").amplitude_mm * (1.0 + 1e-4 * np.arange(8))
        done = drives.driven(controller, "sine_fast", "delay").batch(8.0, {"reference.amplitude": size})
        return np.sum(1e3 * done.metrics["max"] <= 10.0)

    assert survivors("ours.pd_dob_robust") < 8 == survivors("ours.pd_dob_delay")


@pytest.mark.slow
def test_ten_passes_halve_the_error_on_the_fast_sine():
    errors = passes_um(LAB, FIXED, "sine_fast")
    assert len(errors) == 11 and errors[10] < 0.5 * errors[0] < 0.12
    assert np.diff(errors).max() < 0.01  # a step of the scale
