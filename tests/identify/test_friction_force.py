"""Friction from a measured force: the models along a path, what is found of a known friction, what is refused."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from leadscrew.analysis.friction import friction_along
from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.dahl import Dahl
from leadscrew.friction.maxwell_slip import MaxwellSlip
from leadscrew.friction.static_map import Sliding
from leadscrew.identify.friction_force import force_record, identify_friction_force, settings
from leadscrew.identify.friction_force.models import dahl_force, lugre_force, stops
from leadscrew.identify.friction_force.record import encoder_step, without_flicker
from leadscrew.identify.friction_force.result import lugre_of, map_of
from leadscrew.plants._servo_axis_lugre import servo_axis_lugre
from leadscrew.util.errors import DataError, ValueRefused
from tests.identify.friction_force_logs import PERIOD, TRUTH, cosines, log


@pytest.fixture(scope="module")
def made():
    t, x, force = log(count=2e-8)
    return identify_friction_force(force_record(t, force, position=x))


def along(position, force=None, dt=PERIOD):
    """A record whose speed is the one with which a sample was reached, as friction_along has it."""
    t = dt * np.arange(len(position))
    travel = np.diff(position, prepend=position[0])
    record = force_record(t, np.sign(travel) if force is None else force, position=position)
    return dataclasses.replace(record, travel=travel, speed=travel / dt)


def test_every_value_of_a_known_friction_lies_in_its_interval(made):
    found = made.chosen.parameters
    truth = {"friction.stiffness": TRUTH.stiffness, "friction.damping": TRUTH.damping}
    for side in ("forward", "backward"):
        truth |= {f"friction.{side}.{name}": v for name, v in getattr(TRUTH, side)._asdict().items()}
    assert set(found) == set(truth)
    for key, value in truth.items():
        p = found[key]
        # an interval holds in 95 of 100 cases: three times its width for ten of them at once
        assert abs(p.value - value) < 1.5 * (p.high - p.low), key
        assert p.identifiable and p.how == "fitted", key
    assert found["friction.stiffness"].value == pytest.approx(2e5, rel=0.005)
    assert found["friction.forward.static"].value == pytest.approx(4.5, rel=0.005)


def test_the_error_on_the_hold_out_is_the_noise_of_the_force(made):
    assert made.chosen.holdout_rms == pytest.approx(0.02, rel=0.1)
    assert made.amplitude == pytest.approx(0.5 * np.ptp(made.record.force[made.training :]))
    base = made.models["Coulomb and viscous"].holdout_rms
    assert made.better_percent("LuGre") == pytest.approx(100.0 * (1.0 - made.chosen.holdout_rms / base))
    left = made.record.force - made.chosen.simulated
    assert made.chosen.holdout_rms == pytest.approx(np.sqrt(np.mean(left[made.training :] ** 2)))


def test_no_force_of_the_hold_out_is_seen_by_a_fit(made):
    r = made.record
    force = r.force.copy()
    force[made.training :] = force[made.training :][::-1] + 7.0
    other = identify_friction_force(dataclasses.replace(r, force=force))
    for name, model in made.models.items():
        assert other.models[name].parameters == model.parameters, name
        assert np.array_equal(other.models[name].simulated, model.simulated), name
    assert other.chosen.holdout_rms > 5.0


def test_binned_friction_lies_on_the_steady_curve(made):
    fast = [b for b in made.bins if abs(b.speed) > 1.5e-3]
    assert any(b.speed < 0.0 for b in fast) and any(b.speed > 0.0 for b in fast)
    for b in fast:
        way = TRUTH.forward if b.speed > 0.0 else TRUTH.backward
        assert b.force == pytest.approx(np.sign(b.speed) * way.coulomb + way.viscous * b.speed, abs=0.05)


def test_lugre_along_a_path_is_that_of_the_friction_functions():
    f = TwoSidedLuGre(2e5, 300.0, Sliding(3.0, 3.0, 1.0, 120.0), Sliding(2.0, 2.0, 1.0, 80.0))
    x = cosines()[::10]
    assert lugre_force(f, along(x)) == pytest.approx(friction_along(f, x, PERIOD), abs=1e-10)


def test_lugre_with_a_stribeck_fall_is_the_solution_of_its_differential_equation():
    from scipy.integrate import solve_ivp

    f, w, size = TRUTH, 2.0 * np.pi / 0.4, 0.3e-3

    def level(v):
        way = f.forward if v >= 0.0 else f.backward
        return way.coulomb + (way.static - way.coulomb) * np.exp(-((v / way.stribeck_speed) ** 2))

    t = np.linspace(0.0, 0.8, 801)
    v = size * w * np.sin(w * t)

    def rate(time, z):
        speed = size * w * np.sin(w * time)
        return [speed - abs(speed) * z[0] * f.stiffness / level(speed)]

    z = solve_ivp(rate, (0.0, 0.8), [0.0], t_eval=t, method="LSODA", rtol=1e-9, atol=1e-15, max_step=1e-4).y[0]
    g = np.array([level(s) for s in v])
    force = f.stiffness * z + f.damping * (v - np.abs(v) * z * f.stiffness / g) + 120.0 * v
    x = size * (1.0 - np.cos(w * t))
    record = dataclasses.replace(along(x, dt=1e-3), speed=v)
    assert lugre_force(f, record) == pytest.approx(force, abs=0.01)


@pytest.mark.parametrize("exponent", [1.0, 0.5, 1.7])
def test_dahl_along_a_path_is_that_of_the_friction_functions(exponent):
    f = Dahl(stiffness=1e5, coulomb=2.0, exponent=exponent, viscous=50.0)
    x = cosines()[::10]
    assert dahl_force(f, along(x)) == pytest.approx(friction_along(f, x, PERIOD), abs=1e-6)


def test_elements_along_a_path_are_those_of_maxwell_slip():
    f = MaxwellSlip(np.array([0.3, 0.7]), np.array([2e5, 1e5]), 0.0, 100.0, 0.0, 0.0, 2.0, 2.0, 1.0)
    x = cosines()[::10]
    yields = f.share * f.coulomb / f.stiffness
    forces = stops(along(x), yields) @ (f.share * f.coulomb)
    assert forces == pytest.approx(friction_along(f, x, PERIOD), abs=1e-10)


@pytest.mark.slow
def test_maxwell_slip_is_found_without_a_search():
    truth = MaxwellSlip(np.array([0.4, 0.6]), np.array([2e5, 4e4]), 0.0, 100.0, 0.0, 0.0, 2.0, 2.0, 1.0)
    t, x, force = log(truth, noise=0.005)
    fit = identify_friction_force(force_record(t, force, position=x))
    slip = fit.models["Maxwell slip"]
    assert slip.holdout_rms < 0.02 < 0.2 * fit.models["LuGre"].holdout_rms
    assert slip.friction.coulomb == pytest.approx(2.0, rel=0.01)
    assert slip.friction.stiffness.sum() == pytest.approx(2.4e5, rel=0.1)


def test_what_the_speeds_cannot_tell_is_fixed_and_said():
    x = np.concatenate([np.concatenate([np.linspace(0, 2e-4, 100), np.linspace(2e-4, 0, 100)])] * 10)
    force = friction_along(
        TwoSidedLuGre(1e5, 0.0, Sliding(3.0, 4.0, 1e-3, 10.0), Sliding(3.0, 4.0, 1e-3, 10.0)), x, 0.01
    )
    fit = identify_friction_force(force_record(0.01 * np.arange(len(x)), force, position=x))
    for side in ("forward", "backward"):
        for name in ("viscous", "static", "stribeck_speed"):
            p = fit.chosen.parameters[f"friction.{side}.{name}"]
            assert p.how == "fixed" and not p.identifiable and p.note
        assert fit.chosen.parameters[f"friction.{side}.coulomb"].identifiable
    assert fit.chosen.parameters["friction.forward.viscous"].value == 0.0
    assert any("strokes at other speeds" in a for a in fit.advice)


def test_a_force_of_the_other_sign_is_turned_and_said_to_be(made):
    r = made.record
    turned = force_record(r.time, -r.force, position=r.position)
    assert turned.turned and np.array_equal(turned.force, r.force)
    assert [f.kind for f in turned.findings] == ["sign"]
    kept = force_record(r.time, -r.force, position=r.position, sign=1)
    assert not kept.turned and np.array_equal(kept.force, -r.force)


@pytest.mark.slow
def test_friction_in_proportion_to_the_normal_force_is_found_as_a_coefficient():
    t, x, force = log(noise=0.0)
    normal = np.linspace(2.0, 6.0, len(t))
    record = force_record(t, normal * force + 0.01 * np.sin(37.0 * t), position=x, normal=normal)
    fit = identify_friction_force(record)
    assert fit.load == "coefficient" and fit.chosen.parameters["friction.stiffness"].unit == "1/m"
    assert fit.chosen.parameters["friction.forward.coulomb"].value == pytest.approx(3.0, rel=0.01)
    assert fit.others["LuGre"].holdout_rms > 20.0 * fit.chosen.holdout_rms
    f = lugre_of(fit, normal=2.0)
    assert f.stiffness == pytest.approx(2.0 * fit.chosen.friction.stiffness)
    assert f.forward.stribeck_speed == fit.chosen.friction.forward.stribeck_speed
    with pytest.raises(ValueRefused, match="normal = 0"):
        lugre_of(fit, normal=0.0)


def test_a_plant_takes_the_friction_that_was_found(made):
    values = {key.removeprefix("plant."): v for key, v in settings(made).items()}
    assert servo_axis_lugre(**values).params.friction == made.chosen.friction
    assert map_of(made).forward == made.chosen.friction.forward


def test_the_arrays_given_are_not_changed():
    t, x, force = log()
    copies = [a.copy() for a in (t, x, force)]
    force_record(t, -force, position=x)
    for before, after in zip(copies, (t, x, force), strict=True):
        assert np.array_equal(before, after)


def test_velocity_alone_gives_the_path():
    t = np.linspace(0.0, 2.0, 2001)
    v = 1e-3 * np.sin(2.0 * np.pi * t)
    record = force_record(t, v, velocity=v)
    assert record.position == pytest.approx(1e-3 / (2.0 * np.pi) * (1.0 - np.cos(2.0 * np.pi * t)), abs=2e-9)


def test_two_counts_of_flicker_are_no_reversal():
    x = np.array([0.0, 2.0, 4.0, 3.0, 2.0, 4.0, 5.0, 4.0, 3.0, 2.0, 3.0, 1.0])
    assert without_flicker(x, 1.0).tolist() == [0.0, 0.0, 4.0, 4.0, 4.0, 4.0, 5.0, 5.0, 5.0, 2.0, 2.0, 1.0]
    counts = np.round(np.cumsum(np.random.default_rng(3).standard_normal(1000)))
    assert encoder_step(5e-8 * counts) == pytest.approx(5e-8)
    assert encoder_step(np.cumsum(np.random.default_rng(3).standard_normal(1000))) == 0.0


def broken(what):
    t, x, force = log(repeats=1)
    if what == "two rows":
        return (t[:2], force[:2], x[:2]), "2 samples; expected at least"
    if what == "constant":
        return (t, force, np.zeros_like(x)), "the position is 0 in every sample"
    if what == "zeros":
        return (t, np.zeros_like(force), x), "the force is 0 in every sample"
    if what == "nan":
        force[17] = np.nan
        return (t, force, x), "force, sample 18: nan is not a finite number"
    if what == "clock":
        t[5] = t[4]
        return (t, force, x), "sample 6 has the time .* of the one before"
    if what == "one way":
        return (t, 1.0 + 0.01 * force, np.cumsum(np.full(len(t), 1e-6))), "moves one way only"
    if what == "a spring":
        return (t, 1e4 * (x - x.mean()), x), "does no work on the motion"
    return (t, force[:-1], x), "samples of force, .* of time"


@pytest.mark.parametrize("what", ["two rows", "constant", "zeros", "nan", "clock", "one way", "a spring", "length"])
def test_a_log_that_tells_nothing_is_refused_with_one_sentence(what):
    (t, force, x), sentence = broken(what)
    with pytest.raises(DataError, match=sentence) as problem:
        force_record(t, force, position=x)
    assert "\n" not in str(problem.value)


def test_a_jump_of_the_encoder_is_flagged_and_an_honest_log_is_not(made):
    assert made.record.findings == []
    x = made.record.position.copy()
    x[1500:] += 4e-5
    found = force_record(made.record.time, made.record.force, position=x).findings
    assert [f.kind for f in found] == ["jump"] and "4e-05 m at sample 1501" in found[0].sentence


def test_a_normal_force_that_is_no_load_is_refused_or_turned(made):
    r = made.record
    with pytest.raises(DataError, match="normal force is 0 in every sample"):
        force_record(r.time, r.force, position=r.position, normal=np.zeros(len(r.time)))
    turned = force_record(r.time, r.force, position=r.position, normal=np.full(len(r.time), -5.0))
    assert turned.normal is not None and turned.normal.min() == 5.0
    assert [f.kind for f in turned.findings] == ["normal"]


@pytest.mark.slow
def test_a_normal_force_in_the_wrong_unit_is_said_to_be_odd(made):
    r = made.record
    fit = identify_friction_force(force_record(r.time, r.force, position=r.position, normal=np.full(len(r.time), 0.01)))
    assert any("look at the units" in note for note in fit.notes)


def test_options_out_of_range_are_refused(made):
    with pytest.raises(ValueRefused, match=r"holdout = 0\.9: allowed range"):
        identify_friction_force(made.record, holdout=0.9)
    with pytest.raises(ValueRefused, match="no normal force"):
        identify_friction_force(made.record, load="coefficient")
    with pytest.raises(ValueRefused, match="position = None, velocity = None"):
        force_record(made.record.time, made.record.force)
    with pytest.raises(DataError, match="move one way only; choose a smaller hold-out"):
        x = np.concatenate([np.linspace(0, 1e-3, 400), np.linspace(1e-3, 0, 300)])
        force = np.sign(np.diff(x, prepend=-1.0)) + 0.01 * np.sin(np.arange(700.0))
        identify_friction_force(force_record(0.01 * np.arange(700), force, position=x), holdout=0.5)
