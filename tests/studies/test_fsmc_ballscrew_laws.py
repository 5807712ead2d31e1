"""Laws, readings and region of attraction of fsmc_ballscrew: against hand work, finite differences and SciPy."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew import resolve
from leadscrew.controllers._sliding.stage import SlidingParams, View, layer_slope, switching_gain
from leadscrew.friction.lugre import TABLE_2, LuGre
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew import laws
from leadscrew.studies.fsmc_ballscrew.attraction import SYSTEMS, UNKNOWN, hold, reach
from leadscrew.studies.fsmc_ballscrew.claims import FIGURES
from leadscrew.studies.fsmc_ballscrew.experiments import unit_changes
from leadscrew.studies.fsmc_ballscrew.readings import (
    COMPLEMENTARY,
    CONVENTIONAL,
    HELD_FUZZY,
    LITERAL,
    ReadingParams,
    held_loop,
    read_as,
    wanted,
)
from leadscrew.studies.fsmc_ballscrew.tracking import tail_um
from leadscrew.studies.lab import Lab
from tests.fuzzy.formats_systems import shared

LAM = 150.0
LAB = Lab(resolve.study("fsmc_ballscrew"))


def printed_rates(x):
    """The printed equations of stage and bristles, written out again, without a torque."""
    v, z = x
    g = (6.24 + 3.12 * math.exp(-((v / 1e-3) ** 2))) / 1e5
    rate = v - abs(v) * z / g
    return np.array([-(1e5 * z + math.sqrt(1e5) * rate + 0.4 * v) / (2.12e-4 + 62.4 * 1.5923e-3**2), rate])


@pytest.mark.parametrize("speed", [1e-5, 1e-4, 1e-3, 5e-3, 0.1, 10.0])
def test_the_eigenvalues_are_those_of_finite_differences(speed):
    g = (6.24 + 3.12 * math.exp(-((speed / 1e-3) ** 2))) / 1e5
    at, columns = np.array([speed, g]), []
    for nudge in (np.array([1e-5 * speed, 0.0]), np.array([0.0, 1e-11])):
        columns.append((printed_rates(at + nudge) - printed_rates(at - nudge)) / (2.0 * nudge.sum()))
    known = sorted(np.linalg.eigvals(np.array(columns).T).real, key=abs)
    assert laws.open_loop_eigenvalues(speed) == (
        pytest.approx(known[1], rel=1e-4),
        pytest.approx(known[0], rel=1e-3),
    )


def test_an_explicit_method_stays_bounded_on_a_stuck_stage_up_to_its_limit_and_not_beyond():
    euler, rk4 = laws.explicit_limits_us()
    a = np.array([[-(math.sqrt(1e5) + 0.4) / INERTIA, -1e5 / INERTIA], [1.0, 0.0]])
    for limit, terms in ((euler, 1), (rk4, 4)):
        for part, bounded in ((0.999, True), (1.001, False)):
            m = a * part * limit * 1e-6
            step = sum(np.linalg.matrix_power(m, k) / math.factorial(k) for k in range(terms + 1))
            assert (np.abs(np.linalg.eigvals(step)).max() <= 1.0) == bounded


@pytest.mark.slow
def test_no_s_inside_the_layer_gives_a_larger_error_than_the_tight_bound_and_one_gives_it():
    """The worst s switches with the sign of the impulse response turned round in time."""
    of_e, of_rate = laws.tight_bounds()
    assert of_e == pytest.approx(2.0 / math.e, rel=1e-9) and of_rate == pytest.approx(2.0 + 2.0 / math.e**2, rel=1e-9)
    end = 20.0

    def answer(s):
        rates = lambda t, x: [x[1], s(t) - 2.0 * x[1] - x[0]]  # noqa: E731
        got = solve_ivp(rates, (0.0, end), [0.0, 0.0], max_step=0.01, rtol=1e-8, atol=1e-11)
        xi, e = got.y
        return abs(e[-1]), abs(s(end) - 2.0 * e[-1] - xi[-1])

    assert answer(lambda t: math.copysign(1.0, 1.0 - (end - t)))[0] == pytest.approx(of_e, rel=1e-4)
    worst_for_rate = lambda t: 1.0 if t >= end else math.copysign(1.0, (end - t) - 2.0)  # noqa: E731
    assert answer(worst_for_rate)[1] == pytest.approx(of_rate, rel=1e-4)
    draws = np.random.default_rng(3)
    for _ in range(3):
        w, p = draws.uniform(0.2, 5.0), draws.uniform(0.0, 6.0)
        found = answer(lambda t, w=w, p=p: math.copysign(1.0, math.sin(w * t + p)))
        assert found[0] < of_e and found[1] < of_rate


@pytest.mark.parametrize("n", [2, 3, 4])
def test_the_binomials_hold_for_an_integral_that_grows_as_an_exponential(n):
    """With xi = exp(a t) the derivative k is a^k: (10) must give (a + lam)^(n + 1)."""
    a = 37.0
    terms = sum(math.comb(n + 1, k + 1) * LAM ** (n - k) * a ** (k + 1) for k in range(n))
    assert a ** (n + 1) + terms + LAM ** (n + 1) == pytest.approx((a + LAM) ** (n + 1), rel=1e-12)
    assert laws.binomial_error(n) < 1e-15


def test_the_lyapunov_function_falls_as_stated_along_a_motion():
    """V at both ends of a motion under w = 100 sin 700 t, against the integral of the stated rate."""

    def rates(t, x):
        xi, e, rate, _ = x
        w = 100.0 * math.sin(700.0 * t)
        s, s_c = rate + 2.0 * LAM * e + LAM**2 * xi, rate - LAM**2 * xi
        return [e, rate, w - 3.0 * LAM * rate - 3.0 * LAM**2 * e - LAM**3 * xi, -LAM * (s + s_c) ** 2 + (s + s_c) * w]

    def v(x):
        s, s_c = x[2] + 2.0 * LAM * x[1] + LAM**2 * x[0], x[2] - LAM**2 * x[0]
        return 0.5 * (s * s + s_c * s_c)

    start = [1e-6, 2e-4, -0.03, 0.0]
    end = solve_ivp(rates, (0.0, 0.02), start, method="DOP853", rtol=1e-11, atol=1e-16).y[:, -1]
    assert v(end) - v(start) == pytest.approx(end[3], rel=1e-7)
    assert laws.lyapunov_residual() < 1e-12


def seen(e, rate, xi, speed=0.3):
    p = SlidingParams()
    gain = switching_gain(p, speed)
    return View(0.0, speed, e, rate, xi, 2.0, 0.0, 0.0, gain, layer_slope(p, gain))


def test_the_sign_of_a_speed_at_rest_leaves_only_eta():
    p = ReadingParams(CONVENTIONAL._replace(signed=1), SlidingParams())
    far = seen(-0.6, 0.0, 0.0, speed=0.0)
    assert wanted(p, far) - far.acceleration == pytest.approx(120.0)
    assert wanted(p, far._replace(speed=1e-12)) - far.acceleration == pytest.approx(far.gain)


@pytest.mark.parametrize(
    ("rules", "ratio", "most"),
    [("printed", 1.0, 1.0), ("printed", 4.0, 1.0), ("corrected", 1.0, 0.0), ("without_dead_corner", 1.0, 0.5)],
)
def test_what_the_rules_hold_at_rest_is_what_their_corner_says(rules, ratio, most):
    """(P, N) is NB in the printed table, ZO in the corrected one, NS without the dead corner: centres 1, 0, 1/2."""
    assert hold(rules, ratio) == pytest.approx(most, abs=1e-12)


def test_beyond_the_band_no_point_of_the_surface_is_weaker_than_asked():
    share = UNKNOWN / 120.0
    band = reach("without_dead_corner", share)
    x, y = np.random.default_rng(5).uniform(-1.5, 1.5, (2, 20000))
    k = np.array(SYSTEMS["without_dead_corner"].many(s=x, s_c=y))
    outside = np.abs(x) >= band
    assert (-k * np.sign(x))[outside].min() >= share and outside.sum() > 5000
    assert np.isnan(reach("corrected", share)) and np.isnan(reach("printed", share))


def test_the_figures_of_the_ball_bar_are_other_peoples_by_their_captions():
    text = shared("papers/text/fsmc_ballscrew.txt").read_text()
    for number, source in FIGURES.items():
        (caption,) = re.findall(rf"Fig\. {number}\.[^\n]*", text)
        assert caption.rstrip().endswith(f"({source})")


@pytest.mark.slow
def test_held_over_a_short_period_the_fuzzy_law_is_the_continuous_one():
    held = tail_um(held_loop(LAB, HELD_FUZZY, 2e-6).run(0.4, record=("true_error",)))[0]
    assert held == pytest.approx(tail_um(LAB.run("corrected.fsmc", "sine_fast", 0.4))[0], rel=0.01)


def test_in_mm_the_torque_is_what_the_papers_numbers_give_in_mm():
    """(9) to (11) by hand in mm: u = T l_p / J in mm/s^2, phi = 0.1 mm/s, eta = 120 mm/s^2."""
    e, rate, xi, lp = 2e-4, 4e-3, 3e-7, TRAVEL_MM_PER_RAD
    s = lp * (rate + 2.0 * LAM * e + LAM**2 * xi)
    k = lp * (6.24 + 1.0 * 0.3) / INERTIA + 120.0
    u_mm = lp * 2.0 - lp * (3.0 * LAM * rate + 3.0 * LAM**2 * e + LAM**3 * xi) - k * min(1.0, max(-1.0, s / 0.1))
    changes = unit_changes(LAB, "mm/s, mm/s²", "corrected.smc")
    stage = SlidingParams(boundary=changes["controller.boundary"], eta=changes["controller.eta"])
    gain = switching_gain(stage, 0.3)
    now = seen(e, rate, xi)._replace(gain=gain, slope=layer_slope(stage, gain))
    assert wanted(ReadingParams(LITERAL, stage), now) == pytest.approx(u_mm / lp, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("weights", "eta", "name"),
    [(CONVENTIONAL, 120.0, "corrected.smc"), (LITERAL, 120.0, "paper.smc"), (COMPLEMENTARY, 20.0, "paper.csmc")],
)
def test_a_reading_with_the_weights_of_a_law_is_that_law(weights, eta, name):
    ours = LAB.loop(read_as(weights, eta), "sine_fast").run(0.5, record=("true_error",))["true_error"]
    assert 1e6 * ours == pytest.approx(1e6 * LAB.run(name, "sine_fast", 0.5)["true_error"], abs=1e-3)


def test_table_2_is_as_printed():
    root = math.sqrt(1e5)
    printed = {
        "plant": (1e5, root, 0.4, 6.24, 9.36, 0.001),
        "hat": (2e5, 2.0 * root, 1.2, 6.24, 9.36, 0.005),
        "tilde": (1e5, root, 1.0, 6.24, 9.36, 0.005),
    }
    assert {k: tuple(f) for k, f in TABLE_2.items()} == {k: pytest.approx(numbers) for k, numbers in printed.items()}


@pytest.mark.parametrize("inertia", [INERTIA, 1.0])
def test_the_damping_of_a_stuck_stage_is_that_of_its_poles(inertia):
    f = LuGre()
    p, q = np.linalg.eigvals([[-(f.damping + f.viscous) / inertia, -f.stiffness / inertia], [1.0, 0.0]])
    assert laws.stick_damping(f, inertia) == pytest.approx((-(p + q) / (2.0 * np.sqrt(p * q))).real, rel=1e-6)
