"""The stage against tabulated solutions of SciPy's Radau at rtol 1e-10, and against known break-away torques."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import (
    BallscrewStageParams,
    BallscrewStageState,
    ballscrew_stage,
    stage_jacobian,
)

TIGHT = {"method": "rodas", "rtol": 1e-9, "atol": 1e-14}


class TorqueParams(NamedTuple):
    """A sine and a ramp."""

    amplitude: float = 0.0
    ramp: float = 0.0


@reference(TorqueParams())
def torque(p, t):
    """The torque of an open loop."""
    return p.amplitude * math.sin(2.0 * math.pi * 2.5 * t) + p.ramp * t


@controller()
def through(command):
    """What is asked for."""
    return command


def opened(period=1e-3, options=TIGHT, plant=ballscrew_stage, **changes):
    return Loop(reference=torque(**changes), controller=through, plant=plant, period=period, metrics={}, **options)


@lru_cache
def radau(amplitude, dt, periods):
    """The printed equations, written out again, under a sine of torque held over ``dt``."""
    j = 2.12e-4 + 62.4 * 1.5923e-3**2

    def rates(_, x, u):
        v, z = x[1], x[2]
        g = (6.24 + 3.12 * math.exp(-((v / 1e-3) ** 2))) / 1e5
        dz = v - abs(v) * z / g
        return [v, (u - 1e5 * z - math.sqrt(1e5) * dz - 0.4 * v) / j, dz]

    x, rows = np.zeros(3), []
    for k in range(periods):
        rows.append(x)
        u = amplitude * math.sin(2.0 * math.pi * 2.5 * (k * dt))
        x = solve_ivp(rates, (0.0, dt), x, args=(u,), method="Radau", rtol=1e-9, atol=1e-14).y[:, -1]
    return np.array(rows)


@pytest.mark.parametrize(
    ("options", "within_rad"),
    [
        pytest.param(TIGHT, 1e-11, marks=pytest.mark.slow, id="rodas"),
        pytest.param({"method": "sdirk3", "substeps": 100}, 2e-8, id="sdirk3"),
    ],
)
def test_sliding_and_reversing_it_follows_radau(options, within_rad):
    run = opened(amplitude=20.0, options=options).run(0.06, record="plant")
    expected = radau(20.0, 1e-3, 60)
    assert np.ptp(expected[:, 0]) > 0.005
    assert np.abs(run["plant.angle"] - expected[:, 0]).max() < within_rad


@pytest.mark.slow
def test_stuck_it_is_a_spring():
    """Below break-away the bristles carry the torque: 0.1 N m bends 1e5 N m/rad by 1 urad, and a little more."""
    run = opened(ramp=0.1).run(1.1, record=("plant", "output"))
    assert run["plant.angle"][-1] == pytest.approx(run["output"][-1] / 1e5, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("ramp", "breaks_at"), [(2.0, 8.499), (5.0, 7.832), (10.0, 7.052)])
def test_the_faster_the_torque_rises_the_earlier_it_breaks_away(ramp, breaks_at):
    run = opened(period=1e-4, ramp=ramp).run(10.0 / ramp, record=("plant.speed", "output"))
    first = np.argmax(run["plant.speed"] >= 0.02)
    assert run["output"][first] == pytest.approx(breaks_at, rel=0.0005)


def test_the_jacobian_is_the_one_of_finite_differences():
    p = BallscrewStageParams()
    for state in ((0.1, 2e-3, 4e-5), (0.0, -4e-4, 7e-5), (0.0, 3.0, 6e-5)):
        rows = np.array(stage_jacobian(p, BallscrewStageState(*state)))
        for column, nudge in enumerate((1e-6, 1e-7 * abs(state[1]) + 1e-12, 1e-9)):
            up, down = (
                np.array(ballscrew_stage.step(p, BallscrewStageState(*shifted), 1.0, 0.5))
                for shifted in (
                    tuple(x + side * nudge * (i == column) for i, x in enumerate(state)) for side in (1.0, -1.0)
                )
            )
            assert rows[:, column] == pytest.approx((up - down) / (2.0 * nudge), rel=1e-4, abs=1e-3)


def test_it_shows_the_table_in_mm_when_asked():
    run = opened(amplitude=11.0, plant=ballscrew_stage(travel_per_rad=1.5923)).run(0.05, record=("actual", "plant"))
    assert np.array_equal(run["actual"], 1.5923 * run["plant.angle"])


@pytest.mark.sweep
@pytest.mark.parametrize("options", [TIGHT, {"method": "sdirk3", "substeps": 20}], ids=["rodas", "sdirk3"])
def test_all_engines_give_the_same_bits(options):
    loop = opened(amplitude=60.0, options=options)
    fast, plain = (loop.run(0.015, record=("plant",), engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
