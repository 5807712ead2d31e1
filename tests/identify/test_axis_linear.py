"""Mass and friction by least squares, how sure they are, and what is said where the log does not tell them."""

from __future__ import annotations

import numpy as np
import pytest

from leadscrew.identify.axis import verdict
from leadscrew.identify.axis.delay import find_delay
from leadscrew.identify.axis.inverse_dynamics import Terms, blocks, huber, inverse_dynamics, weighted
from leadscrew.identify.axis.linear_stage import Setting, choose, folds, line, models, two_ways
from leadscrew.identify.axis.parameters import estimates_of, units
from leadscrew.identify.axis.record import Record, choose_length, corner_of, record
from leadscrew.util.errors import DataError
from tests.identify.axis_oracle import Axis
from tests.identify.axis_runs import AXIS, DT, run, shove

TRUE = {"mass": 50.0, "friction.forward.coulomb": 15.0, "friction.forward.viscous": 120.0, "offset": -2.0}


def corner(log: Record) -> float:
    return corner_of(choose_length(log), log.period)


def test_mass_friction_and_offset_of_a_shoved_axis_are_found():
    log = run()
    fit = inverse_dynamics(log, Terms(), corner(log))
    assert fit.values == pytest.approx(TRUE, rel=2e-3)
    assert fit.condition < 20.0


def test_friction_by_direction_holds_the_offset():
    log = run()
    fit = inverse_dynamics(log, Terms(symmetric=False), corner(log))
    assert fit.values["friction.forward.coulomb"] == pytest.approx(13.0, rel=2e-3)
    assert fit.values["friction.backward.coulomb"] == pytest.approx(17.0, rel=2e-3)
    assert "offset" not in fit.values
    known = inverse_dynamics(log, Terms(symmetric=False, known={"offset": -2.0}), corner(log))
    assert known.values["friction.forward.coulomb"] == pytest.approx(15.0, rel=2e-3)


def test_a_known_mass_is_not_sought_and_changes_nothing_else():
    log = run()
    fit = inverse_dynamics(log, Terms(known={"mass": 50.0}), corner(log))
    assert "mass" not in fit.keys
    assert fit.values == pytest.approx({k: v for k, v in TRUE.items() if k != "mass"}, rel=2e-3)


def test_an_exact_line_is_that_of_numpy_and_jolts_do_not_turn_it():
    rng = np.random.default_rng(4)
    z = rng.normal(size=(400, 3))
    b = z @ np.array([1.0, -2.0, 0.5]) + rng.normal(0.0, 0.01, 400)
    plain = np.linalg.lstsq(z, b, rcond=None)[0]
    assert huber(z, b)[0] == pytest.approx(plain, abs=1e-3)
    b[::20] += 5.0
    assert huber(z, b)[0] == pytest.approx([1.0, -2.0, 0.5], abs=3e-3)
    assert np.max(np.abs(np.linalg.lstsq(z, b, rcond=None)[0] - [1.0, -2.0, 0.5])) > 0.03


def test_standard_errors_are_the_usual_ones_for_white_noise_and_larger_for_coloured():
    rng = np.random.default_rng(5)
    z, white = np.column_stack([np.ones(4000), np.repeat(rng.normal(size=40), 100)]), rng.normal(size=4000)
    usual = np.sqrt(np.diag(np.linalg.inv(z.T @ z)))
    block = blocks(np.arange(4000), 10, 2)
    spread = weighted(z, white, np.ones(4000), block)
    assert np.sqrt(np.diag(spread.covariance)) == pytest.approx(usual, rel=0.35)
    assert ((spread.degrees > 10.0) & (spread.degrees < 40.0)).all()
    slow = np.repeat(rng.normal(size=40), 100)
    assert (np.sqrt(np.diag(weighted(z, slow, np.ones(4000), block).covariance)) > 5.0 * usual).all()


def test_a_late_drive_is_noticed_and_one_on_time_is_too():
    on_time = find_delay(run(), Terms(), corner(run()))
    assert on_time.used == 0.0 and on_time.sharp and on_time.high < 0.2
    late = run(delay=3)
    found = find_delay(late, Terms(), corner(late))
    assert found.low <= 3.0 <= found.high and found.high - found.low < 0.4
    fit = inverse_dynamics(late, Terms(), corner(late), delay=found.used)
    assert fit.values == pytest.approx(TRUE, rel=5e-3)


def test_a_log_of_one_direction_does_not_tell_the_offset():
    log = run(force=np.where(shove() > 0.0, 60.0, 20.0), axis=Axis(50.0, 120.0, 15.0, 2.0))
    assert not two_ways(log)
    fit = line(log, Terms(without=frozenset({"offset"})), corner(log), 0.0).fit
    assert fit.values["friction.forward.coulomb"] == pytest.approx(17.0, rel=5e-3)
    both = line(log, Terms(), corner(log), 0.0)
    assert "offset" in both.why and "cannot tell it from" in both.why["offset"]


def test_one_speed_alone_does_not_tell_viscous_friction():
    """Back and forth at one speed; what turns between is left out, as it is where the axis jerks."""
    rng = np.random.default_rng(6)
    side = np.repeat(np.where(np.arange(20) % 2, -1.0, 1.0), 400)
    x = np.cumsum(0.1 * side) * DT
    log = record(DT, np.round(x / 1e-7) * 1e-7, 27.0 * side - 2.0 + rng.normal(0.0, 0.1, 8000))
    found = line(log, Terms(known={"mass": 1e-3}), corner_of(40, DT), 0.0)
    assert "friction.forward.viscous" in found.why
    assert found.fit.values["friction.forward.coulomb"] == pytest.approx(27.0, rel=5e-3)


def test_friction_that_comes_out_negative_is_taken_as_none():
    log = run(axis=Axis(50.0, 1e-9, 15.0, 0.0), force=shove(size=25.0))
    pushed = record(DT, log.position, log.force - 40.0 * np.gradient(log.position, DT))
    found = line(pushed, Terms(), corner(log), 0.0)
    assert "viscous friction comes out at" in found.why["friction.forward.viscous"]
    assert "friction.forward.viscous" not in found.fit.values


def test_a_turned_sign_and_swapped_columns_are_refused():
    log = run()
    with pytest.raises(DataError, match=r"opposite signs.*--force-per-drive -1"):
        line(record(DT, -log.position, log.force), Terms(), corner(log), 0.0)
    with pytest.raises(DataError):
        line(record(DT, log.force, log.position), Terms(), corner(log), 0.0)


def test_the_simplest_model_is_taken_that_cross_validation_does_not_speak_against():
    log = run()
    found = choose(log.part(0, 4000), models("auto", None), Setting(corner(log), 0.0, {}, frozenset()))
    assert found[0].model.name == "Coulomb and viscous, alike both ways" and found[0].verdict == "chosen"
    assert len(found) == 4 and all(c.verdict for c in found)


def test_a_model_is_judged_by_the_force_of_stretches_that_its_line_has_not_seen():
    """By hand: each part is foretold by the line of the other three; rows that touch its border belong to none."""
    log = run()
    part = log.part(0, 4000)
    setting = Setting(corner(log), 0.0, {}, frozenset())
    chosen = choose(part, models("coulomb", None), setting)[0]
    squares, rows = 0.0, 0
    for k in range(4):
        inside = folds(4000, choose_length(log)) == k
        assert inside.sum() == 1000
        fit = inverse_dynamics(part.without(inside), Terms(), corner(log))
        assert not np.any(inside[fit.rows.at[fit.rows.used]])
        other = inverse_dynamics(part.without(~inside), Terms(), corner(log)).rows
        left = (other.force - other.matrix @ np.array([fit.values[key] for key in Terms().sought]))[other.used]
        squares, rows = squares + float(np.sum(left**2)), rows + len(left)
    assert chosen.rms == pytest.approx(np.sqrt(squares / rows), rel=1e-9)


def test_friction_that_is_unlike_by_direction_is_seen_where_it_is_foretold():
    """Backwards the same axis drags 40 % more: a force of 48 N s/m beside the drive, by direction."""
    log = run()
    v = np.gradient(log.position, DT)
    unlike = record(DT, log.position, log.force + np.where(v < 0.0, 48.0 * v, 0.0))
    found = choose(unlike.part(0, 4000), models("auto", None), Setting(corner(log), 0.0, {}, frozenset()))
    assert not found[0].model.symmetric
    assert found[0].line is not None
    assert found[0].line.fit.values["friction.backward.viscous"] == pytest.approx(168.0, rel=0.02)


def test_told_means_an_interval_of_use():
    log = run()
    good = estimates_of(inverse_dynamics(log, Terms(), corner(log)))
    assert all(good.parameter(key, "").identifiable for key in good.keys)
    low, high = good.ends("mass")
    assert low < 50.0 < high and high - low < 1.0
    noisy = record(DT, log.position, log.force + np.random.default_rng(7).normal(0.0, 900.0, 8000))
    poor = estimates_of(inverse_dynamics(noisy, Terms(), corner(log)))
    assert not poor.parameter("offset", "").identifiable


def test_units_are_those_of_the_drive_where_its_force_is_not_known():
    assert units("m", "N", True)["mass"] == "kg"
    assert units("rad", "N m", True)["mass"] == "kg m^2"
    volts = units("m", "V", False)
    assert volts["mass"] == "V s^2/m" and volts["friction.forward.viscous"] == "V s/m" and volts["offset"] == "V"
    assert units("m", "V", True)["mass"] == "kg"


def test_the_same_axis_is_found_at_rest_now_and_then():
    """The shoves stop for half a second each second: the axis stops, sticks and starts again."""
    force = shove()
    force[np.arange(8000) % 1000 > 500] = 0.0
    log = run(force=force, axis=AXIS._replace(offset=0.0))
    fit = inverse_dynamics(log, Terms(), corner(log))
    assert fit.rows.used.mean() < 0.9
    assert fit.values["mass"] == pytest.approx(50.0, rel=3e-3)
    assert fit.values["friction.forward.coulomb"] == pytest.approx(15.0, rel=0.01)


def gathered(monkeypatch, means, speed=0.06, coulomb=10.0, top=0.5):
    """Bins of a record that passes a speed once for each mean force left, and reaches the top speed in between."""
    at = np.tile([speed, speed, top], len(means))
    left = np.column_stack([means, means, np.zeros(len(means))]).ravel()
    monkeypatch.setattr(verdict, "force_left", lambda *_: (left, left))
    monkeypatch.setattr(verdict, "speed_of", lambda _: at)
    values = {"friction.forward.coulomb": coulomb, "friction.forward.viscous": 100.0}
    return verdict.bins(None, values | {"friction.backward.coulomb": coulomb}, 25, 0.0)[0]


@pytest.mark.parametrize(("mean", "lacks"), [(0.74, False), (0.76, True), (-0.76, True)])
def test_a_twentieth_of_the_friction_at_that_speed_may_be_missing(monkeypatch, mean, lacks):
    """0.06 m/s lies between a tenth and a fifth of the top speed of 0.5: friction of 10 + 100 * 0.05 = 15 N there."""
    found = gathered(monkeypatch, mean + 1e-3 * (-1.0) ** np.arange(8))
    assert (found.slow, found.fast, found.passages) == pytest.approx((0.05, 0.1, 8)) and found.lacks is lacks


def test_what_is_missing_must_be_surer_than_chance_in_sixteen_bins_of_a_thousand_logs(monkeypatch):
    from scipy.stats import ttest_1samp

    scatter = np.random.default_rng(2).standard_normal(9)
    seen = set()
    for mean in np.linspace(0.5, 6.0, 40):
        sure = ttest_1samp(scatter + mean, 0.0).pvalue < 1e-3 / 16.0
        assert gathered(monkeypatch, scatter + mean, coulomb=-5.0).lacks is bool(sure)
        seen.add(bool(sure))
    assert seen == {True, False}
