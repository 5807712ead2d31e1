"""The stage's loop around SciPy: controller in plain Python, one call of ``solve_ivp`` a hold."""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from leadscrew.bench.stage_schemes import PERIOD_S, SINES, SoftParams
from leadscrew.friction.lugre import LuGre, steady_bristle
from leadscrew.plants._ballscrew_stage import (
    INERTIA,
    TRAVEL_MM_PER_RAD,
    BallscrewStageParams,
    BallscrewStageState,
    stage_jacobian,
)

METHODS = {"LSODA": (1e-4, 1e-6), "Radau": (1e-4, 1e-6)}
"""Relative tolerances; the absolute one is 1e-5 of it."""


class Found(NamedTuple):
    """Angles at the start of each hold, and seconds of processor time."""

    angles: np.ndarray
    seconds: float


def torque(sine: str, t: float, angle: float, speed: float) -> float:
    """The soft controller."""
    amplitude, rate, _ = SINES[sine]
    amplitude /= TRAVEL_MM_PER_RAD
    c = SoftParams()
    y, v = amplitude * math.sin(rate * t), amplitude * rate * math.cos(rate * t)
    ahead = c.hat.coulomb * math.tanh(v / c.smooth) + c.hat.viscous * v
    return c.inertia * (-rate * rate * y) + ahead - c.gain * (speed - v + c.lam * (angle - y))


def rates(_: float, x: np.ndarray, u: float) -> list[float]:
    """Equations (1) to (5), in Python floats."""
    f = LuGre()
    _angle, v, z = x.tolist()
    g = (f.coulomb + (f.static - f.coulomb) * math.exp(-min((v / f.stribeck_speed) ** 2, 700.0))) / f.stiffness
    rate = v - abs(v) * z / g
    return [v, (u - f.stiffness * z - f.damping * rate - f.viscous * v) / INERTIA, rate]


def jacobian(_: float, x: np.ndarray, u: float) -> np.ndarray:
    """The stage's own."""
    return np.array(stage_jacobian(BallscrewStageParams(), BallscrewStageState(*x.tolist())))


def scipy_run(sine: str, method: str, rtol: float, holds: int) -> Found:
    """The loop from its start in steady sliding."""
    from scipy.integrate import solve_ivp

    amplitude, rate, _ = SINES[sine]
    speed = amplitude / TRAVEL_MM_PER_RAD * rate
    x, seen = np.array([0.0, speed, steady_bristle(LuGre(), speed)]), []
    options = {"method": method, "rtol": rtol, "atol": 1e-5 * rtol, "jac": jacobian}
    began = time.process_time()
    for k in range(holds):
        seen.append(x[0])
        u = torque(sine, k * PERIOD_S, float(x[0]), float(x[1]))
        x = solve_ivp(rates, (0.0, PERIOD_S), x, args=(u,), **options).y[:, -1]
    return Found(np.array(seen), time.process_time() - began)
