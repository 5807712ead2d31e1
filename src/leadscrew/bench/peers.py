"""Rows of slower ways to run the same loop: plain Python, our Python engine, SciPy, python-control, PathSim."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from math import floor
from typing import Any

import numpy as np

from leadscrew.bench import loops, measuring
from leadscrew.bench.loops import SUBSTEPS
from leadscrew.bench.measuring import interleaved, repeated, row
from leadscrew.bench.servo import INTEGRATORS, MOVING
from leadscrew.bench.yardstick import Lathe, Yardstick


class Controller:
    """Sensor and controller of the loop, for tools that bring their own plant."""

    def __init__(self, p: Lathe) -> None:
        self.p, self.centres, self.widths, self.rules = p, list(p.centres), list(p.reciprocal_widths), list(p.rules)
        self.e = self.started = 0.0

    def shape(self, x: float, y: float) -> float:
        """The output of the 36 rules."""
        c, w, t = self.centres, self.widths, self.rules
        x = c[0] if x < c[0] else c[5] if x > c[5] else x
        y = c[0] if y < c[0] else c[5] if y > c[5] else y
        i = (x >= c[1]) + (x >= c[2]) + (x >= c[3]) + (x >= c[4])
        j = (y >= c[1]) + (y >= c[2]) + (y >= c[3]) + (y >= c[4])
        mu, nu, k = (x - c[i]) * w[i], (y - c[j]) * w[j], 6 * i + j
        lower, upper = (1.0 - nu) * t[k] + nu * t[k + 1], (1.0 - nu) * t[k + 6] + nu * t[k + 7]
        return (1.0 - mu) * lower + mu * upper

    def duty(self, reading: float) -> float:
        """The duty for a reading of the grating."""
        p = self.p
        e = (p.target - p.resolution * floor(reading / p.resolution + 0.5)) / p.error_scale
        ec = self.started * ((e - self.e) * p.error_scale * (p.rate_interval / p.period)) / p.rate_scale
        alpha_e = abs(e) ** p.tau + p.floor if self.started else 1.0
        alpha_ec = abs(ec) ** p.tau + p.floor if self.started else 1.0
        beta = p.output_gain * (abs(e) ** p.output_tau + p.floor if self.started else 1.0)
        self.e, self.started = e, 1.0
        return min(1.0, max(-1.0, beta * self.shape(e / alpha_e, ec / alpha_ec)))


def rates(p: Lathe, x: Any, duty: float) -> list[float]:
    """The chain's derivative, for integrators."""
    drive = -p.full_duty_speed * duty
    return [
        (drive - x[0]) / p.pwm_lag,
        (x[0] - x[1]) / p.electrical_lag,
        (x[1] - x[2]) / p.mechanical_lag,
        x[2],
        (x[3] - x[4]) / p.grating_lag,
    ]


def hold(p: Lathe, periods: int) -> list[float]:
    """The loop with the exact zero-order hold; positions at the start of each period."""
    control = Controller(p)
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13 = p.a
    b0, b1, b2, b3, b4 = p.b
    c0, c1, c2, c3, c4, c5 = control.centres
    centres, widths, t = control.centres, control.widths, control.rules
    target, resolution, error_scale, rate_scale = p.target, p.resolution, p.error_scale, p.rate_scale
    scale = p.error_scale * (p.rate_interval / p.period)
    tau, floor_, output_tau, gain, speed_, dt = p.tau, p.floor, p.output_tau, p.output_gain, p.full_duty_speed, p.period
    pwm = current = speed = position = reading = last = squares = absolutes = largest = 0.0
    started = False
    seen = []
    for _ in range(periods):
        seen.append(position)
        e = (target - resolution * floor(reading / resolution + 0.5)) / error_scale
        if started:
            ec = (e - last) * scale / rate_scale
            alpha_e, alpha_ec = abs(e) ** tau + floor_, abs(ec) ** tau + floor_
            beta = gain * (abs(e) ** output_tau + floor_)
        else:
            ec, alpha_e, alpha_ec, beta, started = 0.0, 1.0, 1.0, gain, True
        last = e
        x, y = e / alpha_e, ec / alpha_ec
        x = c0 if x < c0 else c5 if x > c5 else x
        y = c0 if y < c0 else c5 if y > c5 else y
        i = (x >= c1) + (x >= c2) + (x >= c3) + (x >= c4)
        j = (y >= c1) + (y >= c2) + (y >= c3) + (y >= c4)
        mu, nu, k = (x - centres[i]) * widths[i], (y - centres[j]) * widths[j], 6 * i + j
        lower, upper = (1.0 - nu) * t[k] + nu * t[k + 1], (1.0 - nu) * t[k + 6] + nu * t[k + 7]
        rho = beta * ((1.0 - mu) * lower + mu * upper)
        rho = 1.0 if rho > 1.0 else -1.0 if rho < -1.0 else rho
        error = target - position
        size = abs(error)
        squares += error * error * dt
        absolutes += size * dt
        largest = size if size > largest else largest
        drive = -speed_ * rho
        reading = a9 * pwm + a10 * current + a11 * speed + a12 * position + a13 * reading + b4 * drive
        position = a6 * pwm + a7 * current + a8 * speed + position + b3 * drive
        speed = a3 * pwm + a4 * current + a5 * speed + b2 * drive
        current = a1 * pwm + a2 * current + b1 * drive
        pwm = a0 * pwm + b0 * drive
    return seen


def rk4(p: Lathe, periods: int) -> list[float]:
    """The loop with RK4; positions at the start of each period."""
    control = Controller(p)
    duty_of = control.duty
    t_p, t_e, t_m, t_g, dt, target, full = (
        p.pwm_lag, p.electrical_lag, p.mechanical_lag, p.grating_lag, p.period, p.target, p.full_duty_speed,
    )  # fmt: skip
    h = dt / SUBSTEPS
    half, sixth = 0.5 * h, h / 6.0
    v = c = w = x = g = squares = absolutes = largest = 0.0
    seen = []
    for _ in range(periods):
        seen.append(x)
        drive = -full * duty_of(g)
        size = abs(target - x)
        squares += size * size * dt
        absolutes += size * dt
        largest = size if size > largest else largest
        for _ in range(SUBSTEPS):
            v1, c1, w1, x1, g1 = (drive - v) / t_p, (v - c) / t_e, (c - w) / t_m, w, (x - g) / t_g
            v2, c2, w2, x2, g2 = v + half * v1, c + half * c1, w + half * w1, x + half * x1, g + half * g1
            v2, c2, w2, x2, g2 = (drive - v2) / t_p, (v2 - c2) / t_e, (c2 - w2) / t_m, w2, (x2 - g2) / t_g
            v3, c3, w3, x3, g3 = v + half * v2, c + half * c2, w + half * w2, x + half * x2, g + half * g2
            v3, c3, w3, x3, g3 = (drive - v3) / t_p, (v3 - c3) / t_e, (c3 - w3) / t_m, w3, (x3 - g3) / t_g
            v4, c4, w4, x4, g4 = v + h * v3, c + h * c3, w + h * w3, x + h * x3, g + h * g3
            v4, c4, w4, x4, g4 = (drive - v4) / t_p, (v4 - c4) / t_e, (c4 - w4) / t_m, w4, (x4 - g4) / t_g
            v += sixth * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
            c += sixth * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
            w += sixth * (w1 + 2.0 * w2 + 2.0 * w3 + w4)
            x += sixth * (x1 + 2.0 * x2 + 2.0 * x3 + x4)
            g += sixth * (g1 + 2.0 * g2 + 2.0 * g3 + g4)
    return seen


def rk4_step(p: Lathe, x: list[float], duty: float, h: float) -> list[float]:
    """One RK4 step of the plant, for tools that only step."""
    k1 = rates(p, x, duty)
    k2 = rates(p, [s + 0.5 * h * k for s, k in zip(x, k1, strict=True)], duty)
    k3 = rates(p, [s + 0.5 * h * k for s, k in zip(x, k2, strict=True)], duty)
    k4 = rates(p, [s + h * k for s, k in zip(x, k3, strict=True)], duty)
    return [s + h / 6.0 * (a + 2.0 * b + 2.0 * c + d) for s, a, b, c, d in zip(x, k1, k2, k3, k4, strict=True)]


def solve_ivp(p: Lathe, periods: int, method: str, rtol: float, atol: float = 1e-12) -> np.ndarray:
    """SciPy, one call per control period; positions at the start of each period."""
    from scipy.integrate import solve_ivp as solve

    control, x, seen = Controller(p), np.zeros(5), []
    for _ in range(periods):
        seen.append(x[3])
        duty = control.duty(float(x[4]))
        span, options = (0.0, p.period), {"method": method, "rtol": rtol, "atol": atol}
        x = solve(lambda t, s, u=duty: rates(p, s, u), span, x, **options).y[:, -1]
    return np.array(seen)


def interconnected(p: Lathe, h: float, move: Callable[[list[float], float], list[float]]) -> Any:
    """The closed loop as python-control has it: plant and controller, discrete with step ``h``, interconnected."""
    import control

    law, every = Controller(p), round(p.period / h)

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

    law, h = Controller(p), p.period / substeps

    def moved(t, x, u, params):
        law.e, law.started = float(x[5]), float(x[6])
        duty, axis = law.duty(float(x[4])), x[:5].tolist()
        if substeps == 1:
            axis = held(p, axis, duty)
        else:
            for _ in range(substeps):
                axis = rk4_step(p, axis, duty, h)
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
    step = (lambda x, duty: held(p, x, duty)) if substeps == 1 else (lambda x, duty: rk4_step(p, x, duty, h))
    time = np.arange(periods * substeps) * h
    found = control.input_output_response(interconnected(p, h, step), time, 0.0, np.zeros(8))
    return np.asarray(found.outputs).ravel()[::substeps]


def pathsim(p: Lathe, periods: int) -> np.ndarray:
    """PathSim with a sampled controller and RK4 at a tenth of the period."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import ODE, Scope, Wrapper
    from pathsim.solvers import RK4

    law = Controller(p)
    axis = ODE(lambda x, u, t: np.array(rates(p, x, float(u[0]))), np.zeros(5))
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


TIGHT = "DOP853, rtol 1e-12, per control period"
LIMITS = {"python-control, hold": 1000.0, "python-control, RK4": 1000.0}
"""How many times faster than a peer ours has to be."""
PLAIN = {
    "hold": "no target: the 30 x was measured on RK4; one exact step leaves little to do but pow, C in CPython",
    "rk4": "the form that the target was measured on",
}


def positions(loop: Any, periods: int) -> np.ndarray:
    """Positions of our loop at the start of each period."""
    found: np.ndarray = loop.run(periods * loop.period, record="actual.position")["actual.position"]
    return found


BY_HAND = {"hold": hold, "rk4": rk4}
"""The loop in plain Python, by the form of its plant."""


def accuracy(periods: int) -> tuple[np.ndarray, dict[str, float]]:
    """The tight reference and the largest distance of our two forms from it, in mm."""
    p = Yardstick.parameters(loops.lathe())
    reference = solve_ivp(p, periods, "DOP853", 1e-12)
    return reference, {f: float(np.abs(positions(loops.lathe(f), periods) - reference).max()) for f in INTEGRATORS}


def rows(reference: np.ndarray, errors: dict[str, float], rounds: int) -> list[dict[str, Any]]:
    """All rows of this file; the ratio is theirs over ours with the same integrator, or one at least as accurate."""
    loop = loops.lathe()
    p = Yardstick.parameters(loop)
    slow = loop.start(engine="python")
    begin = slow.save()

    def on_python() -> None:
        slow.restore(begin)
        slow.advance(MOVING, every=0)

    contenders: dict[str, Callable[[], object]] = {"engine": on_python}
    for form in INTEGRATORS:
        call, by_hand = measuring.single(loops.lathe(form), MOVING), BY_HAND[form]
        contenders[form] = repeated(call, 20)
        contenders[f"plain {form}"] = partial(by_hand, p, MOVING)
    seen = interleaved(contenders, rounds)
    ours = {f: seen[f] / MOVING / 20 for f in INTEGRATORS}
    made = []
    for form, integrator in INTEGRATORS.items():
        each = seen[f"plain {form}"] / MOVING
        error = float(np.abs(np.array(BY_HAND[form](p, len(reference))) - reference).max())
        made.append(row(f"plain Python, {form}", "local floats, by hand", each * 1e9, ratio=each / ours[form],
                        at_least=30.0 if form == "rk4" else None, integrator=integrator, error=error,
                        remark=PLAIN[form]))  # fmt: skip
    each = seen["engine"] / MOVING
    made.append(row("our Python engine, hold", "first 0.8 s, moving", each * 1e9, ratio=each / ours["hold"],
                    integrator=INTEGRATORS["hold"], error=errors["hold"]))  # fmt: skip
    for name, (package, integrator, run) in PEERS.items():
        if missing(package):
            made.append(row(name, "the same loop", integrator=integrator, remark="not installed"))
            continue
        run(p, 3)
        began = time.process_time()
        found = run(p, len(reference))
        each = (time.process_time() - began) / len(reference)
        error = float(np.abs(found - reference[: len(found)]).max())
        form = "rk4" if errors["rk4"] <= 1.01 * error else "hold"
        note = NOTES.get(name, "")
        made.append(row(name, f"the same loop, first {len(reference)} periods", each * 1e9, ratio=each / ours[form],
                        at_least=LIMITS.get(name), integrator=integrator, error=error,
                        remark=f"against our {INTEGRATORS[form]}, error {errors[form]:.1e} mm{note}"))  # fmt: skip
    return made
