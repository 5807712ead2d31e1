"""Circle, Popov, Tsypkin, Jury-Lee: what they prove, against formulas, brute force and simulation."""

import json
import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.loop import continuous_loop, sampled_loop
from leadscrew.analysis.stability.lure import lure
from leadscrew.controllers._npid import npid
from leadscrew.references._sine import sine
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.studies.npid_xytable.tunings import TUNINGS
from leadscrew.util.errors import ValueRefused
from tests.analysis.test_stability_margins import random_rational
from tests.controllers.xy_loop import xy_loop

TRIPLE = continuous_loop([1.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0], name="1/(s+1)^3")


def test_the_triple_lag_has_the_sectors_of_the_textbook():
    """1/(s+1)^3: Nyquist and Popov both reach 8; with s = j tan(a), Re G = cos^3 a cos 3a, least -1/4 at a = 45 deg."""
    assert TRIPLE.gain_limit() == pytest.approx(8.0, rel=1e-9)
    assert ask("popov", TRIPLE).limit == pytest.approx(8.0, rel=1e-6)
    assert ask("circle", TRIPLE).limit == pytest.approx(4.0, rel=1e-7)


def test_the_paper_s_loop_has_the_sectors_that_were_measured_before():
    """Table I: Popov [0,K] 1.408, [1,K] 2.500, circle [1,K] 2.270 with 1.2888 ms of dead time."""
    loop = reference_loops()["Lc"]
    assert ask("popov", loop, 0.0).limit == pytest.approx(1.408, abs=1e-3)
    assert ask("popov", loop, 0.0).multiplier == pytest.approx(1.43e-3, rel=5e-3)
    assert ask("popov", loop, 1.0).limit == pytest.approx(2.500, abs=1e-3)
    assert ask("circle", loop, 1.0).limit == pytest.approx(2.270, abs=1e-3)
    assert ask("circle", reference_loops()["L_star"], 1.0).limit == pytest.approx(2.265, abs=1e-3)
    assert math.isinf(ask("popov", reference_loops()["no_delay"]).limit)


def brute(loop, k1, qs, w):
    g = loop.response(w)
    g = g / (1 + k1 * g)
    m = min(np.max(-((1 + 1j * w * q) * g).real) for q in qs)
    return k1 + 1 / m


@pytest.mark.parametrize("seed", range(6))
def test_no_multiplier_of_a_brute_search_proves_more(seed):
    loop = random_rational(seed, None)
    w = np.geomspace(1e-2, 1e5, 30_001)
    qs = np.concatenate([-np.geomspace(1e-6, 1.0, 400), [0.0], np.geomspace(1e-6, 1.0, 400)])
    best = ask("popov", loop)
    assert best.limit >= brute(loop, 0.0, qs, w) * (1 - 1e-6)
    assert best.limit == pytest.approx(min(brute(loop, 0.0, [best.multiplier], w), loop.gain_limit()), rel=1e-4)


def test_a_loop_that_leads_needs_a_negative_multiplier():
    """s^2/(s+1)^3: the best q is negative, as SciPy's own minimum says; q = 0 alone proves less."""
    loop = continuous_loop([1.0, 0.0, 0.0], [1.0], [1.0], [1.0, 3.0, 3.0, 1.0])
    w = np.geomspace(1e-3, 1e4, 40_001)
    g = loop.response(w)
    found = minimize_scalar(lambda q: np.max(-((1 + 1j * w * q) * g).real), bounds=(-5.0, 5.0), method="bounded")
    best = ask("popov", loop)
    assert best.multiplier < 0.0
    assert best.limit == pytest.approx(min(1 / found.fun, loop.gain_limit()), rel=1e-3)
    assert best.limit > 1.02 * ask("popov", loop, q=0.0).limit


def test_popov_with_no_multiplier_is_the_circle_criterion():
    for name in ("Lc", "no_delay"):
        for k1 in (0.0, 1.0):
            loop = reference_loops()[name]
            assert ask("popov", loop, k1, q=0.0).limit == pytest.approx(ask("circle", loop, k1).limit, rel=1e-9)


def test_the_curve_keeps_out_of_the_circle_of_the_certified_sector():
    loop = reference_loops()["L_star"]
    k2 = ask("circle", loop, 1.0).limit
    g = loop.response(np.geomspace(1e-3, loop.nyquist, 100_001))
    centre, radius = -(1 + 1 / k2) / 2, (1 - 1 / k2) / 2
    assert np.min(np.abs(g - centre)) == pytest.approx(radius, rel=1e-5)


def run(loop, phi, x, steps):
    """Simulates e = -(c x), x+ = a x + b phi(e); the size of the state at the end over that at the start."""
    first = np.linalg.norm(x)
    for k in range(steps):
        x = loop.a @ x + loop.b[:, 0] * phi(-float((loop.c @ x)[0]), k)
    return np.linalg.norm(x) / first


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_no_nonlinearity_of_a_certified_sector_makes_the_loop_unstable(seed):
    loop = random_rational(seed, 4e-3)
    rng = np.random.default_rng(seed)
    if loop.gain_limit(0.2) <= 0.2:  # unstable at the lower bound
        return
    for criterion in ("circle", "tsypkin", "jury-lee"):
        k2 = min(0.9 * ask(criterion, loop, 0.2).limit, 50.0)
        for _ in range(6):
            knee = 10 ** rng.uniform(-2, 1)
            if criterion == "circle":
                gains = rng.choice([0.2, k2], size=997)
                phi = lambda e, k, g=gains: g[k % 997] * e  # noqa: E731
            elif criterion == "tsypkin":  # monotone beyond 0.2 e: jumps at the knee, flat then
                phi = lambda e, k, c=knee, m=k2 - 0.2: 0.2 * e + np.sign(e) * m * c * (abs(e) >= c)  # noqa: E731
            else:  # slope from 0.2 to k2
                phi = lambda e, k, c=knee, m=k2 - 0.2: 0.2 * e + m * np.clip(e, -c, c)  # noqa: E731
            assert run(loop, phi, rng.normal(size=len(loop.a)), 4000) < 1.0


def test_a_gain_beyond_the_nyquist_limit_does_make_it_unstable():
    loop = reference_loops()["L_star"]
    k = loop.gain_limit()
    start = np.ones(len(loop.a))
    assert run(loop, lambda e, _: 1.01 * k * e, start, 4000) > 1e3
    assert run(loop, lambda e, _: 0.99 * k * e, start, 4000) < 1.0


def test_a_slope_bound_proves_more_than_monotony_and_that_more_than_the_circle():
    loop = reference_loops()["L_star"]
    limits = [ask(name, loop, 1.0).limit for name in ("circle", "tsypkin", "jury-lee")]
    assert limits[0] < limits[1] < limits[2] <= loop.gain_limit()


# ---- what an engineer is told


def test_a_sector_beyond_the_nyquist_limit_is_refused_with_the_limit():
    found = ask("popov", reference_loops()["Lc"], 1.0, 2.6)
    assert found.grade == "refused"
    assert (
        "reaches beyond the Nyquist limit: with a constant gain of 2.5 the loop already oscillates" in found.statement
    )


def test_an_unstable_loop_is_refused_with_its_pole():
    loop = LinearLoop(*(m.copy() for m in (reference_loops()["L_star"].a, *_times(3.0))), 0.5e-3)
    found = ask("circle", loop, 1.0, 1.5)
    assert found.grade == "refused"
    assert found.statement.startswith("The loop is unstable with a gain of 1 (a pole at |z| = 1.0")


def test_strong_integral_action_is_told_to_begin_its_sector_above_zero():
    loop = sampled_loop(xy_loop(TUNINGS["ours.pid_ms_185"], sine))
    said = "stable with a gain of 1 but not with every smaller one"
    assert any(said in w for w in ask("circle", loop, 0.0).warnings)
    assert not ask("circle", loop, 1.0).warnings
    never = continuous_loop([8.0, 160.0, 800.0], [1.0], [1.0], [1.0, 0.0, 0.0, 0.0])
    assert said in ask("popov", never, 0.0).statement


def test_a_continuous_model_that_fits_badly_says_so():
    notes = " ".join(ask("popov", reference_loops()["L0"], 1.0).warnings)
    assert "too far off to conclude anything" in notes
    assert "too far off" not in " ".join(ask("popov", reference_loops()["L_star"], 1.0).warnings)


def _times(gain):
    loop = reference_loops()["L_star"]
    return gain * loop.b, loop.c, loop.d


def test_a_nonlinearity_that_leaves_the_sector_is_refused_by_which_bound():
    loop, law = reference_loops()["Lc"], lure(npid)
    assert "gain falls to 1, below 1.5; ask for [1, 2.352]" in ask("circle", loop, 1.5, 2.0, nonlinearity=law).statement
    assert "gain reaches 2.352, above 2" in ask("circle", loop, 1.0, 2.0, nonlinearity=law).statement


def test_a_sector_from_zero_is_said_to_be_more_than_the_controller_needs():
    found = ask("popov", reference_loops()["Lc"], 0.0, nonlinearity=lure(npid))
    assert found.grade == "refused" and "reaches 1.408, the sector asked for 2.352" in found.statement
    assert any("never below 1; the sector from 0 asks for more than needed" in w for w in found.warnings)


def test_the_paper_s_controller_in_its_own_sector_is_proved_left_alone_but_warned_about_its_slope():
    found = ask("popov", reference_loops()["Lc"], nonlinearity=lure(npid))
    assert found.grade == "grid-checked" and found.sector == pytest.approx((1.0, 2.35241), abs=1e-4)
    assert any("slope of the nonlinearity reaches 5.546, above the Nyquist limit of 2.5:" in w for w in found.warnings)


def test_an_error_in_millimetres_is_asked_about():
    found = ask("popov", reference_loops()["Lc"], nonlinearity=lure(npid(error_unit_per_mm=1.0)))
    assert any(
        "counts its error in mm: at an error of 10 um its gain has changed by 1.3e-05" in w for w in found.warnings
    )
    sharp = ask("popov", reference_loops()["Lc"], nonlinearity=lure(npid))
    assert not any("is the unit right" in w for w in sharp.warnings)


def test_popov_of_a_sampled_loop_is_called_one_of_its_continuous_model():
    found = ask("popov", reference_loops()["L_star"], 1.0)
    assert found.loop["name"] == "continuous model of L_star" and found.loop["source"] == "model"
    assert found.warnings[0].startswith("Popov is a criterion for continuous loops")
    assert found.limit == pytest.approx(2.51, rel=0.02)


@pytest.mark.parametrize("criterion", ["tsypkin", "jury-lee"])
def test_a_sampled_criterion_refuses_a_continuous_loop(criterion):
    with pytest.raises(ValueRefused, match="is continuous; ask popov"):
        ask(criterion, TRIPLE)


def test_a_coarse_grid_of_the_caller_is_refused():
    found = ask("popov", reference_loops()["Lc"], 1.0, grid=np.geomspace(1e-4, 1e4, 100))
    assert found.grade == "refused" and "too coarse for the dead time" in found.statement


def test_bounds_out_of_order_are_refused():
    with pytest.raises(ValueRefused, match=r"sector \[2.0, 1.0\]"):
        ask("circle", TRIPLE, 2.0, 1.0)


def test_an_integrator_and_a_lower_bound_of_zero_ask_for_a_map_that_does_not_vanish():
    found = ask("popov", reference_loops()["Lc"], 0.0, 1.3)
    assert "every nonlinearity with 0 < phi(e)/e <= 1.3" in found.statement
    assert ask("popov", reference_loops()["Lc"], 0.0, 1.3, q=-1e-4).grade == "refused"


def test_a_certificate_is_saved_as_json_and_read_as_text():
    found = ask("circle", reference_loops()["L_star"], 1.0, 2.0)
    kept = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert kept["grade"] == "grid-checked" and kept["margin"] == pytest.approx(1.1325, abs=1e-3)
    assert kept["loop"] == {
        "name": "L_star", "kind": "sampled", "dt_s": 0.0005, "dead_time_s": 0.0, "order": 6, "source": "as exported"
    }  # fmt: skip
    text = found.report()
    assert "asked       [1, 2]" in text and "margin      1.133 times" in text
    endless = ask("popov", reference_loops()["no_delay"])
    assert json.loads(json.dumps(endless.as_dict(), allow_nan=False))["limit"] == "inf"


@pytest.mark.parametrize("asked", ["popov", "circle", "circle zero", "tsypkin", "jury_lee"])
def test_every_criterion_draws_its_plot_with_labels(asked):
    loops = reference_loops()
    made = {
        "popov": lambda: ask("popov", loops["Lc"], 1.0, 2.35),
        "circle": lambda: ask("circle", loops["L_star"], 1.0, 2.0),
        "circle zero": lambda: ask("circle", loops["L_star"]),
        "tsypkin": lambda: ask("tsypkin", loops["L_star"], 1.0, 2.2),
        "jury_lee": lambda: ask("jury-lee", loops["L_star"], 1.0, 2.2),
    }[asked]()
    axes = made.figure().axes[0]
    assert axes.get_xlabel() and axes.get_ylabel() and len(axes.get_legend().get_texts()) >= 2
