"""Integrators against SciPy, python-free closed forms and their own order."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew.kernel.block import controller, plant, reference
from leadscrew.kernel.loop import Loop
from tests.kernel import zoo


class StiffParams(NamedTuple):
    rate: float = 1e4


class StiffState(NamedTuple):
    y: float = 2.0
    z: float = 0.0


def van_der_pol_jacobian(p, s):
    """Rows of the Jacobian."""
    return ((0.0, 1.0), (-p.rate * (2.0 * s.y * s.z + 1.0), p.rate * (1.0 - s.y**2)))


@plant(StiffParams(), StiffState())
def van_der_pol(p, s, u):
    """Stiff van der Pol oscillator."""
    return StiffState(s.z, p.rate * ((1.0 - s.y * s.y) * s.z - s.y) + u)


@plant(StiffParams(), StiffState(), jacobian=van_der_pol_jacobian)
def van_der_pol_exact(p, s, u):
    """The same with its own Jacobian."""
    return StiffState(s.z, p.rate * ((1.0 - s.y * s.y) * s.z - s.y) + u)


@reference(None)
def nothing():
    """No command."""
    return 0.0


@controller(None)
def idle(command):
    """No output."""
    return command


def van_der_pol_by_scipy(t):
    mu = 1e4
    f = lambda _, x: [x[1], mu * ((1 - x[0] ** 2) * x[1] - x[0])]  # noqa: E731
    jac = lambda _, x: [[0, 1], [-mu * (2 * x[0] * x[1] + 1), mu * (1 - x[0] ** 2)]]  # noqa: E731
    return solve_ivp(f, (0, t), [2.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12, jac=jac).y[:, -1]


@pytest.mark.parametrize("block", [van_der_pol, van_der_pol_exact])
def test_rodas_follows_a_stiff_oscillator_like_radau(block):
    loop = Loop(
        reference=nothing, controller=idle, plant=block, period=0.01, method="rodas", rtol=1e-8, atol=1e-10, metrics={}
    )
    run = loop.run(0.61, record="plant")
    want = van_der_pol_by_scipy(0.60)
    assert abs(run["plant.y"][60] - want[0]) < 3e-6
    assert abs(run["plant.z"][60] - want[1]) < 3e-5


def test_sdirk3_is_stable_on_a_stiff_plant_at_large_steps():
    loop = Loop(reference=nothing, controller=idle, plant=van_der_pol, period=0.002, method="sdirk3", metrics={})
    run = loop.run(0.302, record="plant")
    assert abs(run["plant.y"][150] - van_der_pol_by_scipy(0.3)[0]) < 1e-4


def error_at_end(method, substeps):
    """Error of a driven, damped, time-dependent oscillator against a tight SciPy solution."""
    loop = Loop(
        reference=zoo.sine,
        controller=idle,
        plant=zoo.loaded_mass,
        period=0.1,
        substeps=substeps,
        method=method,
        metrics={},
    )
    run = loop.run(1.1, record=("plant", "applied"))
    x = np.zeros(2)
    for k in range(10):
        u = run["applied"][k]
        f = lambda t, x, u=u: [x[1], 100 * u - (10 + 0.1 * math.cos(t)) * x[1]]  # noqa: E731
        x = solve_ivp(f, (0.1 * k, 0.1 * (k + 1)), x, rtol=1e-12, atol=1e-14).y[:, -1]
    return abs(run["plant.position"][10] - x[0])


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("sdirk3", 3)])
def test_fixed_methods_have_their_order(method, order):
    coarse, fine = error_at_end(method, 4), error_at_end(method, 8)
    assert order - 0.5 < math.log2(coarse / fine) < order + 1.2


class LeadParams(NamedTuple):
    kp: float = 40.0
    lag: float = 0.01


class LeadState(NamedTuple):
    filtered: float = 0.0


@controller(LeadParams(), LeadState(), continuous=True)
def lag_controller(p, s, command, feedback):
    """A proportional controller behind a lag, as a derivative."""
    return LeadState((command - feedback - s.filtered) / p.lag), p.kp * s.filtered


@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_a_loop_without_period_is_one_continuous_system(engine):
    loop = Loop(
        reference=zoo.sine, controller=lag_controller, plant=zoo.mass(gain=10.0), period=None, sample=0.01, rtol=1e-9,
        atol=1e-11, metrics={}, engine=engine,
    )  # fmt: skip
    run = loop.run(1.0, record=("actual", "controller.filtered", "time"))

    def system(t, x):
        command = math.sin(2 * math.pi * 0.7 * t)
        return [(command - x[1] - x[0]) / 0.01, x[2], 10.0 * 40.0 * x[0] - 10.0 * x[2]]

    want = solve_ivp(system, (0, 1), [0, 0, 0], rtol=1e-11, atol=1e-13, t_eval=run.time, method="DOP853")
    assert np.abs(run["actual"] - want.y[1]).max() < 1e-7
    assert np.abs(run["controller.filtered"] - want.y[0]).max() < 1e-7
    with pytest.raises(ValueError, match="continuous loop"):
        loop.batch(1.0, {"controller.kp": [1.0, 2.0]})
