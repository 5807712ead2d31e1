"""Backlash against hysteresis worked by hand, closed forms of the impact, and SciPy."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.plants._backlash import (
    BacklashAxisParams,
    DeadBand,
    Play,
    backlash_axis,
    backlash_axis_hold,
    followed,
    reaction,
)
from leadscrew.plants._backlash_two_mass import backlash_two_mass, damping_ratio, restitution_of
from tests.tools import runnable

REDUCED = 83.6 * 62.4 / (83.6 + 62.4)
SMOOTH = {f"guide.{k}": v for k, v in (("coulomb", 1e-9), ("static", 1e-9), ("stiffness", 1e-3), ("damping", 0.0),
                                       ("viscous", 0.0))} | {"motor_viscous": 0.0}  # fmt: skip
"""Two bodies that nothing but the joint acts on."""


class PushParams(NamedTuple):
    """A sine that starts at 0, and a constant."""

    amplitude: float = 0.0
    frequency: float = 1.0
    constant: float = 0.0


@reference(PushParams())
def push(p, t):
    """The force of an open loop."""
    return p.amplitude * math.sin(2.0 * math.pi * p.frequency * t) + p.constant


@controller()
def through(command):
    """What is asked for."""
    return command


def walked(p, way, start=0.0):
    """The table's places along the places of the drive."""
    places = []
    for x in way:
        start = followed(p, start, x)
        places.append(start)
    return places


def test_the_table_stands_while_the_drive_crosses_the_play():
    assert walked(Play(1.0, 1.0), [1.0, 3.0, 2.0, 1.0, 0.0, -1.0, 0.0, 1.0, 2.0]) == [
        0.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0,
    ]  # fmt: skip


def test_gaps_and_slopes_may_differ_by_side():
    """Forwards (x - 1) / 2, backwards 2 (x + 4); the lines cross far away, at x = -17/3."""
    p = Play(forward_gap=1.0, backward_gap=4.0, forward_slope=0.5, backward_slope=2.0)
    assert walked(p, [1.0, 3.0, 2.0, 0.0, -3.0, -4.0, -5.0, -4.0, 5.0]) == [
        0.0,
        1.0,
        1.0,
        1.0,
        1.0,
        0.0,
        -2.0,
        -2.0,
        2.0,
    ]


def test_only_the_ends_of_a_way_matter_to_the_play_and_not_its_speed():
    p = Play(0.3, 0.7)
    fine = walked(p, np.concatenate([np.linspace(0, 2, 101), np.linspace(2, -1, 101), np.linspace(-1, 0.4, 101)]))
    coarse = walked(p, [2.0, -1.0, 0.4])
    assert fine[-1] == coarse[-1] == pytest.approx(0.1) and max(fine) == pytest.approx(1.7)


def test_the_reaction_is_a_dead_band_between_two_springs():
    p = DeadBand(1e-6, 3e-6, 1e8, 2e8)
    assert [reaction(p, x) for x in (-3e-6, 0.0, 1e-6)] == [0.0, 0.0, 0.0]
    assert reaction(p, 2e-6) == pytest.approx(100.0) and reaction(p, -4e-6) == pytest.approx(-200.0)


@pytest.mark.parametrize("viscous", [1.58e5, 200.0, 1e-3, 0.0])
def test_the_drive_of_the_axis_moves_by_the_exact_solution(viscous):
    hold = backlash_axis_hold(BacklashAxisParams(viscous=viscous), 2e-3)
    there = solve_ivp(
        lambda _, x: [x[1], (70.0 - viscous * x[1]) / 146.0], (0.0, 2e-3), [0.0, 0.3], rtol=1e-12, atol=1e-15,
        method="Radau",
    ).y[:, -1]  # fmt: skip
    assert hold.travel_from_speed * 0.3 + hold.travel_from_force * 70.0 == pytest.approx(there[0], rel=1e-9)
    assert hold.kept * 0.3 + hold.speed_from_force * 70.0 == pytest.approx(there[1], rel=1e-9)


def axis(**changes):
    return Loop(reference=push(amplitude=5000.0), controller=through, plant=backlash_axis(**changes), period=1e-3,
                metrics={})  # fmt: skip


def test_the_axis_shows_table_and_drive_and_their_distance_is_the_play():
    run = axis(**{"play.forward_gap": 2e-6, "play.backward_gap": 5e-6}).run(3.0, record=("actual",))
    lag = run["actual.motor"] - run["actual.position"]
    assert lag.max() == pytest.approx(2e-6, rel=1e-9) and lag.min() == pytest.approx(-5e-6, rel=1e-9)
    stands = np.abs(np.diff(run["actual.position"])) == 0.0
    inside = (lag[:-1] < 2e-6 * (1 - 1e-9)) & (lag[1:] < 2e-6 * (1 - 1e-9)) & (lag[:-1] > -5e-6 * (1 - 1e-9)) & (
        lag[1:] > -5e-6 * (1 - 1e-9))  # fmt: skip
    assert stands[inside].all() and inside.sum() > 10 and not stands.all()


def test_without_play_the_table_is_the_drive():
    run = axis(**{"play.forward_gap": 0.0, "play.backward_gap": 0.0}).run(1.0, record=("actual",))
    assert np.array_equal(run["actual.motor"], run["actual.position"])


def collided(restitution, speed=0.01, **changes):
    """The motor at this speed runs through half of the play into a table at rest, nothing else acts."""
    plant = backlash_two_mass(restitution=restitution, **SMOOTH, **changes).starting(motor_speed=speed)
    loop = Loop(reference=push, controller=through, plant=plant, period=None, sample=1e-5, rtol=1e-9, atol=1e-13,
                metrics={})  # fmt: skip
    return loop.run(0.0035, record=("plant",))


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.5, 0.2, 0.05])
def test_bodies_part_with_the_restitution_and_keep_their_momentum(restitution):
    run = collided(restitution)
    twist = run["plant.motor"] - run["plant.table"]
    touching = np.flatnonzero(twist > 1e-6)
    after = touching[-1] + 1
    meeting, parting = 0.01, run["plant.table_speed"] - run["plant.motor_speed"]
    assert parting[after] / meeting == pytest.approx(restitution, rel=1e-4)
    momentum = 83.6 * run["plant.motor_speed"] + 62.4 * run["plant.table_speed"]
    assert momentum == pytest.approx(83.6 * 0.01, rel=1e-7)
    energy = 0.5 * (83.6 * run["plant.motor_speed"] ** 2 + 62.4 * run["plant.table_speed"] ** 2)
    lost = energy[0] - energy[after]
    assert lost == pytest.approx(0.5 * REDUCED * 0.01**2 * (1.0 - restitution**2), rel=1e-3, abs=1e-8)


def test_an_elastic_impact_is_the_springs_half_oscillation():
    """Depth v sqrt(m / k) and duration pi sqrt(m / k) with the reduced mass; no energy is lost."""
    run = collided(1.0)
    twist = run["plant.motor"] - run["plant.table"]
    pressed, behind = np.maximum(twist - 1e-6, 0.0), np.maximum(-1e-6 - twist, 0.0)
    assert pressed.max() == pytest.approx(0.01 * math.sqrt(REDUCED / 1e8), rel=1e-4)
    assert np.count_nonzero(pressed) * 1e-5 == pytest.approx(math.pi * math.sqrt(REDUCED / 1e8), abs=2e-5)
    kinetic = 0.5 * (83.6 * run["plant.motor_speed"] ** 2 + 62.4 * run["plant.table_speed"] ** 2)
    assert kinetic + 0.5e8 * (pressed**2 + behind**2) == pytest.approx(0.5 * 83.6 * 0.01**2, rel=1e-6)


def test_each_flank_has_its_own_stiffness():
    run = collided(1.0, speed=-0.01, **{"joint.backward_stiffness": 4e8, "joint.backward_gap": 2e-6})
    twist = run["plant.motor"] - run["plant.table"]
    assert -2e-6 - twist.min() == pytest.approx(0.01 * math.sqrt(REDUCED / 4e8), rel=1e-4)


def test_the_restitution_of_a_flank_that_only_pushes():
    """Against SciPy's solution of one impact, ended where the force ends; the usual formula is for one that pulls."""
    for zeta in (0.0335, 0.3, 0.69, 1.0, 2.0):
        force = lambda _, x, z=zeta: x[0] + 2.0 * z * x[1]  # noqa: E731
        force.terminal, force.direction = True, -1.0
        way = solve_ivp(lambda _, x, z=zeta: [x[1], -x[0] - 2.0 * z * x[1]], (0.0, 50.0), [0.0, 1.0], events=force,
                        rtol=1e-10, atol=1e-13)  # fmt: skip
        assert restitution_of(zeta) == pytest.approx(-way.y[1, -1], rel=1e-6)
        assert damping_ratio(restitution_of(zeta)) == pytest.approx(zeta, rel=1e-9)
    assert damping_ratio(1.0) == 0.0
    usual = -math.log(0.05) / math.hypot(math.pi, math.log(0.05))
    assert restitution_of(usual) == pytest.approx(0.2139, abs=1e-3)


@pytest.mark.slow
def test_both_bodies_follow_scipy_through_gaps_impacts_and_reversals():
    damping = 2.0 * damping_ratio(0.6) * math.sqrt(1e8 * REDUCED)

    def rates(_, x, u):
        d, rate = x[0] - x[2], x[1] - x[3]
        force = max(1e8 * (d - 1e-6) + damping * rate, 0.0) if d > 1e-6 else 0.0
        force -= max(1e8 * (-1e-6 - d) - damping * rate, 0.0) if d < -1e-6 else 0.0
        dz = x[3] - abs(x[3]) * x[4] * 1e7 / 20.0
        rubbed = 1e7 * x[4] + 3e4 * dz + 50.0 * x[3]
        return [x[1], (u - 200.0 * x[1] - force) / 83.6, x[3], (force - rubbed) / 62.4, dz]

    plant = backlash_two_mass(restitution=0.6, **{"guide.stiffness": 1e7, "guide.damping": 3e4})
    loop = Loop(reference=push(amplitude=150.0, frequency=12.0), controller=through, plant=plant, period=1e-3,
                method="rodas", rtol=1e-8, atol=1e-13, metrics={})  # fmt: skip
    run = loop.run(0.12, record=("plant",))
    x, rows = np.zeros(5), []
    for k in range(120):
        rows.append(x)
        u = 150.0 * math.sin(2.0 * math.pi * 12.0 * (k * 1e-3))
        x = solve_ivp(rates, (0.0, 1e-3), x, args=(u,), method="Radau", rtol=1e-9, atol=1e-14, max_step=1e-4).y[:, -1]
    rows = np.array(rows)
    twist = rows[:, 0] - rows[:, 2]
    assert twist.max() > 1e-6 and twist.min() < -1e-6 and np.ptp(rows[:, 2]) > 2e-4
    assert np.abs(run["plant.motor"] - rows[:, 0]).max() < 2e-10
    assert np.abs(run["plant.table"] - rows[:, 2]).max() < 2e-10


def imposed(radius, rate, restitution):
    """Twist of a table behind a screw whose place is ``radius sin(rate t)``: a motor too heavy to be disturbed."""
    heavy = 1e12
    plant = backlash_two_mass(motor_mass=heavy, motor_viscous=0.0, restitution=restitution).starting(
        motor_speed=radius * rate, table_speed=radius * rate, motor=1.2e-6, bristle=2e-8
    )
    force = push(amplitude=-heavy * radius * rate**2, frequency=rate / (2.0 * math.pi))
    loop = Loop(reference=force, controller=through, plant=plant, period=None, sample=1e-4, rtol=1e-6, atol=1e-12,
                metrics={})  # fmt: skip
    run = loop.run(0.75 * math.pi / rate, record=("plant",))
    return run.time - 0.5 * math.pi / rate, run["plant.motor"] - run["plant.table"]


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "rate", "digest_ms"), [(5e-3, 1.0, 29.2), (1e-3, 2.0 * math.pi, 10.5)])
def test_after_a_reversal_the_screw_needs_the_time_of_its_parabola_to_cross_the_play(radius, rate, digest_ms):
    """sqrt(2 b / (R w^2)) for the 2 um of play: 28.3 and 10.1 ms; and a little more, for the flanks give way."""
    since, twist = imposed(radius, rate, 0.9)
    back = since[np.flatnonzero((twist < -1e-6) & (since > 0.0))[0]]
    pure = math.sqrt(2.0 * 2e-6 / (radius * rate**2))
    pressed = math.sqrt(2.0 * (2e-6 + 20.0 / 1e8) / (radius * rate**2))
    assert pure < back == pytest.approx(pressed, rel=0.015)
    assert 1e3 * back == pytest.approx(digest_ms, rel=0.025)


@pytest.mark.sweep
@pytest.mark.parametrize("plant", [backlash_axis, backlash_two_mass], ids=lambda p: p.name)
def test_all_engines_give_the_same_bits(plant):
    options = {} if "dt" in plant.signals else {"method": "sdirk3", "substeps": 20}
    shaken = push(amplitude=300.0, frequency=20.0)
    loop = Loop(reference=shaken, controller=through, plant=plant, period=1e-3, metrics={}, **options)
    plain = loop.run(0.04, record=("plant",), engine="python")
    assert np.ptp(next(iter(v for k, v in plain.signals.items() if k.endswith(".table")))) > 0.0
    for engine in ("llvm", runnable("c")):
        fast = loop.run(0.04, record=("plant",), engine=engine)
        assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
