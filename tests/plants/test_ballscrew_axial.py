"""The stage with an axial mode: frequencies worked by hand, SciPy's Radau, and the rigid stage as its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.plants._ballscrew_axial import BallscrewAxialParams, BallscrewAxialState, axial_jacobian, ballscrew_axial
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from tests.plants.test_ballscrew_stage import TIGHT, opened

LEAD = 1.5923e-3
J_S, J_T = 2.12e-4, 62.4 * LEAD**2
K = 1e8 * LEAD**2
FREE = {"friction.coulomb": 1e-9, "friction.static": 1e-9, "friction.viscous": 0.0, "friction.damping": 0.0}


def crossings(x):
    """Whole periods a second, by the first and the last upward crossing of 0 in a record of 1e-4 s."""
    up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    at = up - x[up] / (x[up + 1] - x[up])
    return (len(up) - 1) / ((at[-1] - at[0]) * 1e-4)


def ringing(plant, signal, **start):
    """What rings after a start off balance, without its mean."""
    loop = opened(period=1e-4, plant=plant.starting(**start))
    x = loop.run(0.1, record="plant")[signal]
    return x - x.mean()


@pytest.mark.slow
def test_free_and_held_screws_ring_at_the_frequencies_worked_by_hand():
    """sqrt(1e8 / 62.4) = 1266 1/s = 201.5 Hz; times sqrt(1 + 1.5821e-4 / 2.12e-4) = 1.3215 it is 266.3 Hz."""
    free = opened(period=1e-4, plant=ballscrew_axial(damping_ratio=0.0, **FREE).starting(table=1e-4)).run(
        0.1, record="plant"
    )
    assert crossings(free["plant.table"] - free["plant.angle"]) == pytest.approx(266.3, abs=0.1)
    held = ringing(ballscrew_axial(damping_ratio=0.0), "plant.table", table=1e-3)
    assert crossings(held) == pytest.approx(201.5, abs=0.5)  # bristles of 1e5 N m/rad hold the screw, and slow it


@pytest.mark.slow
def test_the_free_mode_dies_away_by_its_damping_ratio():
    run = opened(period=1e-4, plant=ballscrew_axial(damping_ratio=0.05, **FREE).starting(table=1e-4)).run(
        0.1, record="plant"
    )
    bend = run["plant.table"] - run["plant.angle"]
    w = 2.0 * math.pi * 266.27
    t = 1e-4 * np.arange(len(bend))
    z = 0.05 * w
    wd = w * math.sqrt(1.0 - 0.05**2)
    expected = 1e-4 * np.exp(-z * t) * (np.cos(wd * t) + z / wd * np.sin(wd * t))
    assert np.abs(bend - expected).max() < 1e-7


def equations(share):
    """The equations of the module's table, written out again."""

    def rates(_, x, u):
        angle, speed, table, table_speed, z, zt = x
        out = []
        for v, b in ((speed, z), (table_speed, zt)):
            g = (6.24 + 3.12 * math.exp(-min((v / 1e-3) ** 2, 700.0))) / 1e5
            dz = v - abs(v) * b / g
            out.append((dz, 1e5 * b + math.sqrt(1e5) * dz + 0.4 * v))
        damping = 2.0 * 0.03 * math.sqrt(K * J_S * J_T / (J_S + J_T))
        m = K * (angle - table) + damping * (speed - table_speed)
        r = 1.0 + 0.01 * math.sin(6.0 * angle) + 0.02 * math.sin(24.0 * angle)
        return [
            speed, (r * u - (1.0 - share) * out[0][1] - m) / J_S, table_speed, (m - share * out[1][1]) / J_T,
            out[0][0], out[1][0],
        ]  # fmt: skip

    return rates


RIPPLED = {"ripple_low.share": 0.01, "ripple_high.share": 0.02}


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.3])
def test_sliding_and_reversing_it_follows_radau(share):
    run = opened(amplitude=20.0, plant=ballscrew_axial(guide_share=share, **RIPPLED)).run(0.06, record="plant")
    x, rows = np.zeros(6), []
    for k in range(60):
        rows.append(x)
        u = 20.0 * math.sin(2.0 * math.pi * 2.5 * (k * 1e-3))
        x = solve_ivp(equations(share), (0.0, 1e-3), x, args=(u,), method="Radau", rtol=1e-9, atol=1e-14).y[:, -1]
    expected = np.array(rows)
    assert np.ptp(expected[:, 0]) > 0.005
    assert np.abs(run["plant.angle"] - expected[:, 0]).max() < 1e-10
    assert np.abs(run["plant.table"] - expected[:, 2]).max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_as_stiff_as_can_be_it_is_the_rigid_stage(share):
    rigid = opened(amplitude=20.0, plant=ballscrew_stage).run(0.1, record="actual")["actual"]
    stiff = ballscrew_axial(stiffness=1e13, damping_ratio=1.0, guide_share=share)
    bend = 9.36 / (1e13 * LEAD**2)  # what friction can bend a screw as stiff as that
    assert np.abs(opened(amplitude=20.0, plant=stiff).run(0.1, record="actual")["actual"] - rigid).max() < bend


def test_friction_at_the_guide_bends_the_screw():
    """5 N m against a table that is stuck: 5 / 253.5 rad, 31.4 um of the table's travel, before anything moves."""
    run = opened(ramp=1.0, plant=ballscrew_axial(guide_share=1.0)).run(5.0, record=("plant", "output"))
    bend = run["plant.angle"][-1] - run["plant.table"][-1]
    assert bend == pytest.approx(run["output"][-1] / 253.54, rel=1e-3)
    assert abs(run["plant.table"][-1]) < 0.01 * bend


def test_ripple_is_a_share_of_the_torque_by_the_angle():
    """A quarter of a period of 6 a turn, sin = 1, is a whole one of 24, sin = 0."""
    block = ballscrew_axial(**{"ripple_low.share": 0.01, "ripple_high.share": 0.5})
    p, at = block.prepare(block.params, 1e-3), math.pi / 12.0
    there = block.step(p, BallscrewAxialState(angle=at, table=at), 10.0, 0.0)
    assert there.speed * J_S == pytest.approx(10.1, rel=1e-12)


def test_it_shows_the_table_or_the_motor():
    table, motor = (
        opened(amplitude=20.0, plant=ballscrew_axial(travel_per_rad=1.5923, at_table=at)).run(
            0.02, record=("actual", "plant")
        )
        for at in (True, False)
    )
    assert np.array_equal(table["actual"], 1.5923 * table["plant.table"])
    assert np.array_equal(motor["actual"], 1.5923 * motor["plant.angle"])
    assert not np.array_equal(table["actual"], motor["actual"])


def test_the_jacobian_is_the_one_of_finite_differences():
    block = ballscrew_axial(guide_share=0.3, **RIPPLED)
    p = block.prepare(BallscrewAxialParams(guide_share=0.3), 1e-3)._replace(
        ripple_low=block.params.ripple_low, ripple_high=block.params.ripple_high
    )
    nudges = (1e-6, 1e-9, 1e-6, 1e-9, 1e-9, 1e-9)
    for state in ((0.1, 2e-3, 0.11, -3e-3, 4e-5, -2e-5), (2.0, -4e-4, 2.0, 3.0, 7e-5, 6e-5)):
        rows = np.array(axial_jacobian(p, BallscrewAxialState(*state), 7.0, 0.0, 0.0))
        for column, nudge in enumerate(nudges):
            up, down = (
                np.array(block.step(p, BallscrewAxialState(*shifted), 7.0, 0.0))
                for shifted in (
                    tuple(x + side * nudge * (i == column) for i, x in enumerate(state)) for side in (1.0, -1.0)
                )
            )
            scale = np.abs(rows).max(axis=1)
            assert (rows[:, column] - (up - down) / (2.0 * nudge)) / scale == pytest.approx(np.zeros(6), abs=1e-5)


@pytest.mark.sweep
@pytest.mark.parametrize("options", [TIGHT, {"method": "sdirk3", "substeps": 20}], ids=["rodas", "sdirk3"])
def test_all_engines_give_the_same_bits(options):
    loop = opened(amplitude=60.0, options=options, plant=ballscrew_axial(guide_share=0.2, **RIPPLED))
    fast, plain = (loop.run(0.015, record=("plant",), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


@pytest.mark.slow
def test_its_own_jacobian_and_finite_differences_give_the_same_motion():
    plants = ballscrew_axial, replace(ballscrew_axial, jacobian=None)
    by = [opened(amplitude=20.0, plant=p, options={"method": "rodas", "rtol": 1e-6, "atol": 1e-12}) for p in plants]
    a, b = (loop.run(0.1, record="actual")["actual"] for loop in by)
    assert np.abs(a - b).max() < 1e-8
