"""Ways to step the stage through a hold: the stage under a soft, sampled controller, for the benchmark of integrators.

Every 250 us the controller sees angle and speed exactly, and its torque is held:

    T = J y_r'' + F_C tanh(v_r / w) + s2^ v_r - K_d (e' + lambda e)        K_d = 1 N m s/rad, lambda = 150 1/s

with ``w = 10 mrad/s``, a smooth feed-forward of the believed friction. ``sharp_pd`` has the believed Stribeck term too
and w = 1 mrad/s: its torque leaps at a reversal and makes the stage slip, which is harder to step. Two schemes differ
by what they do inside the holds alone. Truth is RODAS at a relative tolerance of 1e-11, which SciPy's Radau confirms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.friction.lugre import HAT, LuGre, level, steady_bristle
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.sheet import Doc, Gt, Unit
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.plants._ballscrew_stage_fixed import ballscrew_stage_fixed
from leadscrew.references._sine import sine_motion

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PERIOD_S = 2.5e-4
NM = 1e6 * TRAVEL_MM_PER_RAD
"""Nanometres of the table per radian."""


class Sine(NamedTuple):
    """A command of the paper, and how long it runs here: past two reversals."""

    amplitude_mm: float
    rate: float
    seconds: float


SINES = {
    "sine_slow": Sine(0.01, 1.0, 6.3),
    "sine_wide": Sine(5.0, 1.0, 5.0),
    "sine_fast": Sine(1.0, 2.0 * math.pi, 1.0),
}
"""0.01 sin t, 5 sin t, sin 2 pi t mm."""
SMOOTH = ("sine_wide", "sine_fast")
"""The two on which the stage slides but for its reversals."""


class Seen(NamedTuple):
    """What the controller sees."""

    angle: float = 0.0
    speed: float = 0.0


def seen(p, s):
    """Angle and speed."""
    return Seen(s.angle, s.speed)


class SoftParams(NamedTuple):
    """A soft PD with a smooth friction feed-forward."""

    lam: Annotated[float, Unit("1/s"), Gt(0)] = 150.0
    gain: Annotated[float, Unit("N m s/rad"), Gt(0), Doc("K_d")] = 1.0
    inertia: Annotated[float, Unit("kg m^2"), Gt(0)] = INERTIA
    smooth: Annotated[float, Unit("rad/s"), Gt(0), Doc("speed over which the feed-forward changes sign")] = 0.01
    hat: LuGre = HAT._replace(static=HAT.coulomb)


@controller(SoftParams(), unit="N m", drive="torque")
def soft_pd(p, command, feedback):
    """The benchmark's controller: the module's equation."""
    v = command.velocity
    ahead = level(p.hat, v) * math.tanh(v / p.smooth) + p.hat.viscous * v
    error = feedback.speed - v + p.lam * (feedback.angle - command.position)
    return p.inertia * command.acceleration + ahead - p.gain * error


sharp_pd = soft_pd(smooth=1e-3, **{"hat.static": HAT.static})


@dataclass(frozen=True)
class Scheme:
    """A way of stepping the stage: the plant and the loop's options."""

    name: str
    plant: Block = ballscrew_stage
    options: dict[str, Any] = field(default_factory=dict)


def rodas(rtol: float) -> Scheme:
    """Adaptive RODAS4(3) inside each hold. One absolute tolerance serves angle, speed and bristles."""
    return Scheme(f"RODAS, rtol {rtol:.0e}".replace("e-0", "e-"), ballscrew_stage,
                  {"method": "rodas", "rtol": rtol, "atol": 1e-5 * rtol})  # fmt: skip


def every(method: str, microseconds: float) -> Scheme:
    """A method of fixed cost: ``rk4``, ``sdirk3`` or ``fixed``, which is the plant's own step."""
    name = {"rk4": "RK4", "sdirk3": "SDIRK3 of the kernel", "fixed": "SDIRK3, scalar"}[method]
    options: dict[str, Any] = {"substeps": round(1e6 * PERIOD_S / microseconds)}
    if method != "fixed":
        options["method"] = method
    plant = ballscrew_stage_fixed if method == "fixed" else ballscrew_stage
    return Scheme(f"{name}, {microseconds:g} us", plant, options)


TRUTH = rodas(1e-11)


def benchmark(sine: str, scheme: Scheme, law: Block = soft_pd) -> Loop:
    """The loop of a command and a scheme, starting in steady sliding on the command."""
    from leadscrew.kernel.loop import Loop

    amplitude, rate, _ = SINES[sine]
    speed = amplitude / TRAVEL_MM_PER_RAD * rate
    plant = replace(scheme.plant, output=seen) if law.step is soft_pd.step else scheme.plant
    plant = plant.starting(speed=speed, bristle=steady_bristle(LuGre(), speed))
    return Loop(
        reference=sine_motion(amplitude=amplitude / TRAVEL_MM_PER_RAD, frequency=rate / (2.0 * math.pi)),
        controller=law, plant=plant, period=PERIOD_S, metrics={}, name=scheme.name, **scheme.options,
    )  # fmt: skip


def angles(sine: str, scheme: Scheme, seconds: float | None = None, law: Block = soft_pd) -> Any:
    """The angle at the start of each hold, rad."""
    loop = benchmark(sine, scheme, law)
    return loop.run(SINES[sine].seconds if seconds is None else seconds, record="plant.angle")["plant.angle"]


def error_nm(sine: str, scheme: Scheme, truth: np.ndarray, law: Block = soft_pd) -> float:
    """The largest distance from the truth over the run, nm of the table; infinite where the scheme diverges."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = angles(sine, scheme, law=law)
    if len(found) < len(truth):
        return math.inf
    return float(NM * np.abs(found - truth).max())
