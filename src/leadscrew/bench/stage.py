"""Rows of the ball-screw stage: ways to step stiff friction through a hold of 250 us, speed and error side by side.

Ways to step the stage through a hold: the stage under a soft, sampled controller, for the benchmark of integrators.

Every 250 us the controller sees angle and speed exactly, and its torque is held:

    T = J y_r'' + F_C tanh(v_r / w) + s2^ v_r - K_d (e' + lambda e)        K_d = 1 N m s/rad, lambda = 150 1/s

with ``w = 10 mrad/s``, a smooth feed-forward of the believed friction. ``sharp_pd`` has the believed Stribeck term too
and w = 1 mrad/s: its torque leaps at a reversal and makes the stage slip, which is harder to step. Two schemes differ
by what they do inside the holds alone. Truth is RODAS at a relative tolerance of 1e-11, which SciPy's Radau confirms.
"""

from __future__ import annotations

import ctypes
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.bench import measuring
from leadscrew.bench.measuring import interleaved, load, repeated, row
from leadscrew.bench.yardstick import NoCompilerError, build
from leadscrew.friction.lugre import HAT, LuGre, level, steady_bristle
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._ballscrew_stage import (
    INERTIA,
    TRAVEL_MM_PER_RAD,
    BallscrewStageParams,
    BallscrewStageState,
    ballscrew_stage,
    stage_jacobian,
)
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


FIELDS = (
    "amplitude", "rate", "period", "substeps", "lam", "gain", "smooth", "ahead_coulomb", "ahead_viscous", "inertia",
    "stiffness", "damping", "viscous", "coulomb", "rise", "per_speed",
)  # fmt: skip
FORMS = {
    "euler": "explicit Euler",
    "rk4": "RK4",
    "split": "split, bristles exact at a frozen speed",
    "implicit": "backward Euler, Newton on the speed",
    "exponential": "exponential Rosenbrock-Euler",
}
"""The functions of ``stage.c`` and what they are."""


class Stage(ctypes.Structure):
    """Mirrors ``Stage`` of ``stage.c``."""

    _fields_ = tuple((name, ctypes.c_double) for name in FIELDS)


class State(ctypes.Structure):
    """Mirrors ``State`` of ``stage.c``."""

    _fields_ = tuple((name, ctypes.c_double) for name in ("angle", "speed", "bristle"))


class ByHand:
    """The C loops of one command."""

    def __init__(self, sine: str) -> None:
        self.library = build("stage.c")
        self.sine = sine
        pointer = ctypes.POINTER(ctypes.c_double)
        for name in FORMS:
            entry = getattr(self.library, f"stage_{name}")
            entry.argtypes, entry.restype = [ctypes.POINTER(Stage), ctypes.POINTER(State), pointer, ctypes.c_long], None

    def run(self, form: str, microseconds: float, holds: int) -> np.ndarray:
        """The angle at the start of each hold, rad."""
        amplitude, rate, _ = SINES[self.sine]
        amplitude /= TRAVEL_MM_PER_RAD
        f, c = LuGre(), SoftParams()
        stage = Stage(
            amplitude, rate, PERIOD_S, round(1e6 * PERIOD_S / microseconds), c.lam, c.gain, c.smooth, c.hat.coulomb,
            c.hat.viscous, INERTIA, f.stiffness, f.damping, f.viscous, f.coulomb, f.static - f.coulomb,
            1.0 / f.stribeck_speed,
        )  # fmt: skip
        assert math.isclose(c.hat.static, c.hat.coulomb), "the C has no Stribeck term in its feed-forward"
        state = State(0.0, amplitude * rate, steady_bristle(f, amplitude * rate))
        angles = np.empty(holds)
        getattr(self.library, f"stage_{form}")(
            stage, state, angles.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), holds
        )
        return angles


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


NAMES = {"sine_wide": "stage, 5 sin t", "sine_fast": "stage, sin 2 pi t"}
SPANS = {"sine_wide": 8000, "sine_fast": 4000}
"""Holds that are timed: 2 s with one reversal, 1 s with two. Errors are over the whole run."""
ACCURATE_NM = 0.5
"""The error asked for."""
OURS = (rodas(1e-3), rodas(1e-4), rodas(1e-6), every("fixed", 50.0), every("fixed", 10.0), every("rk4", 1.0))
BEST = rodas(1e-4)
"""What the others are compared with."""
BY_HAND = (
    ("euler", 2.0), ("euler", 0.5), ("rk4", 2.0), ("rk4", 1.0), ("split", 1.0), ("implicit", 1.0),
    ("exponential", 25.0), ("exponential", 12.5),
)  # fmt: skip
HOLDS = 1060
"""Holds of sin 2 pi t past its first reversal, at 1000, for tools that take seconds for them."""
TARGETS: dict[str, float] = {rodas(1e-3).name: 500.0, rodas(1e-4).name: 500.0}
"""How many times faster than real time a scheme has to be."""


def speeds(sine: str, rounds: int, schemes: Sequence[Scheme] = OURS) -> tuple[dict[str, float], str]:
    """Processor nanoseconds a hold, by name, and why the C is missing where it is."""
    holds = SPANS[sine]
    times = {s.name: 10 if s.options.get("method") == "rodas" else 1 for s in schemes}
    calls: dict[str, Callable[[], object]] = {
        s.name: repeated(measuring.single(benchmark(sine, s), holds), times[s.name]) for s in schemes
    }
    why = ""
    try:
        c = ByHand(sine)
        calls |= {f"C {form} {us}": partial(c.run, form, us, holds) for form, us in BY_HAND}
    except NoCompilerError as error:
        why = str(error)
    return {k: v / holds / times.get(k, 1) * 1e9 for k, v in interleaved(calls, rounds).items()}, why


def real_time(ns: float) -> float:
    """How many times faster than real time."""
    return PERIOD_S / ns * 1e9


def our_rows(sine: str, ns: dict[str, float], truth: np.ndarray) -> list[dict[str, Any]]:
    """Each of our schemes: times real time and error."""
    rows = []
    for scheme in OURS:
        error, name = error_nm(sine, scheme, truth), NAMES[sine]
        substeps = scheme.options.get("substeps", 1)
        each = f"{ns[scheme.name] / substeps:.0f} ns a {'step' if substeps > 1 else 'hold'}"
        rows.append(
            row(name, f"ours, {scheme.name}", real_time(ns[scheme.name]), "x real time",
                at_least=TARGETS.get(scheme.name), integrator=scheme.name, error=1e-6 * error, remark=each)
        )  # fmt: skip
        if scheme.name in TARGETS:
            rows.append(
                row(name, f"error of {scheme.name}", error, "nm", at_most=ACCURATE_NM, integrator=scheme.name,
                    error=1e-6 * error)
            )  # fmt: skip
    ratio = ns[every("rk4", 1.0).name] / ns[BEST.name]
    rows.append(
        row(NAMES[sine], f"{BEST.name} against our RK4, 1 us", ns[BEST.name], "ns/hold", ratio=ratio, at_least=20.0,
            integrator=BEST.name, error=1e-6 * error_nm(sine, BEST, truth))
    )  # fmt: skip
    return rows


def c_rows(sine: str, ns: dict[str, float], truth: np.ndarray, why: str) -> list[dict[str, Any]]:
    """C by hand; the ratio is C over our RODAS."""
    if why:
        return [row(NAMES[sine], "C by hand", unit="x real time", remark=f"left out: {why}")]
    rows, c = [], ByHand(sine)
    for form, us in BY_HAND:
        each = ns[f"C {form} {us}"]
        error = float(NM * np.abs(c.run(form, us, len(truth)) - truth).max())
        what = f"{FORMS[form]}, {us:g} us"
        remark = f"{each * us / PERIOD_S / 1e6:.0f} ns a step; ratio: C over our {BEST.name}"
        rows.append(
            row(NAMES[sine], f"C by hand, {what}", real_time(each), "x real time", ratio=each / ns[BEST.name],
                integrator=what, error=1e-6 * error if math.isfinite(error) else None, remark=remark)
        )  # fmt: skip
    return rows


def scipy_rows(rounds: int, quick: bool) -> list[dict[str, Any]]:
    """SciPy up to a reversal of sin 2 pi t and past it; the ratio is to the fastest of ours that errs no more."""
    sine, holds = "sine_fast", HOLDS
    seconds = holds * PERIOD_S
    truth = angles(sine, TRUTH, seconds)
    schemes = (*OURS[:3], rodas(1e-8))
    calls = {s.name: repeated(measuring.single(benchmark(sine, s), holds), 20) for s in schemes}
    ns = {k: v / holds / 20 * 1e9 for k, v in interleaved(calls, rounds).items()}
    errors = {s.name: float(NM * np.abs(angles(sine, s, seconds) - truth).max()) for s in schemes}
    rows = []
    for method, tolerances in METHODS.items():
        for rtol in tolerances[:1] if quick else tolerances:
            done = scipy_run(sine, method, rtol, holds)
            each, error = done.seconds / holds * 1e9, float(NM * np.abs(done.angles - truth).max())
            ours = next((s.name for s in schemes if errors[s.name] <= error), None)
            against = f"against our {ours}, error {errors[ours]:.1e} nm" if ours else "none of ours errs as little"
            rows.append(
                row(f"SciPy {method}", f"{NAMES[sine]}, first {seconds:g} s, past a reversal", real_time(each),
                    "x real time", ratio=each / ns[ours] if ours else None,
                    at_least=100.0 if ours and method == "LSODA" else None,
                    integrator=f"{method}, rtol {rtol:.0e}, a call a hold", error=1e-6 * error, remark=against)
            )  # fmt: skip
    return rows


def batch_rows(quick: bool) -> list[dict[str, Any]]:
    """Many runs at once: friction steps a second, on one core and on all; 1e9 is asked for."""
    sine, cores, rows = "sine_fast", os.cpu_count() or 1, []
    varied = {"plant.inertia": np.linspace(2.12e-4, INERTIA, 256 if quick else 1024)}
    for scheme in (BEST, every("fixed", 50.0), every("rk4", 1.0)):
        loop, steps = benchmark(sine, scheme), scheme.options.get("substeps", 1)
        holds = 20 if steps > 100 else 800
        error = 1e-6 * error_nm(sine, scheme, angles(sine, TRUTH))
        done = steps * holds * len(varied["plant.inertia"])
        alone = interleaved({"": measuring.batch(loop, holds, varied)}, 3)[""]
        both = interleaved({"": measuring.batch(loop, holds, varied, threads=cores)}, 3, time.perf_counter)[""]
        what = "a hold counts as one step" if steps == 1 else f"{holds * PERIOD_S:g} s in steps of {scheme.name}"
        facts: dict[str, Any] = {"integrator": scheme.name, "error": error}
        rows.append(
            row("stage, batch", f"{scheme.name}, one core", done / alone, "steps/s",
                remark=f"{what}; {real_time(1e9 * alone / done * steps):,.0f} x real time", **facts)
        )  # fmt: skip
        rows.append(
            row("stage, batch", f"{scheme.name}, {cores} cores", done / both, "steps/s", at_least=1e9,
                remark=f"wall time, load {load() or 0.0:.2f}", **facts)
        )  # fmt: skip
    return rows


def rows(rounds: int, quick: bool = False) -> list[dict[str, Any]]:
    """All rows of this file."""
    made = []
    for sine in SMOOTH:
        ns, why = speeds(sine, min(rounds, 5))
        truth = angles(sine, TRUTH)
        made += our_rows(sine, ns, truth) + c_rows(sine, ns, truth, why)
    return made + scipy_rows(min(rounds, 5), quick) + batch_rows(quick)
