"""Force laws from tables: against hand-made tables, SciPy's fits, and 200 tables whose truth is known."""

import math

import numpy as np
import pytest

from leadscrew.analysis.cutting_force import ChipAndEdge, Kienzle, PowerLaw, feed_for, kienzle, slope, specific_force
from leadscrew.identify.cutting_force import ForceFit, bootstrap, chip_and_edge_model, fit_forces, fit_law, power_model
from leadscrew.identify.cutting_force_table import ForceTable
from leadscrew.util.errors import DataError, ValueRefused

FEEDS = np.array([0.1, 0.16, 0.25, 0.4, 0.1, 0.16, 0.25, 0.4])
DEPTHS = np.array([0.5, 0.5, 0.5, 0.5, 2.0, 2.0, 2.0, 2.0])


def table(force, feed=FEEDS, depth=DEPTHS, **others):
    return ForceTable(
        np.asarray(feed, float), np.asarray(depth, float), np.asarray(force, float), tuple(range(1, len(force) + 1)),
        others,
    )  # fmt: skip


def noisy(seed, share=0.03):
    scatter = np.exp(share * np.random.default_rng(seed).normal(size=len(FEEDS)))
    return table(2256.3 * DEPTHS * FEEDS**0.77 * scatter)


def test_a_power_law_and_kienzles_are_one_law_whatever_the_angle():
    law = Kienzle(1700.0, 0.25, 60.0)
    h, b = 0.3 * math.sin(math.pi / 3), 2.0 / math.sin(math.pi / 3)
    assert law.force(0.3, 2.0) == pytest.approx(1700.0 * b * h**0.75, rel=1e-14)
    back = kienzle(law.power(), 60.0)
    assert (back.kc11, back.mc) == pytest.approx((1700.0, 0.25), rel=1e-14)
    assert kienzle(law.power()).kc11 == pytest.approx(law.power().kf)
    with pytest.raises(ValueRefused, match="in proportion to the depth"):
        kienzle(PowerLaw(1000.0, 0.8, 0.9))
    with pytest.raises(ValueRefused, match="0, 90"):
        kienzle(PowerLaw(1000.0, 0.8), 120.0)


def test_s45c_holds_150_n_at_the_feed_worked_by_hand():
    law = PowerLaw(2256.3, 0.77)
    feed = feed_for(law, 150.0, 1.0)
    assert 1200.0 * feed == pytest.approx(1200.0 * math.exp(math.log(150.0 / 2256.3) / 0.77), rel=1e-12)
    step = 1e-7
    assert slope(law, feed, 1.0) == pytest.approx(
        float(law.force(feed + step, 1.0) - law.force(feed - step, 1.0)) / (2 * step), rel=1e-6
    )
    assert float(specific_force(150.0, feed, 1.0)) == pytest.approx(150.0 / feed)


def test_a_table_without_scatter_gives_its_law_back_by_every_method():
    exact = table(2256.3 * DEPTHS * FEEDS**0.77)
    for method in ("log-log", "relative", "absolute"):
        fit = fit_forces(exact, method=method)
        assert fit.law == pytest.approx((2256.3, 0.77, 1.0), rel=1e-9)
        assert fit.chosen.rms_percent < 1e-6 and fit.chosen.r2["log specific force"] == pytest.approx(1.0)
    assert fit.depth.p_value == 1.0 and not fit.notes


def test_chip_and_edge_gives_its_law_back_with_the_edge_as_long_as_the_angle_makes_it():
    truth = ChipAndEdge(1500.0, 40.0, 75.0)
    found = fit_forces(table(truth.force(FEEDS, DEPTHS)), kappa_deg=75.0).others["chip and edge, relative"]
    assert found.law == pytest.approx((1500.0, 40.0, 75.0), rel=1e-9)
    assert found.rms_percent < 1e-9 < fit_forces(table(truth.force(FEEDS, DEPTHS))).chosen.rms_percent


def test_the_log_log_fit_and_its_intervals_are_those_of_scipy():
    from scipy.stats import linregress, t

    cuts = noisy(1)
    line = linregress(np.log(cuts.feed), np.log(cuts.force / cuts.depth))
    fit = fit_forces(cuts).chosen
    kf, exponent = (fit.parameters[name].interval for name in ("kf", "exponent"))
    reach = t.ppf(0.975, 6) * line.stderr
    assert exponent == pytest.approx((line.slope, line.slope - reach, line.slope + reach), rel=1e-10)
    reach = t.ppf(0.975, 6) * line.intercept_stderr
    assert kf == pytest.approx(np.exp(line.intercept + np.array([0.0, -reach, reach])), rel=1e-10)
    assert fit.r2["log specific force"] == pytest.approx(
        linregress(np.log(cuts.feed), np.log(cuts.force / cuts.depth / cuts.feed)).rvalue ** 2, rel=1e-10
    )


@pytest.mark.parametrize(("method", "sigma"), [("relative", lambda f: f), ("absolute", np.ones_like)])
def test_the_nonlinear_fits_and_their_errors_are_those_of_curve_fit(method, sigma):
    from scipy.optimize import curve_fit
    from scipy.stats import t

    cuts = noisy(2)
    found, covariance = curve_fit(
        lambda x, kf, p: kf * x[1] * x[0] ** p, np.array([cuts.feed, cuts.depth]), cuts.force, p0=(2000.0, 0.8),
        sigma=sigma(cuts.force), xtol=1e-14, ftol=1e-14,
    )  # fmt: skip
    fit = fit_forces(cuts, method=method).chosen
    assert (fit.law.kf, fit.law.exponent) == pytest.approx(found, rel=1e-6)
    exponent = fit.parameters["exponent"]
    assert (exponent.high - exponent.low) / 2 == pytest.approx(t.ppf(0.975, 6) * math.sqrt(covariance[1, 1]), rel=1e-4)


def test_the_truth_lies_in_the_stated_intervals_of_200_tables_as_often_as_they_say():
    inside = {"kf": 0, "exponent": 0, "depth": 0, "next": 0}
    for seed in range(200):
        rng = np.random.default_rng(1000 + seed)
        kf, p, share = rng.uniform(800.0, 3000.0), rng.uniform(0.6, 0.95), rng.uniform(0.005, 0.08)
        force = kf * DEPTHS * FEEDS**p * np.exp(share * rng.normal(size=len(FEEDS)))
        cuts = table(force)
        law, free = (fit_law(power_model(depth_free=x), "log-log", cuts) for x in (False, True))
        fit = ForceFit(cuts, law, {}, None, 90.0, False, ())
        inside["kf"] += law.parameters["kf"].interval.holds(kf)
        inside["exponent"] += law.parameters["exponent"].interval.holds(p)
        inside["depth"] += free.parameters["depth_exponent"].interval.holds(1.0)
        inside["next"] += fit.force(0.2, 1.0)[0].holds(kf * 0.2**p * math.exp(share * rng.normal()))
    assert all(180 <= n <= 198 for n in inside.values()), inside


@pytest.mark.parametrize("method", ["log-log", "relative", "absolute"])
@pytest.mark.parametrize(
    "model", [power_model(), power_model(0.8), power_model(depth_free=True), chip_and_edge_model()]
)
def test_a_row_left_out_is_judged_by_the_law_of_the_others(method, model):
    method = "relative" if method == "log-log" and not model.logarithmic else method
    cuts = noisy(3)
    fit = fit_law(model, method, cuts)
    for i in (0, 5):
        f, a, force = (np.delete(x, i) for x in (cuts.feed, cuts.depth, cuts.force))
        law = fit_law(model, method, table(force, f, a)).law
        modelled = float(law.force(cuts.feed[i], cuts.depth[i]))
        assert fit.left_out_percent[i] == pytest.approx(100.0 * (cuts.force[i] / modelled - 1.0), rel=1e-6)
    assert fit.left_out_rms_percent > fit.rms_percent


def test_a_long_table_is_quick_and_its_error_left_out_is_the_same(monkeypatch):
    from leadscrew.identify import cutting_force

    rng = np.random.default_rng(8)
    feed, depth = rng.uniform(0.1, 0.5, 60), rng.uniform(0.5, 3.0, 60)
    cuts = table(1800.0 * depth * feed**0.75 * np.exp(0.04 * rng.normal(size=60)), feed, depth)
    for method in ("relative", "absolute"):
        one_by_one = fit_law(power_model(), method, cuts).left_out_percent
        monkeypatch.setattr(cutting_force, "MOST_REFITTED", 10)
        np.testing.assert_allclose(fit_law(power_model(), method, cuts).left_out_percent, one_by_one, atol=0.1)
        monkeypatch.undo()


def test_the_one_row_that_tells_the_exponent_cannot_be_left_out():
    for method in ("log-log", "relative"):
        fit = fit_forces(table([300.0, 590.0, 880.0, 520.0], [0.2, 0.2, 0.2, 0.4], [1.0, 2.0, 3.0, 1.0]), method=method)
        assert np.isnan(fit.chosen.left_out_percent).tolist() == [False, False, False, True]


def test_a_force_that_is_not_in_proportion_to_the_depth_is_said_so():
    scatter = np.exp(0.01 * np.random.default_rng(4).normal(size=8))
    fit = fit_forces(table(1600.0 * DEPTHS**0.85 * FEEDS**0.8 * scatter))
    assert fit.depth.exponent.interval.holds(0.85) and fit.depth.p_value < 1e-3
    assert any("not in proportion to the depth" in note for note in fit.notes)
    assert fit_forces(noisy(5)).depth.exponent.interval.holds(1.0)


def test_what_a_table_cannot_tell_is_refused_or_said():
    one_feed = table([300.0, 610.0, 900.0], [0.2, 0.2, 0.2], [1.0, 2.0, 3.0])
    with pytest.raises(DataError, match=r"every cut has the feed 0\.2 mm/rev: one feed says nothing"):
        fit_forces(one_feed)
    given = fit_forces(one_feed, exponent=0.75)
    assert given.law.exponent == 0.75 and "exponent" not in given.chosen.parameters
    assert given.law.kf == pytest.approx(np.exp(np.mean(np.log([300 / 1, 610 / 2, 900 / 3]))) / 0.2**0.75)
    assert any("was given, not fitted" in note for note in given.notes)
    with pytest.raises(DataError, match="2 cuts: a law of two parameters passes through two points"):
        fit_forces(table([300.0, 500.0], [0.2, 0.4], [1.0, 1.0]))
    one_depth = fit_forces(table([300.0, 420.0, 520.0, 610.0], [0.2, 0.3, 0.4, 0.5], [1.0] * 4))
    assert one_depth.depth is None and any("assumed, not tested" in note for note in one_depth.notes)
    together = fit_forces(table([100.0, 300.0, 1000.0, 2900.0], [0.1, 0.2, 0.4, 0.8], [0.5, 1.0, 2.0, 4.0]))
    assert together.depth is None and any("cannot be separated" in note for note in together.notes)
    narrow = fit_forces(table([300.0, 320.0, 336.0, 352.0], [0.2, 0.22, 0.24, 0.26], [1.0] * 4))
    assert any("rests on little" in note for note in narrow.notes)


def test_a_feed_outside_the_table_is_marked_and_its_interval_grows():
    fit = fit_forces(noisy(6))
    (_, *near), inside = fit.force(0.2, 1.0)
    (_, *far), outside = fit.force(0.02, 1.0)
    assert inside and not outside
    assert far[1] / far[0] > near[1] / near[0]
    with pytest.raises(ValueRefused, match="must be above 0"):
        fit.force(-0.1, 1.0)


def test_bootstrap_intervals_of_many_rows_are_near_those_of_students_t():
    rng = np.random.default_rng(7)
    feed, depth = rng.uniform(0.1, 0.5, 60), rng.uniform(0.5, 3.0, 60)
    fit = fit_forces(table(1800.0 * depth * feed**0.75 * np.exp(0.04 * rng.normal(size=60)), feed, depth))
    for name, drawn in bootstrap(fit).items():
        stated = fit.chosen.parameters[name]
        assert (drawn.high - drawn.low) / (stated.high - stated.low) == pytest.approx(1.0, abs=0.12)
    with pytest.raises(ValueRefused, match="100 to 1000000"):
        bootstrap(fit, 3)


@pytest.mark.parametrize(
    ("more", "says"),
    [({"method": "best"}, "log-log"), ({"kappa_deg": 0.0}, "0, 90"), ({"exponent": 1.5}, "0, 1")],
)
def test_options_that_are_none_are_refused(more, says):
    with pytest.raises(ValueRefused, match=says):
        fit_forces(noisy(1), **more)


def test_the_interval_of_the_force_in_the_middle_of_a_table_is_that_of_curve_fit():
    """Of chip and edge, written with the specific force at the middle in place of Ktc."""
    from scipy.optimize import curve_fit
    from scipy.stats import t

    cuts = noisy(2)
    middle = np.exp(np.log(cuts.feed).mean())
    (kc, _), covariance = curve_fit(
        lambda x, kc, edge: (kc - edge / middle) * x[0] * x[1] + edge * x[1],
        np.array([cuts.feed, cuts.depth]),
        cuts.force,
    )
    fit = fit_law(chip_and_edge_model(), "absolute", cuts)
    reach = t.ppf(0.975, len(cuts.force) - 2) * math.sqrt(covariance[0, 0])
    assert fit.middle == pytest.approx((kc, kc - reach, kc + reach), rel=1e-5)
