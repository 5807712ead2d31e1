"""The study's benchmark of integrators: its truth against SciPy, its claims, its picture."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.studies.fsmc_ballscrew.figures_integrators import (
    MARKS,
    Point,
    integrator_pictures,
    work_precision_figure,
)
from leadscrew.studies.fsmc_ballscrew.integrators import NM, PERIOD_S, TRUTH, benchmark
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from tests.studies.whole import claims_of


@pytest.fixture(scope="module")
def loops():
    return Loops()


def rates(_, x, u):
    """Equations (1) to (5) of the paper, written out again."""
    v, z = x[1], x[2]
    g = (6.24 + 3.12 * math.exp(-min((v / 1e-3) ** 2, 700.0))) / 1e5
    rate = v - abs(v) * z / g
    return [v, (u - 1e5 * z - math.sqrt(1e5) * rate - 0.4 * v) / (2.12e-4 + 62.4 * 1.5923e-3**2), rate]


@pytest.mark.slow
def test_the_truth_is_what_radau_finds_around_a_reversal():
    """60 holds of sin 2 pi t, hold 1000 in the middle, under the torques of our run; each solver on its own."""
    first, holds = 970, 60
    run = benchmark("sine_fast", TRUTH).run((first + holds) * PERIOD_S, record=("plant", "applied"))
    x = np.array([run[f"plant.{name}"][first] for name in ("angle", "speed", "bristle")])
    speeds, apart = [], 0.0
    for k in range(first, first + holds):
        apart = max(apart, NM * abs(x[0] - run["plant.angle"][k]))
        speeds.append(x[1])
        u = float(run["applied"][k])
        x = solve_ivp(rates, (0.0, PERIOD_S), x, args=(u,), method="Radau", rtol=1e-11, atol=1e-15).y[:, -1]
    assert min(speeds) < 0.0 < max(speeds)
    assert apart < 1e-5


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_no_claim_is_about_the_paper():
    claims = [c for name, c in claims_of("fsmc_ballscrew").items() if name.startswith("integrator_")]
    assert len(claims) >= 14
    assert {c.kind for c in claims} == {"required", "report"}
    assert {c.verdict for c in claims} == {"cannot be checked"}
    assert {c.unit for c in claims} == {"nm", "us"}
    assert all(c.paper is None for c in claims)


@pytest.mark.slow
def test_the_pictures_show_every_scheme(loops):
    (picture,) = integrator_pictures(loops)
    figure = picture.draw()
    assert [len(axes.lines) for axes in figure.axes] == [4, 4]
    points = [Point(group, 10.0 * (i + 1), 0.1, "x") for i, group in enumerate(MARKS)]
    drawn = work_precision_figure(points, "title")
    assert {line.get_label() for line in drawn.axes[0].lines if not line.get_label().startswith("_")} == set(MARKS)
