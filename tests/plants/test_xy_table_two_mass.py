"""The XY table on two masses: against SciPy's discretisation, hand-worked modes, equation (1) as the rigid limit."""

import math

import numpy as np
import pytest
from scipy import signal

from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table import xy_table
from leadscrew.plants._xy_table_two_mass import XYTableTwoMassParams, matrices, xy_table_two_mass
from leadscrew.references._sine import sine
from leadscrew.studies.npid_xytable.tunings import TUNINGS

DT = 25e-6


def driven(block, volts, loads=None, dt=DT):
    p, s, seen = block.prepare(block.params, dt), block.state, []
    loads = np.zeros(len(volts)) if loads is None else loads
    for u, load in zip(volts, loads, strict=True):
        s = block.step(p, s, float(u), float(load), dt) if block.name != "xy_table" else block.step(p, s, float(u), dt)
        seen.append(s.position if block.name == "xy_table" else block.output(p, s))
    return np.array(seen)


@pytest.mark.parametrize("at_table", [True, False])
def test_it_gives_scipys_zero_order_hold_response(at_table):
    """By the four equations of the docstring, written down again."""
    s, w, zeta, m = 0.3, 2.0 * math.pi * 60.0, 0.05, 0.7
    k, c = s * m * w * w, 2.0 * zeta * s * m * w
    a = [[0, 1, 0, 0], [-(166.3 + k) / m, -(144.8 + c) / m, k / m, c / m], [0, 0, 0, 1], [k / s, c / s, -k / s, -c / s]]
    b = [[0, 0], [69380.0 / m, 0], [0, 0], [0, 69380.0 / s]]
    shown = [[0, 0, 1, 0]] if at_table else [[1, 0, 0, 0]]
    ad, bd, *_ = signal.cont2discrete((np.array(a), np.array(b), np.array(shown), np.zeros((1, 2))), 5e-4)
    rng, x, expected = np.random.default_rng(4), np.zeros(4), []
    inputs = 0.1 * rng.normal(size=(400, 2))
    for row in inputs:
        x = ad @ x + bd @ row
        expected.append((np.array(shown) @ x)[0])
    block = xy_table_two_mass(mode_hz=60.0, mode_damping=0.05, table_share=0.3, at_table=at_table)
    np.testing.assert_allclose(driven(block, *inputs.T, dt=5e-4), expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_as_the_mode_rises_it_becomes_equation_one(share):
    """The difference falls with the square of the frequency."""
    volts = 0.1 * np.sin(2.0 * np.pi * 3.0 * DT * np.arange(8000))
    rigid = driven(xy_table, volts)
    off = [
        np.abs(driven(xy_table_two_mass(mode_hz=hz, mode_damping=0.7, table_share=share), volts) - rigid).max()
        for hz in (500.0, 1000.0, 20000.0)
    ]
    assert off[1] < 0.3 * off[0] and off[2] < 1e-5 < np.ptp(rigid)


def test_the_modes_are_those_of_two_masses_on_a_spring():
    """Free: sqrt(k (1/m1 + 1/m2)); the motor's zero: the table on a held motor, mode_hz sqrt(1 - s)."""
    p = XYTableTwoMassParams(
        damping=0.0, stiffness=0.0, mode_hz=90.0, mode_damping=0.02, table_share=0.36, at_table=False
    )
    a, drive, _, motor = matrices(p)
    poles = np.linalg.eigvals(a)
    mode = poles[np.abs(poles.imag) > 1.0]
    assert np.abs(mode) / (2.0 * math.pi) == pytest.approx([90.0, 90.0], rel=1e-9)
    assert -mode.real / np.abs(mode) == pytest.approx([0.02, 0.02], rel=1e-9)
    zeros = np.roots(signal.ss2tf(a, drive[:, None], motor[None, :], [[0.0]])[0][0][2:])
    assert np.abs(zeros) / (2.0 * math.pi) == pytest.approx([72.0, 72.0], rel=1e-6)


@pytest.mark.slow
def test_a_constant_load_on_the_table_moves_both_sides_as_a_voltage_does():
    """At rest 10 mV of load is 10 mV of voltage, but for what the screw gives."""
    load = np.full(200_000, 0.01)
    table = driven(xy_table_two_mass(stiffness=1e4), np.zeros(load.size), load)[-1]
    motor = driven(xy_table_two_mass(stiffness=1e4, at_table=False), np.zeros(load.size), load)[-1]
    k = 0.25 * (2.0 * math.pi * 100.0) ** 2
    assert motor == pytest.approx(693.8 / 1e4, rel=1e-6) and table - motor == pytest.approx(693.8 / k, rel=1e-6)


@pytest.mark.filterwarnings("ignore::leadscrew.kernel.loop.DivergenceWarning")
@pytest.mark.parametrize(
    ("hz", "at_table", "stable"), [(100.0, False, True), (300.0, False, False), (100.0, True, False)]
)
def test_the_printed_gains_shake_on_a_mode_that_the_analysis_forbids(hz, at_table, stable):
    """The analysis of the study, another method: poles of the closed loop."""
    from leadscrew.studies.npid_xytable.two_mass import Axis, judged

    plant = xy_table_two_mass(mode_hz=hz, at_table=at_table)
    loop = Loop(
        reference=sine(amplitude=0.01, frequency=5.0), controller=TUNINGS["paper.pid"], plant=plant, period=0.5e-3,
        substeps=20, computation_delay=0.775e-3, metrics={}, bound=1.0,
    )  # fmt: skip
    run = loop.run(1.0)
    assert (run.diverged is None) == stable
    assert judged(TUNINGS["paper.pid"], Axis(plant.params)).stable is stable
