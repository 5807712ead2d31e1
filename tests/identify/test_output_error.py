"""Fits of a whole loop: known parameters come back, what the logs cannot tell is refused."""

import numpy as np
import pytest
from scipy.optimize import brentq, curve_fit

from leadscrew.controllers._vud.power_law import power_law
from leadscrew.identify.output_error import Trajectory, fit_output_error
from leadscrew.kernel.loop import Loop
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.references._step import step
from leadscrew.sensors._counts import encoder_count
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

GAIN, EXPONENT, SPEED = "controller.gain", "controller.exponent", "plant.full_duty_speed_mm_s"
TARGET = "reference.target"
BOUNDS = {GAIN: (0.3, 4.0), EXPONENT: (0.2, 1.2)}
TIME = np.arange(21) * 0.1


@pytest.fixture(scope="module")
def loop():
    return Loop(
        reference=step(initial=0.0, target=-50.0, time=0.0),
        controller=power_law,
        plant=lathe_servo,
        sensor=encoder_count,
        metrics={},
    )


def logs(loop, truth, time=TIME, targets=(-50.0, 190.0), noise=0.0):
    """Moves of a loop with known parameters, one run each, read off at the times of a log."""
    draw = np.random.default_rng(3)
    found = {}
    for target in targets:
        run = loop.using({**truth, TARGET: target}).run(2.2, record=("feedback",))
        value = np.interp(time, run.time, run["feedback"]) + noise * draw.standard_normal(len(time))
        found[f"to {target:g}"] = Trajectory(time, value, {TARGET: target})
    return found


@pytest.mark.parametrize("truth", [{GAIN: 1.4, EXPONENT: 0.7}, {GAIN: 0.8, EXPONENT: 0.5}, {GAIN: 2.5, EXPONENT: 1.0}])
def test_a_law_of_known_constants_gives_them_back(loop, truth):
    fit = fit_output_error(loop, logs(loop, truth), BOUNDS)
    assert fit.parameters == pytest.approx(truth, rel=2e-4)
    assert fit.converged and max(fit.nrmse_percent.values()) < 0.01 and fit.at_bound == ()


def test_speed_comes_back_too_where_the_duty_saturates(loop):
    truth = {GAIN: 2.0, EXPONENT: 0.8, SPEED: 240.0}
    fit = fit_output_error(loop, logs(loop, truth), {**BOUNDS, SPEED: (150.0, 400.0)})
    assert fit.parameters == pytest.approx(truth, rel=1e-3)


def test_gain_and_speed_that_act_only_as_a_product_are_refused(loop):
    """Below saturation the duty times the speed is all that the plant sees: 0.8 at 300 mm/s is 0.6 at 400 mm/s."""
    smooth = Loop(
        reference=step(initial=0.0, target=-50.0, time=0.0), controller=power_law, plant=lathe_servo, metrics={},
        sensor=encoder_count(resolution_mm=1e-9),
    )  # fmt: skip
    records = logs(smooth, {GAIN: 0.7, EXPONENT: 0.9, SPEED: 300.0}, targets=(-50.0, 100.0))
    with pytest.raises(DataError, match=r"cannot tell the parameters apart.*controller\.gain.*full_duty_speed"):
        fit_output_error(smooth, records, {GAIN: (0.3, 1.0), SPEED: (200.0, 400.0)}, start={GAIN: 0.7, SPEED: 300.0})


def test_a_parameter_that_does_nothing_is_refused_by_name(loop):
    records = logs(loop, {GAIN: 1.4, EXPONENT: 0.7})
    with pytest.raises(ValueRefused, match=r"plant\.grating_lag_s does not act on feedback between 0.001 and 0.02"):
        fit_output_error(loop, records, {GAIN: (0.3, 4.0), "plant.grating_lag_s": (0.001, 0.02)})


def test_the_standard_error_covers_what_noise_does(loop):
    """Fits of 12 noisy logs scatter as the standard error of one says."""
    truth = {GAIN: 1.4, EXPONENT: 0.7}
    clean = logs(loop, truth)
    draw = np.random.default_rng(8)
    found, said = [], []
    for _ in range(12):
        noisy = {
            name: r._replace(value=r.value + 0.01 * np.ptp(r.value) * draw.standard_normal(21))
            for name, r in clean.items()
        }
        fit = fit_output_error(loop, noisy, BOUNDS)
        found.append([fit.parameters[k] for k in BOUNDS])
        said.append([fit.standard_error[k] for k in BOUNDS])
    scatter = np.std(found, axis=0, ddof=1) / np.mean(said, axis=0)
    assert (scatter > 0.5).all() and (scatter < 1.7).all()  # 99 % of the chi distribution with 11 degrees: 0.49 to 1.56
    assert np.abs(np.mean(found, axis=0) - list(truth.values())) == pytest.approx(0.0, abs=3.0 * np.max(said))


def test_the_standard_error_is_the_one_that_scipy_states_for_the_same_samples(loop):
    """A scale of 1 nm, so that finite differences of SciPy's own size see a smooth curve."""
    smooth = loop.using({"sensor.resolution_mm": 1e-9})
    records = logs(smooth, {GAIN: 1.4, EXPONENT: 0.7}, targets=(-50.0,), noise=0.5)
    log = records["to -50"]

    def curve(time, gain, exponent):
        run = smooth.using({GAIN: gain, EXPONENT: exponent}).run(2.2, record=("feedback",))
        return np.interp(time, run.time, run["feedback"])

    fit = fit_output_error(smooth, records, BOUNDS)
    best, covariance = curve_fit(curve, log.time_s, log.value, (1.4, 0.7), epsfcn=1e-8)
    assert fit.parameters == pytest.approx(dict(zip(BOUNDS, best, strict=True)), rel=1e-3)
    # the Jacobian of ours is taken over 3e-3 of the bounds: 1 % of the gain
    assert list(fit.standard_error.values()) == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.03)


def test_the_fit_of_a_proportional_law_agrees_with_a_search_over_single_runs(loop):
    """One parameter, found a second way: the zero of the slope of a misfit that single runs of the loop measure."""
    fixed = loop.using({EXPONENT: 1.0})
    records = logs(loop, {GAIN: 1.4, EXPONENT: 0.8})

    def misfit(gain):
        parts = []
        for r in records.values():
            run = fixed.using({GAIN: gain, **r.changes}).run(2.2, record=("feedback",))
            parts.append((run["feedback"][np.rint(r.time_s * 1000).astype(int)] - r.value) / np.ptp(r.value))
        return sum(p @ p for p in parts)

    best = brentq(lambda g: misfit(g + 0.01) - misfit(g - 0.01), 1.0, 3.0, xtol=1e-4)
    fit = fit_output_error(fixed, records, {GAIN: (0.3, 4.0)})
    assert fit.parameters[GAIN] == pytest.approx(best, abs=2e-3)
    left = sum(21 * (0.01 * n) ** 2 for n in fit.nrmse_percent.values())
    assert left == pytest.approx(misfit(fit.parameters[GAIN]), rel=1e-9)


def test_times_between_two_periods_are_interpolated(loop):
    odd = np.sort(np.random.default_rng(5).uniform(0.0, 2.0, 40))
    truth = {GAIN: 1.4, EXPONENT: 0.7}
    fit = fit_output_error(loop, logs(loop, truth, time=odd), BOUNDS)
    assert fit.parameters == pytest.approx(truth, rel=2e-4)


def test_the_same_search_gives_the_same_fit_and_finds_a_far_minimum(loop):
    truth = {GAIN: 3.5, EXPONENT: 0.9}
    records = logs(loop, truth, noise=0.05)
    first, second = (
        fit_output_error(loop, records, BOUNDS, start={GAIN: 0.35, EXPONENT: 0.25}, search="global", generations=15)
        for _ in range(2)
    )
    assert first.parameters == second.parameters and first.runs == second.runs
    assert first.parameters == pytest.approx(truth, rel=0.02)


@pytest.mark.slow
def test_settings_that_diverge_on_the_way_do_not_stop_a_search(loop):
    """Near an exponent of 0 the law is a relay: it overshoots the bound of 50.2 mm, and those runs are lost."""
    truth = {GAIN: 1.4, EXPONENT: 0.7}
    narrow = loop.using(bound=50.2)
    assert np.isfinite(narrow.batch(2.0, {GAIN: [4.0, 1.4], EXPONENT: [0.2, 0.7]}).diverged_at).tolist() == [
        True,
        False,
    ]
    records = logs(loop, truth, targets=(-50.0,))
    lost = {GAIN: 4.0, EXPONENT: 0.2}
    fit = fit_output_error(narrow, records, BOUNDS, start=lost, search="global", generations=15)
    assert fit.parameters == pytest.approx(truth, rel=2e-3)
    with pytest.raises(ValueRefused, match=r"the loop diverges at controller\.gain = 4, .*another start"):
        fit_output_error(narrow, records, BOUNDS, start=lost)


def test_a_best_value_beyond_the_bounds_is_said_to_lie_on_one(loop):
    fit = fit_output_error(loop, logs(loop, {GAIN: 1.4, EXPONENT: 0.7}), {GAIN: (0.3, 1.0), EXPONENT: (0.2, 1.2)})
    assert fit.at_bound == (GAIN,) and fit.parameters[GAIN] == pytest.approx(1.0)


def test_weighing_samples_in_place_of_moves_serves_the_long_move(loop):
    records = logs(loop, {GAIN: 1.4, EXPONENT: 0.6})
    straight = loop.using({EXPONENT: 1.0})
    moves, samples = (
        fit_output_error(straight, records, {GAIN: (0.3, 4.0)}, equal_moves=e).nrmse_percent for e in (True, False)
    )
    assert samples["to 190"] < moves["to 190"] and samples["to -50"] > moves["to -50"]


def test_a_move_without_changes_runs_the_loop_as_it_is(loop):
    truth = {GAIN: 1.4, EXPONENT: 0.7}
    records = logs(loop, truth)
    records["to -50"] = records["to -50"]._replace(changes={})  # what the loop's own reference asks for
    assert fit_output_error(loop, records, BOUNDS).parameters == pytest.approx(truth, rel=2e-4)


def test_bad_logs_and_bounds_are_refused_by_name(loop):
    good = logs(loop, {GAIN: 1.4, EXPONENT: 0.7})
    one = next(iter(good.values()))
    for record, says in (
        (one._replace(time_s=TIME[:-1]), "shape"),
        (Trajectory(TIME[:2], one.value[:2]), "at least three"),
        (one._replace(time_s=TIME[::-1]), "must rise"),
        (one._replace(time_s=TIME - 0.1), "from 0 s or later"),
        (one._replace(value=np.ones(21)), "never moves"),
        (one._replace(value=np.where(TIME > 1, np.nan, one.value)), "not a finite number"),
    ):
        with pytest.raises(DataError, match=f"record bad: .*{says}"):
            fit_output_error(loop, {"bad": record}, BOUNDS)
    with pytest.raises(DataError, match="no records"):
        fit_output_error(loop, {}, BOUNDS)
    for bounds, options, says in (
        ({}, {}, "no parameter"),
        ({GAIN: (2.0, 1.0)}, {}, "controller.gain from 2 to 1"),
        ({GAIN: (-1.0, 1.0)}, {}, r"controller\.gain = -1"),
        (BOUNDS, {"start": {GAIN: 9.0}}, "controller.gain = 9 is outside"),
        (BOUNDS, {"start": {SPEED: 200.0}}, "is not fitted"),
        (BOUNDS, {"search": "everywhere"}, "local, global"),
        ({TARGET: (-60.0, -40.0)}, {}, "cannot set it"),
        (BOUNDS, {"signal": "actual"}, "several parts: .*actual.position"),
    ):
        with pytest.raises(ValueRefused, match=says):
            fit_output_error(loop, good, bounds, **options)
    with pytest.raises(NameUnknown, match=r"controller\.gains"):
        fit_output_error(loop, good, {"controller.gains": (0.1, 1.0)})
    with pytest.raises(NameUnknown, match="feedbak"):
        fit_output_error(loop, good, BOUNDS, signal="feedbak")
    with pytest.raises(NameUnknown, match=r"reference\.targets"):
        fit_output_error(loop, {"bad": one._replace(changes={"reference.targets": 1.0})}, BOUNDS)
