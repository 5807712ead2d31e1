"""What the models are known for: experiments of Canudas de Wit et al. (1995) against SciPy and independent numbers."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.analysis.friction import (
    break_away,
    break_away_after_rest,
    force_at_speed,
    friction_along,
    path_through,
    slip_times,
    stick_slip,
)
from leadscrew.friction.asymmetric import LuGreSlide
from leadscrew.friction.static_map import TwoSided
from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.plants._backlash_two_mass import backlash_two_mass
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.plants._mass_dahl import mass_dahl
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.plants._mass_maxwell_slip import mass_maxwell_slip
from leadscrew.plants._mass_stribeck import mass_stribeck
from leadscrew.references._motion import Motion
from leadscrew.references._ramp import ramp
from leadscrew.util.errors import ValueRefused

RATES = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)


def lugre(v, z):
    """The printed equations, written out again: rate of the bristle and friction of a unit mass, Table I."""
    dz = v - abs(v) * z * 1e5 / (1.0 + 0.5 * math.exp(-min((v / 1e-3) ** 2, 700.0)))
    return dz, 1e5 * z + math.sqrt(1e5) * dz + 0.4 * v


@pytest.mark.slow
def test_lugre_breaks_away_earlier_the_faster_the_force_rises():
    known = [1.4324, 1.3944, 1.3132, 1.2200, 1.0986, 1.0075]
    assert break_away(mass_lugre, RATES) == pytest.approx(known, abs=6e-5)


def test_static_friction_breaks_away_at_the_same_force_at_every_rate():
    assert break_away(mass_stribeck, RATES) == pytest.approx([1.5] * 6, abs=1e-6)


def test_maxwell_slip_breaks_away_near_static_friction_when_slow_and_earlier_when_fast():
    found = break_away(mass_maxwell_slip, RATES)
    assert 1.48 < found[0] <= 1.501 and list(np.diff(found)[1:] < -0.02) == [True] * 4


@pytest.mark.slow
def test_dahl_breaks_away_at_coulomb_friction():
    """Without the viscous part, which goes on rising while the mass runs away."""
    found = break_away(mass_dahl(**{"friction.viscous": 0.0}), (0.2, 5.0, 50.0))
    assert np.all(found < 1.0 + 1e-6) and np.all(found > 0.995)


@pytest.mark.parametrize("plant", [mass_lugre, mass_maxwell_slip, mass_stribeck], ids=lambda p: p.name)
def test_no_model_here_breaks_away_later_after_a_longer_rest(plant):
    """Real contacts do (F_S grows with the time at rest); plain LuGre lacks it, and the page says so."""
    found = break_away_after_rest(plant, (1.0, 3.0, 10.0))
    assert np.ptp(found) < 1e-6 and 1.2 < found[0] < 1.51


@pytest.mark.slow
@pytest.mark.parametrize(("w", "area"), [(1.0, 5.18e-6), (10.0, 4.79e-5), (25.0, 9.39e-5)])
def test_the_friction_speed_loop_widens_with_the_frequency_of_the_speed(w, area):
    t = np.linspace(0.0, 4.0 * math.pi / w, 200001)
    forces = friction_along(LuGreSlide(), 1e-3 * (1.5 * t + np.sin(w * t) / w), t[1])
    speeds = 1e-3 * (1.5 + np.cos(w * t))
    assert np.trapezoid(forces[100000:], speeds[100000:]) == pytest.approx(area, rel=2e-3)


@pytest.fixture(scope="module")
def pulled():
    return stick_slip(mass_lugre)


@pytest.mark.slow
def test_pulled_by_a_spring_the_mass_sticks_and_slips_as_in_scipy(pulled):
    def rates(t, x):
        dz, force = lugre(x[1], x[2])
        return [x[1], 2.0 * (0.1 * t - x[0]) - force, dz]

    def faster(t, x):
        return x[1] - 0.05

    faster.direction = 1.0
    there = solve_ivp(
        rates, (0.0, 15.0), [0.0] * 3, method="Radau", rtol=1e-9, atol=1e-13, events=faster, t_eval=[7.0, 9.0, 14.5]
    )
    assert slip_times(pulled, 0.05)[:2] == pytest.approx(there.t_events[0], abs=2e-5)
    assert pulled["actual"][[7000, 9000, 14500]] == pytest.approx(there.y[0], abs=2e-6)


def test_stick_slip_has_the_times_period_and_speed_of_an_independent_run(pulled):
    """The independent run's 7.537, 13.900, 20.262 s are samples, 12.5 ms apart, before the speed passes 0.05 m/s."""
    times = slip_times(pulled, 0.05)
    assert np.floor(times / 0.0125) * 0.0125 == pytest.approx([7.5375, 13.9, 20.2625])
    assert np.diff(times) == pytest.approx([6.36, 6.36], abs=0.005)
    assert pulled["plant.speed"].max() == pytest.approx(0.370, abs=5e-4)


@pytest.mark.slow
def test_every_model_with_a_stribeck_curve_sticks_and_slips_and_dahl_does_not():
    for plant in (mass_maxwell_slip, mass_stribeck):
        run = stick_slip(plant, seconds=16.0)
        assert len(slip_times(run, 0.05)) == 2
        standing = run.time < 7.0
        assert np.abs(run["actual"][standing]).max() < 1e-4
    run = stick_slip(mass_dahl)
    assert np.ptp(run["plant.speed"][20000:]) < 0.3 * np.ptp(run["plant.speed"][:10000])
    assert len(slip_times(run, 0.05)) <= 1 or run["plant.speed"][6000:].min() > 1e-3


def test_a_static_map_has_no_friction_before_sliding():
    with pytest.raises(ValueRefused, match="TwoSided has no friction before sliding"):
        friction_along(TwoSided(), [0.0, 1.0], 1e-3)


def test_numbers_and_plants_that_make_no_experiment_are_refused():
    for path in ([], [[0.0, 1.0]], [0.0, math.nan]):
        with pytest.raises(ValueRefused, match="one row of finite numbers"):
            friction_along(LuGreSlide(), path, 1e-3)
    with pytest.raises(ValueRefused, match=r"dt = 0.0: a positive finite number"):
        friction_along(LuGreSlide(), [0.0, 1.0], 0.0)
    with pytest.raises(ValueRefused, match=r"rate = -1.0"):
        break_away(mass_lugre, [1.0, -1.0])
    with pytest.raises(ValueRefused, match=r"rest = inf"):
        break_away_after_rest(mass_lugre, [math.inf])
    with pytest.raises(ValueRefused, match=r"seconds = 0"):
        stick_slip(mass_lugre, seconds=0)
    with pytest.raises(ValueRefused, match="backlash_two_mass is not one mass with a speed"):
        stick_slip(backlash_two_mass)
    with pytest.raises(ValueRefused, match="ballscrew_stage is not one mass with a speed"):
        break_away(ballscrew_stage, [1.0])
    with pytest.raises(ValueRefused, match=r"faster_than = 0.0"):
        force_at_speed(ballscrew_stage, [1.0], 0.0, 9.36)


@pytest.mark.slow
def test_the_stage_breaks_away_earlier_the_faster_its_torque_rises():
    known = [9.284, 9.239, 9.010, 8.809, 8.499, 7.832, 7.052]
    found = force_at_speed(ballscrew_stage, [0.05, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0], faster_than=0.02, highest=9.36)
    assert found == pytest.approx(known, abs=6e-4)
    (at_8_9,) = force_at_speed(ballscrew_stage, [8.9], faster_than=0.02, highest=9.36)
    assert at_8_9 < 0.95 * 9.36


def test_a_push_below_coulomb_friction_never_reaches_the_speed():
    assert np.isnan(force_at_speed(mass_stribeck, [1.0], 0.02, highest=0.9)).all()
    assert force_at_speed(mass_stribeck, [1.0], 1e-6, highest=1.6) == pytest.approx([1.5], abs=2e-3)


def test_a_path_meets_its_points():
    path = path_through([0.0, 1.0, -0.5], 0.3)
    assert path[[0, 3, 8]] == pytest.approx([0.0, 1.0, -0.5]) and len(path) == 9


def moving(p, s):
    """Position and speed, for a controller that takes both."""
    return Motion(s.position, s.speed, 0.0)


class PIDState(NamedTuple):
    """Integral of the error."""

    integral: float = 0.0


@controller(None, PIDState(), continuous=True)
def pid_of_1995(s, command, feedback):
    """Output -6 v - 3 e - 4 integral e, the numbers of the paper's hunting example."""
    error = feedback.position - command
    return PIDState(error), -6.0 * feedback.velocity - 3.0 * error - 4.0 * s.integral


@pytest.mark.slow
def test_integral_control_hunts_around_the_target():
    """0.9360 and 1.0650 m are the extremes between 34 and 50 s; the cycle is even, +-0.0639 m."""
    hunted = replace(mass_lugre, output=moving)
    loop = Loop(
        reference=ramp(initial=1.0, rate=0.0), controller=pid_of_1995, plant=hunted, period=None, sample=0.01,
        rtol=1e-8, atol=1e-12, metrics={},
    )  # fmt: skip
    run = loop.run(160.0, record=("actual.position",))
    early = run["actual.position"][(run.time > 34.0) & (run.time < 50.0)]
    assert early.min() == pytest.approx(0.9360, abs=6e-5) and early.max() == pytest.approx(1.0650, abs=6e-5)
    late = run["actual.position"][run.time > 100.0]
    assert late.max() - 1.0 == pytest.approx(1.0 - late.min(), abs=2e-5) and late.max() < 1.06395
