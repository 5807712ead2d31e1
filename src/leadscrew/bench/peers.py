"""The same loop in other tools: sensor and controller in plain Python, the plant theirs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import Any

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


def interconnected(p: Lathe, h: float, move: Callable[[list[float], float], list[float]]) -> Any:
    """The closed loop as python-control has it: plant and controller, discrete with step ``h``, interconnected."""
    import control

    law, every = plain.Controller(p), round(p.period / h)

    def duty(t, x, reading):
        if round(t / h) % every:
            return float(x[2])
        law.e, law.started = float(x[0]), float(x[1])
        return law.duty(float(reading))

    def remembered(t, x, u, params):
        held = duty(t, x, u[0])
        return np.array([law.e, 1.0, held])

    axis = control.NonlinearIOSystem(
        lambda t, x, u, params: np.array(move(x.tolist(), float(u[0]))), lambda t, x, u, params: x[3:5],
        inputs=["duty"], outputs=["position", "reading"], states=5, dt=h, name="axis",
    )  # fmt: skip
    vud = control.NonlinearIOSystem(
        remembered, lambda t, x, u, params: np.array([duty(t, x, u[0])]),
        inputs=["reading"], outputs=["duty"], states=3, dt=h, name="vud",
    )  # fmt: skip
    return control.interconnect([axis, vud], inputs=[], outputs=["position"], name="loop")


def held(p: Lathe, x: list[float], duty: float) -> list[float]:
    """The plant's exact step."""
    (v, c, w, s, g), a, b, drive = x, p.a, p.b, -p.full_duty_speed * duty
    return [
        a[0] * v + b[0] * drive,
        a[1] * v + a[2] * c + b[1] * drive,
        a[3] * v + a[4] * c + a[5] * w + b[2] * drive,
        a[6] * v + a[7] * c + a[8] * w + s + b[3] * drive,
        a[9] * v + a[10] * c + a[11] * w + a[12] * s + a[13] * g + b[4] * drive,
    ]


def hand_fused(p: Lathe, substeps: int) -> Any:
    """The closed loop as one system of python-control, written by hand: a step is a control period."""
    import control

    law, h = plain.Controller(p), p.period / substeps

    def moved(t, x, u, params):
        law.e, law.started = float(x[5]), float(x[6])
        duty, axis = law.duty(float(x[4])), x[:5].tolist()
        if substeps == 1:
            axis = held(p, axis, duty)
        else:
            for _ in range(substeps):
                axis = plain.rk4_step(p, axis, duty, h)
        return np.array([*axis, law.e, law.started])

    return control.NonlinearIOSystem(
        moved, lambda t, x, u, params: x[3:4], inputs=[], outputs=["position"], states=7, dt=p.period, name="loop"
    )


def python_control(p: Lathe, periods: int, substeps: int = 1, fused: bool = False) -> np.ndarray:
    """``input_output_response`` of python-control: the exact hold, or RK4 with ``substeps`` steps a period."""
    import control

    h = p.period / substeps
    if fused:
        found = control.input_output_response(hand_fused(p, substeps), np.arange(periods) * p.period, 0.0, np.zeros(7))
        return np.asarray(found.outputs).ravel()
    step = (lambda x, duty: held(p, x, duty)) if substeps == 1 else (lambda x, duty: plain.rk4_step(p, x, duty, h))
    time = np.arange(periods * substeps) * h
    found = control.input_output_response(interconnected(p, h, step), time, 0.0, np.zeros(8))
    return np.asarray(found.outputs).ravel()[::substeps]


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
    "python-control, hold": ("control", "interconnect, input_output_response, 1 kHz, exact hold", python_control),
    "python-control, RK4": (
        "control",
        "interconnect, input_output_response, 10 kHz, RK4",
        partial(python_control, substeps=SUBSTEPS),
    ),
    "python-control, hold, fused": (
        "control",
        "one system by hand, input_output_response, 1 kHz, exact hold",
        partial(python_control, fused=True),
    ),
    "python-control, RK4, fused": (
        "control",
        "one system by hand, input_output_response, 1 kHz, 10 RK4 steps inside",
        partial(python_control, substeps=SUBSTEPS, fused=True),
    ),
    "PathSim": ("pathsim", "RK4, 10 steps a period", pathsim),
}
FUSED = "; no target: controller and plant melted into one function by hand, which gives up blocks and their signals"
NOTES = {"python-control, hold, fused": FUSED, "python-control, RK4, fused": FUSED}
"""What a remark adds."""


def missing(package: str) -> bool:
    """Whether a package is not installed."""
    return find_spec(package) is None
