"""The XY table's axis with LuGre friction, against SciPy's Radau, formulas of steady friction, an energy balance."""

import math

import numpy as np
import pytest

from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table import xy_table
from leadscrew.plants._xy_table_lugre import LEVELS, xy_table_lugre
from leadscrew.references._sine import sine
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import ValueRefused

STEP = 25e-6


def driven(block, inputs, period=0.5e-3, substeps=20):
    """States after each period under voltages held for one period."""
    h = period / substeps
    p, s, seen = block.prepare(block.params, h), block.state, []
    for u in inputs:
        for _ in range(substeps):
            s = block.step(p, s, float(u), h)
        seen.append(s)
    return np.array(seen)


def by_radau(params, inputs, period=0.5e-3):
    """Position, velocity in mm, bristle in um, of the equations in the module's docstring."""
    from scipy.integrate import solve_ivp

    p, x, seen = params, np.zeros(3), []

    def rates(t, x, u):
        y, v, z = x
        level = p.presliding_um * (1.0 + (p.static_ratio - 1.0) * math.exp(-min((v / p.stribeck_mm_s) ** 2, 700.0)))
        friction = 1e-3 * p.friction_mv * z / p.presliding_um
        return [v, p.gain * (u - friction) - p.damping * v - p.stiffness * y, 1e3 * (v - abs(v) * z / level)]

    for u in inputs:
        found = solve_ivp(rates, (0.0, period), x, args=(u,), method="Radau", rtol=1e-9, atol=[1e-11, 1e-9, 1e-8])
        x = found.y[:, -1]
        seen.append(x)
    return np.array(seen)


@pytest.mark.slow
@pytest.mark.parametrize(("level", "volts"), [("low", 0.02), ("medium", 0.05), ("high", 0.3), ("high", 0.12)])
def test_at_25_us_the_axis_stays_within_two_nanometres_of_radau(level, volts):
    """The last case stays inside the bristles: 19 um there and back."""
    block = LEVELS[level]
    inputs = volts * np.sin(2.0 * np.pi * 5.0 * 0.5e-3 * np.arange(320))
    exact = by_radau(block.params, inputs)
    difference = [np.abs(driven(block, inputs, substeps=n) - exact)[:, 0].max() for n in (10, 20)]
    assert difference[1] < 2e-6 < np.ptp(exact[:, 0])
    assert difference[1] < 0.3 * difference[0]


def test_a_pull_inside_the_bristles_gives_their_stiffness_and_no_travel():
    """Below F_C the axis rests where spring of (1) and bristles carry the voltage together."""
    p = LEVELS["high"].params
    spring = p.stiffness / p.gain + p.friction_mv / p.presliding_um
    # A slow ramp to a small pull: 0.02 V of the 0.15 V that hold.
    inputs = 0.02 * np.minimum(np.arange(4000) / 2000.0, 1.0)
    at = driven(LEVELS["high"], inputs)[-1]
    assert at[0] == pytest.approx(0.02 / spring, rel=0.08)
    assert abs(at[1]) < 1e-6


@pytest.mark.parametrize("level", ["low", "medium", "high", "coulomb"])
def test_steady_sliding_costs_the_coulomb_voltage(level):
    """With the spring of (1) off the axis slides at gain (u - F_C) / damping."""
    block = LEVELS[level](stiffness=0.0)
    volts = 1e-3 * block.params.friction_mv + 0.1
    speed = driven(block, np.full(2000, volts))[-1, 1]
    assert speed == pytest.approx(0.1 * 69380.0 / 144.8, rel=1e-9)


def test_the_axis_breaks_away_at_the_static_friction():
    """Pulled very slowly it slips between F_C and F_S = 1.2 F_C, and never holds more."""
    block = LEVELS["high"](stiffness=0.0)
    volts = np.linspace(0.0, 0.2, 20000)
    moved = driven(block, volts)
    slipped = volts[np.flatnonzero(moved[:, 0] > 0.2)[0]]
    assert 0.150 < slipped < 0.182
    assert np.abs(moved[:, 2]).max() <= 1.2 * block.params.presliding_um


def test_friction_never_gives_energy_over_a_cycle():
    """What the voltage puts in over a cycle, damping and friction take out; friction takes at least F_C per travel."""
    block = LEVELS["medium"]
    n, h = 20000, STEP
    volts = 0.2 * np.sin(2.0 * np.pi * 2.0 * h * np.arange(2 * n))
    states = driven(block, volts, period=h, substeps=1)
    p = block.params
    y, v, z = states[-n - 1 :].T
    travel = np.diff(y)
    friction = 1e-3 * p.friction_mv * z[1:] / p.presliding_um
    middle = 0.5 * (v[1:] + v[:-1])
    put_in, rubbed = float(volts[-n:] @ travel), float(friction @ travel)
    damped = float(p.damping / p.gain * (middle @ travel))
    stored = 0.5 * (v[-1] ** 2 - v[0] ** 2 + p.stiffness * (y[-1] ** 2 - y[0] ** 2)) / p.gain
    assert put_in == pytest.approx(rubbed + damped + stored, rel=1e-5)
    assert 0.98 < rubbed / (1e-3 * p.friction_mv * np.abs(travel).sum()) < 1.02


def test_without_friction_it_is_equation_one():
    inputs = np.random.default_rng(3).normal(size=300)
    plain = xy_table.prepare(xy_table.params, 0.5e-3)
    s, seen = xy_table.state, []
    for u in inputs:
        s = xy_table.step(plain, s, float(u), 0.5e-3)
        seen.append(s)
    np.testing.assert_allclose(driven(xy_table_lugre(friction_mv=0.0), inputs)[:, :2], seen, rtol=1e-11, atol=1e-12)


def test_coulomb_friction_gives_the_square_waves_harmonics():
    """A square wave of F_C in phase with the velocity has 4 F_C / (n pi) at the odd orders n."""
    loop = Loop(
        reference=sine(amplitude=15.0, frequency=0.7), controller=table_pid, plant=LEVELS["coulomb"], period=0.5e-3,
        substeps=20, computation_delay=0.775e-3, metrics={},
    )  # fmt: skip
    run = loop.run(20.0, record="true_error")
    error, turn = 1e3 * run["true_error"][-20000:], 2.0 * np.pi * 0.7 * run.time[-20000:]
    for n in (3, 5, 7, 9, 11):
        s = 1j * 2.0 * np.pi * 0.7 * n
        z = np.exp(s * 0.5e-3)
        law = 1.32 + 0.000825 * 0.5e-3 * z / (z - 1.0) + 0.006805 / 0.5e-3 * (1.0 - 1.0 / z)
        axis = 69380.0 / (s * s + 144.8 * s + 166.3)
        late = np.exp(-s * (0.775e-3 + 0.25e-3))
        expected = 4.0 * 2.6 / (n * np.pi) * abs(axis / (1.0 + law * axis * late))
        found = 2.0 * abs(np.mean(error * np.exp(-1j * n * turn)))
        assert found == pytest.approx(expected, rel=2e-3)


def test_bristles_too_stiff_for_the_step_are_refused():
    loop = Loop(
        reference=sine(amplitude=1.0, frequency=0.7), controller=table_pid, plant=LEVELS["high"](presliding_um=1.0),
        period=0.5e-3, metrics={},
    )  # fmt: skip
    with pytest.raises(ValueRefused, match=r"presliding_um = 1 .* expected 2\.6 or more .* 500 us"):
        loop.run(0.1)
