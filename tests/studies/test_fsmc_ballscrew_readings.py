"""Readings, fuzzy surface, errata and region of attraction of fsmc_ballscrew: against hand work and second methods."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.controllers.sliding.stage import SlidingParams, View, layer_slope, switching_gain
from leadscrew.friction.lugre import LuGre
from leadscrew.plants.ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew import algebra
from leadscrew.studies.fsmc_ballscrew.attraction import (
    SYSTEMS,
    UNKNOWN,
    hold,
    largest_load,
    reach,
    region,
    ultimate_band,
    ultimate_error_um,
)
from leadscrew.studies.fsmc_ballscrew.claims_errata import BALL_BAR_FIGURES
from leadscrew.studies.fsmc_ballscrew.claims_fuzzy import MATLAB
from leadscrew.studies.fsmc_ballscrew.claims_readings import unit_changes
from leadscrew.studies.fsmc_ballscrew.claims_robust_continuous import fuzzy_slope
from leadscrew.studies.fsmc_ballscrew.figures_fuzzy import fuzzy_pictures
from leadscrew.studies.fsmc_ballscrew.readings import (
    COMPLEMENTARY,
    CONVENTIONAL,
    HELD_FUZZY,
    LITERAL,
    SLOTINE,
    ReadingParams,
    held_loop,
    read_as,
    wanted,
)
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from tests.fuzzy.formats_systems import shared
from tests.studies.whole import claims_of

LAM = 150.0


@pytest.fixture(scope="module")
def loops():
    return Loops()


# ---- algebra
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
    assert algebra.open_loop_eigenvalues(speed) == (
        pytest.approx(known[1], rel=1e-4),
        pytest.approx(known[0], rel=1e-3),
    )


def test_an_explicit_method_stays_bounded_on_a_stuck_stage_up_to_its_limit_and_not_beyond():
    euler, rk4 = algebra.explicit_limits_us()
    a = np.array([[-(math.sqrt(1e5) + 0.4) / INERTIA, -1e5 / INERTIA], [1.0, 0.0]])
    for limit, terms in ((euler, 1), (rk4, 4)):
        for part, bounded in ((0.999, True), (1.001, False)):
            m = a * part * limit * 1e-6
            step = sum(np.linalg.matrix_power(m, k) / math.factorial(k) for k in range(terms + 1))
            assert (np.abs(np.linalg.eigvals(step)).max() <= 1.0) == bounded


@pytest.mark.slow
def test_no_s_inside_the_layer_gives_a_larger_error_than_the_tight_bound_and_one_gives_it():
    """The worst s switches with the sign of the impulse response turned round in time."""
    of_e, of_rate = algebra.tight_bounds()
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
    assert algebra.binomial_error(n) < 1e-15


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
    assert algebra.lyapunov_residual() < 1e-12


def test_the_poles_are_those_of_the_linear_loop():
    """The loop e'' = u, xi' = e under the law with a linear K, as a matrix."""
    gain = 3e4
    for poles, sign in ((algebra.printed_rules_poles, -1.0), (algebra.corrected_rules_poles, 1.0)):
        s, s_c = np.array([LAM**2, 2.0 * LAM, 1.0]), np.array([-(LAM**2), 0.0, 1.0])
        row = -np.array([LAM**3, 3.0 * LAM**2, 3.0 * LAM]) - 0.5 * gain * (s + sign * s_c)
        known = np.linalg.eigvals(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], row]))
        assert np.poly(poles(gain)).real == pytest.approx(np.poly(known).real, rel=1e-9)


# ---- readings
def seen(e, rate, xi, speed=0.3):
    p = SlidingParams()
    gain = switching_gain(p, speed)
    return View(0.0, speed, e, rate, xi, 2.0, 0.0, 0.0, gain, layer_slope(p, gain))


def test_in_mm_the_torque_is_what_the_papers_numbers_give_in_mm():
    """(9) to (11) by hand in mm: u = T l_p / J in mm/s^2, phi = 0.1 mm/s, eta = 120 mm/s^2."""
    e, rate, xi = 2e-4, 4e-3, 3e-7
    lp = TRAVEL_MM_PER_RAD
    s = lp * (rate + 2.0 * LAM * e + LAM**2 * xi)
    k = lp * (6.24 + 1.0 * 0.3) / INERTIA + 120.0
    u_mm = lp * 2.0 - lp * (3.0 * LAM * rate + 3.0 * LAM**2 * e + LAM**3 * xi) - k * min(1.0, max(-1.0, s / 0.1))
    changes = unit_changes("mm", "corrected.smc")
    stage = SlidingParams(boundary=changes["controller.boundary"], eta=changes["controller.eta"])
    gain = switching_gain(stage, 0.3)
    now = seen(e, rate, xi)._replace(gain=gain, slope=layer_slope(stage, gain))
    assert wanted(ReadingParams(LITERAL, stage), now) == pytest.approx(u_mm / lp, rel=1e-12)


@pytest.mark.parametrize(
    ("reading", "changes", "k"),
    [("torque", {"eta": 120.0 / INERTIA}, (6.24 + 0.3 + 120.0) / INERTIA), ("mixed", {}, 6.24 + 0.3 + 120.0)],
)
def test_the_other_units_give_the_gain_that_they_say(reading, changes, k):
    found = unit_changes(reading, "corrected.smc")
    p = SlidingParams()
    bound = p.bound._replace(**{key.rsplit(".", 1)[1]: v for key, v in found.items() if ".bound." in key})
    assert switching_gain(p._replace(bound=bound, **changes), 0.3) == pytest.approx(k, rel=1e-12)
    assert found.get("controller.eta", 120.0) == pytest.approx(changes.get("eta", 120.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("weights", "eta", "name"),
    [(CONVENTIONAL, 120.0, "corrected.smc"), (LITERAL, 120.0, "paper.smc"), (COMPLEMENTARY, 20.0, "paper.csmc")],
)
def test_a_reading_with_the_weights_of_a_law_is_that_law(loops, weights, eta, name):
    ours = loops.get(read_as(weights, eta), "sine_fast").run(0.5, record=("true_error",))["true_error"]
    known = loops.run(name, "sine_fast", 0.5)["true_error"]
    assert 1e6 * ours == pytest.approx(1e6 * known, abs=1e-3)


def test_slotines_equivalent_control_makes_the_rate_of_s_the_switching_term_alone():
    """S' = e'' + 2 lam e' + lam^2 e with e'' = u - y_r''; Liang and Su's leaves s' + lam s."""
    now = seen(1e-4, -2e-3, 2e-7)
    for weights, left in ((SLOTINE, 0.0), (LITERAL, LAM)):
        p = ReadingParams(weights, SlidingParams())
        s = now.rate + 2.0 * LAM * now.e + LAM**2 * now.xi
        s_rate = wanted(p, now) - now.acceleration + 2.0 * LAM * now.rate + LAM**2 * now.e
        switching = now.gain * min(1.0, max(-1.0, s / 0.1))
        assert s_rate + left * s == pytest.approx(-switching, rel=1e-9)


def test_the_sign_of_a_speed_at_rest_leaves_only_eta():
    p = ReadingParams(CONVENTIONAL._replace(signed=1), SlidingParams())
    far = seen(-0.6, 0.0, 0.0, speed=0.0)
    assert wanted(p, far) - far.acceleration == pytest.approx(120.0)
    assert wanted(p, far._replace(speed=1e-12)) - far.acceleration == pytest.approx(far.gain)


@pytest.mark.slow
def test_held_over_a_short_period_the_fuzzy_law_is_the_continuous_one(loops):
    held = tail_um(held_loop(loops, HELD_FUZZY, 2e-6).run(0.4, record=("true_error",)))[0]
    assert held == pytest.approx(tail_um(loops.run("corrected.fsmc", "sine_fast", 0.4))[0], rel=0.01)


# ---- fuzzy
def test_the_centroid_on_101_points_is_the_trapezoid_rule_on_the_clipped_sets():
    y = np.linspace(-1.5, 1.5, 101)
    # s = 0.3, s_c = 0.7: Z 0.7 and P 0.3, Z 0.3 and P 0.7
    degree = {"ZO": min(0.7, 0.3), "NS": max(min(0.7, 0.7), min(0.3, 0.3)), "NB": min(0.3, 0.7)}
    centres = {"ZO": 0.0, "NS": -0.5, "NB": -1.0}
    sets = {n: np.clip(1.0 - np.abs(y - c) / 0.5, 0.0, 1.0) for n, c in centres.items()}
    mu = np.max([np.minimum(degree[n], of) for n, of in sets.items()], axis=0)
    known = np.trapezoid(mu * y, y) / np.trapezoid(mu, y)
    assert MATLAB(s=0.3, s_c=0.7)["k"] == pytest.approx(known, rel=1e-9)
    exact = float(SYSTEMS["corrected"](s=0.3, s_c=0.7)["k"])
    assert exact != MATLAB(s=0.3, s_c=0.7)["k"] and exact == pytest.approx(known, abs=2e-3)


def test_the_fuzzy_slope_is_that_of_a_small_speed_error():
    """Of 120 N m through s = e' over 0.65 and s_c = e' over 2.6."""
    k = float(SYSTEMS["corrected"](s=1e-4 / 0.65, s_c=1e-4 / 2.6)["k"])
    assert fuzzy_slope() == pytest.approx(-120.0 * k / (INERTIA * 1e-4), rel=1e-3)


@pytest.mark.parametrize(
    ("rules", "ratio", "most"),
    [("printed", 1.0, 1.0), ("printed", 4.0, 1.0), ("corrected", 1.0, 0.0), ("without_dead_corner", 1.0, 0.5)],
)
def test_what_the_rules_hold_at_rest_is_what_their_corner_says(rules, ratio, most):
    """(P, N) is NB in the printed table, ZO in the corrected one, NS without the dead corner: centres 1, 0, 1/2."""
    assert hold(rules, ratio) == pytest.approx(most, abs=1e-12)


# ---- region of attraction
def test_beyond_the_band_no_point_of_the_surface_is_weaker_than_asked():
    share = UNKNOWN / 120.0
    band = reach("without_dead_corner", share)
    x, y = np.random.default_rng(5).uniform(-1.5, 1.5, (2, 20000))
    k = np.array(SYSTEMS["without_dead_corner"].many(s=x, s_c=y))
    outside = np.abs(x) >= band
    assert (-k * np.sign(x))[outside].min() >= share and outside.sum() > 5000
    assert np.isnan(reach("corrected", share)) and np.isnan(reach("printed", share))


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.0, 4.0, 16.0])
def test_against_the_worst_unknown_torque_every_start_ends_in_the_proved_band(ratio):
    """D against s all the time, a hundred starts, the error's equation by small steps; D = 18.72 N m, U = 120."""
    draws = np.random.default_rng(11)
    starts = draws.normal(size=(3, 100)) * np.array([[1e-4], [0.05], [10.0]])
    xi, e, rate = starts
    scale, h = 0.65, 2e-6
    k = SYSTEMS["without_dead_corner"]
    band = ultimate_band("without_dead_corner", ratio, UNKNOWN / 120.0)
    largest = np.zeros(100)
    error = np.zeros(100)
    steps, grid = 60000, np.linspace(-1.0, 1.0, 201)
    table = np.array(k.many(s=grid[:, None], s_c=grid[None, :]))
    for i in range(steps):
        s, s_c = rate + 2.0 * LAM * e + LAM**2 * xi, rate - LAM**2 * xi
        u = _table(table, s / scale, s_c / (ratio * scale))
        push = (120.0 * u + UNKNOWN * np.sign(s)) / INERTIA
        rate = rate + h * (push - 3.0 * LAM * rate - 3.0 * LAM**2 * e - LAM**3 * xi)
        xi, e = xi + h * e, e + h * rate
        if i > 0.9 * steps:
            largest, error = np.maximum(largest, np.abs(s)), np.maximum(error, np.abs(e))
    assert largest.max() <= band * scale * 1.02 + 0.01
    assert largest.max() > 0.2 * band * scale
    assert 1e3 * TRAVEL_MM_PER_RAD * error.max() <= ultimate_error_um(band)


def _table(table, x, y):
    at = [np.clip((v + 1.0) * 100.0, 0.0, 199.999999) for v in (x, y)]
    (i, j), (a, b) = [v.astype(int) for v in at], [v % 1.0 for v in at]
    low = (1.0 - b) * table[i, j] + b * table[i, j + 1]
    return (1.0 - a) * low + a * ((1.0 - b) * table[i + 1, j] + b * table[i + 1, j + 1])


def test_the_corrected_rules_have_a_rest_in_their_dead_corner():
    """At s = -s_c = D / (J lam), far outside the scales, with e = 0: K is 0 and the linear terms alone hold D."""
    s = 6.24 / (INERTIA * LAM)
    assert s > 40.0 * 2.6 and SYSTEMS["corrected"](s=s / 0.65, s_c=-s / 2.6)["k"] == pytest.approx(0.0, abs=1e-12)
    assert SYSTEMS["without_dead_corner"](s=s / 0.65, s_c=-s / 2.6)["k"] == pytest.approx(-0.5)


@pytest.mark.slow
def test_the_stage_comes_back_from_everywhere_up_to_the_load_that_the_rules_hold(loops):
    found = region(loops, "without_dead_corner")
    assert largest_load(found) == 50.0 < 120.0 * hold("without_dead_corner", 4.0) - LuGre().static < 55.0
    assert not region(loops, "corrected").returned[-1, 4:].any()


# ---- claims


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_every_erratum_has_its_number():
    numbers = {int(n) for name in claims_of("fsmc_ballscrew") for n in re.findall(r"erratum_(\d+)", name)}
    assert numbers == set(range(1, 16))


def test_the_figures_of_the_ball_bar_are_other_peoples_by_their_captions():
    text = shared("papers/text/fsmc_ballscrew.txt").read_text()
    for number, source in BALL_BAR_FIGURES.items():
        (caption,) = re.findall(rf"Fig\. {number}\.[^\n]*", text)
        assert caption.rstrip().endswith(f"({source})")


@pytest.mark.slow
def test_the_pictures_are_drawn_with_units_on_their_axes(loops):
    pictures = fuzzy_pictures(loops)
    assert [p.name for p in pictures] == [
        "fig7_boundary_layer", "fig8_9_sets", "fig10_scaling", "rule_surfaces", "attraction"
    ]  # fmt: skip
    for picture in pictures:
        figure = picture.draw()
        assert figure.axes and all("(" in axes.get_xlabel() for axes in figure.axes if axes.get_xlabel())
        assert len(picture.caption) > 60


@pytest.mark.slow
def test_the_layer_of_the_picture_is_never_left_on_the_way_in(loops):
    """Once |s| <= phi, the motions of the bare step stay there: (12) and (15)."""
    for law, half in (("corrected.smc", 1.0), ("paper.csmc", 0.5)):
        run = loops.run(law, "step_raw", 0.2, ("true_error", "plant.speed"), sample=2e-5)
        s = run["plant.speed"] - LAM * run["true_error"] / TRAVEL_MM_PER_RAD
        inside = np.flatnonzero(np.abs(s) <= half * 0.1)
        assert len(inside) and np.abs(s[inside[0] :]).max() <= half * 0.1 * 1.02


def test_a_reading_is_changed_by_its_dotted_keys():
    block = read_as(LITERAL, 120.0)
    assert replace(block, params=block.params)(**{"weights.u_rate": 2.0}).params.weights.u_rate == 2.0
