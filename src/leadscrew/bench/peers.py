"""The same loop in other tools: sensor and controller in plain Python, the plant theirs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec

import numpy as np

from leadscrew.bench import plain
from leadscrew.bench.loops import SUBSTEPS
from leadscrew.bench.yardstick import Lathe


def solve_ivp(p: Lathe, periods: int, method: str, rtol: float, atol: float = 1e-12) -> np.ndarray:
    """SciPy, one call per control period; positions at the start of each period."""
    from scipy.integrate import solve_ivp as solve

    control, x, seen = plain.Controller(p), np.zeros(5), []
    for _ in range(periods):
        seen.append(x[3])
        duty = control.duty(float(x[4]))
        span, options = (0.0, p.period), {"method": method, "rtol": rtol, "atol": atol}
        x = solve(lambda t, s, u=duty: plain.rates(p, s, u), span, x, **options).y[:, -1]
    return np.array(seen)


def python_control(p: Lathe, periods: int) -> np.ndarray:
    """python-control's ``input_output_response`` on the closed loop in discrete time with the exact hold."""
    import control

    a, b = np.zeros((5, 5)), np.array(list(p.b))
    values = iter(p.a)
    for i in range(5):
        for j in range(i + 1):
            a[i, j] = 1.0 if (i, j) == (3, 3) else next(values)
    law = plain.Controller(p)

    def update(t, x, u, params):
        law.e, law.started = float(x[5]), float(x[6])
        duty = law.duty(float(x[4]))
        return np.concatenate((a @ x[:5] - b * (p.full_duty_speed * duty), (law.e, 1.0)))

    ports = {"inputs": 1, "outputs": 1, "states": 7, "dt": p.period}
    system = control.NonlinearIOSystem(update, lambda t, x, u, params: x[3:4], **ports)
    time = np.arange(periods) * p.period
    return np.asarray(control.input_output_response(system, time, np.zeros(periods), np.zeros(7)).outputs).ravel()


def python_control_rk4(p: Lathe, periods: int) -> np.ndarray:
    """The same with RK4 at a tenth of the period, the controller at every tenth step."""
    import control

    law, h = plain.Controller(p), p.period / SUBSTEPS

    def update(t, x, u, params):
        law.e, law.started = float(x[5]), float(x[6])
        duty = float(x[7]) if round(t / h) % SUBSTEPS else law.duty(float(x[4]))
        return np.array([*plain.rk4_step(p, x[:5].tolist(), duty, h), law.e, 1.0, duty])

    system = control.NonlinearIOSystem(update, lambda t, x, u, params: x[3:4], inputs=1, outputs=1, states=8, dt=h)
    steps = periods * SUBSTEPS
    found = control.input_output_response(system, np.arange(steps) * h, np.zeros(steps), np.zeros(8)).outputs
    return np.asarray(found).ravel()[::SUBSTEPS]


def pathsim(p: Lathe, periods: int) -> np.ndarray:
    """PathSim with a sampled controller and RK4 at a tenth of the period."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import ODE, Scope, Wrapper
    from pathsim.solvers import RK4

    law = plain.Controller(p)
    axis = ODE(lambda x, u, t: np.array(plain.rates(p, x, float(u[0]))), np.zeros(5))
    held = Wrapper(lambda reading: law.duty(float(reading)), T=p.period)
    scope = Scope(sampling_period=p.period)
    links = [Connection(axis[4], held), Connection(held, axis), Connection(axis[3], scope)]
    simulation = Simulation([axis, held, scope], links, dt=p.period / SUBSTEPS, Solver=RK4, log=False)
    simulation.run(periods * p.period)
    return np.asarray(scope.read()[1])[0][:periods]


PEERS: dict[str, tuple[str, str, Callable[[Lathe, int], np.ndarray]]] = {
    "solve_ivp RK45": (
        "scipy",
        "RK45, rtol 1e-6, per control period",
        partial(solve_ivp, method="RK45", rtol=1e-6, atol=1e-9),
    ),
    "solve_ivp LSODA": (
        "scipy",
        "LSODA, rtol 1e-6, per control period",
        partial(solve_ivp, method="LSODA", rtol=1e-6, atol=1e-9),
    ),
    "python-control, hold": ("control", "input_output_response, discrete 1 kHz, exact hold", python_control),
    "python-control, RK4": ("control", "input_output_response, discrete 10 kHz, RK4", python_control_rk4),
    "PathSim": ("pathsim", "RK4, 10 steps a period", pathsim),
}


def missing(package: str) -> bool:
    """Whether a package is not installed."""
    return find_spec(package) is None
