"""Friction from one log: what comes back of the truth, what the log cannot tell, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction import FITTED, _Problem, _result, fit_friction
from leadscrew.identify.friction_file import controller_with
from leadscrew.identify.friction_record import Record, Sliding, checked, pieces, replay_loop, sliding
from leadscrew.plants._ballscrew_stage import INERTIA
from leadscrew.references._friction_test import ROWS, friction_test, friction_test_duration, plan_rows
from leadscrew.util.errors import DataError, ValueRefused
from tests.identify.friction_records import HARDER, off_percent, record

TRUE = LuGre()


@pytest.mark.slow
def test_the_friction_test_gives_all_six_parameters_back():
    fit = fit_friction(*record("test"))
    off = off_percent(fit, **TRUE._asdict())
    assert off["stiffness"] < 1.0 and off["damping"] < 1.0
    assert off["static"] < 5.0 and off["stribeck_speed"] < 5.0
    assert off["coulomb"] < 0.01 and off["viscous"] < 0.01
    assert abs(fit.inertia / INERTIA - 1.0) < 0.01
    assert all(fit.identifiable.values()) and fit.consistent


@pytest.mark.slow
def test_an_axis_with_more_friction_is_found_by_the_same_test():
    fit = fit_friction(*record("test", HARDER))
    off = off_percent(fit, **TRUE._replace(coulomb=1.2 * 6.24, static=1.2 * 9.36)._asdict())
    assert max(off["stiffness"], off["damping"]) < 1.0 and max(off["static"], off["stribeck_speed"]) < 5.0


@pytest.mark.slow
def test_sines_determine_stiffness_and_damping_and_leave_static_friction_not_identifiable():
    said = []
    fit = fit_friction(*record("sines"), progress=lambda what, done: said.append((what, done)))
    off = off_percent(fit, **TRUE._asdict())
    assert off["stiffness"] < 1.0 and off["damping"] < 1.0 and off["coulomb"] < 0.01 and off["viscous"] < 0.01
    assert not fit.identifiable["static"] and not fit.identifiable["stribeck_speed"]
    assert fit.identifiable["stiffness"] and fit.identifiable["damping"]
    assert fit.condition > 1e3
    assert {what for what, _ in said} == {"sliding", "coarse grid", "descent"}
    assert all(0.0 <= done <= 1.0 for _, done in said)


def test_sliding_is_the_line_that_made_it():
    t = np.arange(0.0, 4.0, 2.5e-4)
    held = 2.0 * math.pi * (t + 1.25e-4)  # the torque of a period is the one of its middle
    speed, slope = 3.0 * np.sin(held), 6.0 * math.pi * np.cos(held)
    angle = 3.0 / (2.0 * math.pi) * (1.0 - np.cos(2.0 * math.pi * t))
    found = sliding(checked(t, 5.0 * np.sign(speed) + 0.3 * speed + 1e-3 * slope + 0.7, angle))
    assert found.coulomb == pytest.approx(5.0, rel=1e-3) and found.viscous == pytest.approx(0.3, rel=1e-2)
    assert found.inertia == pytest.approx(1e-3, rel=2e-2) and found.offset == pytest.approx(0.7, rel=1e-3)


@pytest.mark.slow
def test_a_piece_played_back_moves_as_scipy_says():
    dt = 2.5e-4
    torque = 6.0 * np.sin(2.0 * math.pi * np.arange(80) / 160.0)
    loop = replay_loop(torque, np.zeros(80), dt, INERTIA).using({"reference.length": 80.0, "controller.kp": 0.0})
    ours = -loop.run(80 * dt, record=("controller.e",))["controller.e"]
    state, angles, f = np.zeros(3), [], TRUE
    for k in range(80):
        angles.append(state[0])

        def rates(t, s, u=torque[k]):
            level = f.coulomb + (f.static - f.coulomb) * math.exp(-((s[1] / f.stribeck_speed) ** 2))
            bent = s[1] - abs(s[1]) * s[2] * f.stiffness / level
            return [s[1], (u - f.stiffness * s[2] - f.damping * bent - f.viscous * s[1]) / INERTIA, bent]

        state = solve_ivp(rates, (0.0, dt), state, method="Radau", rtol=1e-8, atol=1e-12).y[:, -1]
    assert np.abs(ours - angles).max() < 1e-3 * np.abs(angles).max()


@pytest.mark.slow
def test_with_the_truth_each_piece_leaves_the_rounding_of_the_scale():
    log = checked(*record("sines"))
    assert log.count == pytest.approx(1e-5 / 1.5923, rel=1e-6)
    slide = sliding(log)
    problem = _Problem(log, slide, INERTIA, pieces(log, slide))
    x = np.log([TRUE.stiffness, TRUE.damping / TRUE.stiffness, TRUE.static - TRUE.coulomb, TRUE.stribeck_speed])
    problem.free_starts(x)
    for left in problem.by_piece(x).values():
        assert np.sqrt(np.mean(left**2)) < 1.2


@pytest.mark.slow
def test_a_torque_that_acts_a_period_late_is_found_with_the_delay_given():
    time, torque, angle = record("sines")
    late = np.concatenate([torque[1:], torque[-1:]])
    right = fit_friction(time, late, np.roll(angle, 0), delay=0)
    shifted = fit_friction(time[:-1], torque[1:], angle[:-1], delay=1)
    assert off_percent(shifted, stiffness=TRUE.stiffness)["stiffness"] < 1.0
    assert off_percent(right, stiffness=TRUE.stiffness)["stiffness"] > 2.0


def _changed(name, value, at=1000):
    parts = dict(zip(("time", "torque", "angle"), (p.copy() for p in record("sines")), strict=True))
    parts[name][at] = value
    return list(parts.values())


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda t, u, y: (t, y, u), "backwards|swapped|Coulomb"),
        (lambda t, u, y: (t, -u, y), "swapped, or has one the other sign"),
        (lambda t, u, y: (t, np.full_like(u, 3.0), y), "torque is the same, 3, in all samples"),
        (lambda t, u, y: (t, u, np.zeros_like(y)), "position is the same, 0, in all samples"),
        (lambda t, u, y: (t[:400], u[:400], y[:400]), "has 400 samples"),
        (lambda t, u, y: (t[:1400], u[:1400], y[:1400]), "0 s backwards"),
        (lambda *log: [np.delete(part, 500) for part in log], "from sample 500 to 501 pass 0.0005"),
        (lambda t, u, y: (10.0 * t, u, y), "bristles need one every 0.002 s"),
        (lambda t, u, y: (t, u[:-1], y), "expected equal ones"),
    ],
)  # fmt: skip
def test_a_log_that_cannot_tell_is_refused_in_one_sentence(spoil, says):
    with pytest.raises(DataError, match=says) as refusal:
        fit_friction(*spoil(*record("sines")))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("name", "value"), [("torque", math.nan), ("angle", math.inf), ("time", math.nan)])
def test_a_value_that_is_no_number_is_named_by_its_sample(name, value):
    with pytest.raises(DataError, match="sample 1001 is"):
        fit_friction(*_changed(name, value))


def test_an_inertia_or_delay_out_of_range_is_refused():
    with pytest.raises(ValueRefused, match="inertia = 0"):
        fit_friction(*record("sines"), inertia=0)
    with pytest.raises(DataError, match="delay = 100"):
        fit_friction(*record("sines"), delay=100)


def test_rows_of_the_friction_test_begin_and_end_at_rest():
    block, dt = friction_test(), 1e-6
    plan, ends = plan_rows(block.params, 2.5e-4), np.cumsum([n / f for _, f, n in ROWS])
    assert friction_test_duration() == pytest.approx(ends[-1]) and friction_test_duration() < 8.0
    for t in (0.0, *(ends - 1e-9), *(ends + 1e-9), 100.0):
        motion = block(plan, t)
        assert abs(motion.position) < 1e-6 and abs(motion.velocity) < 1e-4
    for t in (0.3, 2.05, 4.0, 7.13):
        before, now, after = (block(plan, t + d) for d in (-dt, 0.0, dt))
        assert now.velocity == pytest.approx((after.position - before.position) / (2.0 * dt), rel=1e-4, abs=1e-7)
        assert now.acceleration == pytest.approx((after.velocity - before.velocity) / (2.0 * dt), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("rows", [[], [(1.0, 2.0)], [(1.0, 0.0, 1.0)], [(1.0, 1.0, 0.5)], "abc"])
def test_rows_that_are_none_are_refused(rows):
    with pytest.raises(ValueRefused):
        friction_test(rows)


class Solved:
    """Eighty samples that the model misses by twice the noise, twenty samples for each parameter alone, and outliers.

    An outlier would say a great deal about the stiffness, were it counted.
    """

    simulations = 0
    pieces = ()

    def __init__(self, outliers, rise=1e9, slope=80.0):
        self.left = np.array([2.0, -2.0] * 40 + [1000.0] * outliers)
        self.slopes = np.zeros((len(self.left), 4))
        self.slopes[np.arange(80), np.arange(80) % 4] = slope
        self.slopes[80:, 0] = 1e6
        self.rise = rise

    def jacobian(self, x):
        return self.slopes

    def by_sliding(self, x, given):
        return np.zeros((len(self.left), 3))

    def by_piece(self, x):
        return {0.0: self.left}

    def residuals(self, points):
        return self.left[None]

    def friction(self, x):
        return LuGre(1e4, 50.0, 0.1, 6.0, 9.0, 0.01)

    def worse_elsewhere(self, x):
        return self.rise


def solved(*args, **more):
    log = Record(1e-3, np.zeros(9), np.zeros(9), 1e-6, 1e-6)
    slide = Sliding(6.0, 0.1, 1e-3, 0.0, dict.fromkeys(("coulomb", "viscous", "inertia", "offset"), 1e-4), 0.0, 9, 1.0)
    return _result(log, slide, 1e-3, False, Solved(*args, **more), np.zeros(4))


@pytest.mark.parametrize("outliers", [0, 5])
def test_slips_that_come_a_sample_late_do_not_count_in_the_noise_and_the_errors(outliers):
    """By hand: 20 samples of slope 80 each, noise 2, so ln-errors of 2 / (80 sqrt(20)) = 0.00559."""
    fit = solved(outliers)
    alone = 2.0 / (80.0 * math.sqrt(20.0))
    # sigma_1 is sigma_0 times the fitted ratio; static friction is 3 N m above Coulomb friction, known to 1e-4 N m
    expected = (1e4 * alone, 50.0 * math.sqrt(2.0) * alone, math.hypot(3.0 * alone, 1e-4), 0.01 * alone)
    assert [fit.standard_error[n] for n in FITTED] == pytest.approx(expected)
    assert fit.correlation["stiffness"]["damping"] == pytest.approx(math.sqrt(0.5))


def test_residuals_of_twice_the_noise_are_reported():
    fit = solved(0)
    assert fit.rms == pytest.approx(2e-6) and not fit.consistent
    assert fit.residuals.why_not == "the residuals are 2 times the noise"


def test_what_is_known_to_a_quarter_is_identifiable_and_what_is_not_is_not():
    for error, known in ((0.127, True), (0.128, False)):
        slope = 2.0 / (error * math.sqrt(20.0))
        problem = Solved(0, slope=200.0)
        problem.slopes[:, 3] *= slope / 200.0
        log = Record(1e-3, np.zeros(9), np.zeros(9), 1e-6, 1e-6)
        fit = _result(log, solved(0).sliding, 1e-3, False, problem, np.zeros(4))
        assert fit.identifiable["stribeck_speed"] is known and fit.identifiable["static"], slope
        assert fit.standard_error["stribeck_speed"] == pytest.approx(0.01 * error)


def test_static_friction_is_identifiable_only_where_half_and_double_of_it_fit_worse_by_six_deviations():
    """The noise is twice the expected one: the cost of 20 becomes 20 * 2^2 = 80."""
    assert solved(0, rise=81.0).identifiable["static"]
    assert not solved(0, rise=79.0).identifiable["static"] and solved(0, rise=79.0).identifiable["stiffness"]
    assert math.isinf(solved(0, rise=79.0).standard_error["stribeck_speed"])


def test_what_is_not_identifiable_is_not_written_into_the_controller_file():
    """It was a usual value, and the feed-forward believed it."""
    fit = solved(0, rise=0.0)
    assert not fit.identifiable["static"] and not fit.identifiable["stribeck_speed"]
    file = controller_with(fit, "fsmc_ballscrew", "ours.pd_dob", "log.csv")
    assert set(file.parameters) == {f"hat.{n}" for n in ("stiffness", "damping", "viscous", "coulomb")} | {"inertia"}
    assert "not identifiable from the log, so the controller's own: static, stribeck_speed" in file.tuning["notes"]
    assert set(file.tuning["standard_error_percent"]) == {"stiffness", "damping", "viscous", "coulomb"}
    assert "not quite LuGre: the residuals are 2 times the noise" in file.tuning["notes"]


def test_a_controller_is_not_left_with_less_static_than_coulomb_friction():
    fit = solved(0, rise=0.0)
    rough = replace(fit, friction=fit.friction._replace(coulomb=12.0, static=18.0))
    with pytest.raises(ValueRefused, match=r"hat.static = 9.36 N m of ours.pd_dob lies below .* 12 N m"):
        controller_with(rough, "fsmc_ballscrew", "ours.pd_dob", "log.csv")


def slid(coulomb=5.0, noise=0.0, seed=0, seconds=2.0, speed=3.0):
    """Time, torque, angle of a sine of 1 Hz at 1 kHz with Coulomb friction, 0.3 viscous, 1e-3 kg m^2."""
    t = np.arange(round(seconds * 1000)) * 1e-3
    v = speed * np.sin(2.0 * math.pi * (t + 5e-4))
    push = coulomb * np.sign(v) + 0.3 * v + 1e-3 * 2.0 * math.pi * speed * np.cos(2.0 * math.pi * (t + 5e-4))
    return t, push + noise * np.random.default_rng(seed).standard_normal(len(t)), -speed / (2.0 * math.pi) * np.cos(
        2.0 * math.pi * t
    )  # fmt: skip


def test_the_standard_errors_of_sliding_are_what_noise_of_the_torque_scatters():
    """60 records: a standard deviation of four numbers each, so about a sixteenth of itself is not known."""
    found = [sliding(checked(*slid(noise=0.5, seed=k))) for k in range(60)]
    for name in ("coulomb", "viscous", "offset"):
        stated = np.mean([f.standard_error[name] for f in found])
        assert np.std([getattr(f, name) for f in found], ddof=1) == pytest.approx(stated, rel=0.25), name


def test_a_few_shocks_of_the_torque_do_not_move_the_friction():
    t, torque, angle = slid(noise=0.05)
    calm = sliding(checked(t, torque, angle))
    for at in (230, 740, 1260, 1700):
        torque[at : at + 5] += 40.0
    shaken = sliding(checked(t, torque, angle))
    assert (shaken.coulomb, shaken.viscous) == pytest.approx((calm.coulomb, calm.viscous), abs=0.02)


@pytest.mark.parametrize(("turned", "refused"), [(0, False), (1, False), (2, True)])
def test_torque_against_the_motion_in_more_than_a_fifth_of_the_sliding_is_refused(turned, refused):
    """Of eight strokes one (an eighth) or two (a quarter) are pulled along by the load."""
    t, torque, angle = slid(seconds=4.0)
    torque[: 500 * turned] *= -1.0
    if refused:
        with pytest.raises(DataError, match=r"same way in 7[3-7] % of the sliding"):
            sliding(checked(t, torque, angle))
    else:
        assert sliding(checked(t, torque, angle)).coulomb == pytest.approx(5.0, abs=0.5)


def test_a_fifth_of_a_second_of_sliding_is_needed_each_way():
    """Once forth for 0.5 s, and back until it has slid for so long."""
    t, torque, angle = slid()
    for end, said in ((0.64, "slides 0.4[0-9]* s forwards and 0.[01][0-9]* s backwards"), (0.9, "")):
        part = slice(0, round(1000 * end))
        if said:
            with pytest.raises(DataError, match=said):
                sliding(checked(t[part], torque[part], angle[part]))
        else:
            assert sliding(checked(t[part], torque[part], angle[part])).coulomb == pytest.approx(5.0, rel=0.02)
