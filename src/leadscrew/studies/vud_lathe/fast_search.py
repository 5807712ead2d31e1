"""The search that found the fast controllers' settings: differential evolution over batches of runs.

A candidate is driven to -50 and -170 mm by every case of the training set, 1.1 s each. A run costs

    s = (t_2um - bound) + 0.1 (t_0.5um - bound) + 0.03 log2+(overshoot / 1 um) + 0.03 log2+(error / 0.25 um)
        + 0.02 log10+(chatter / 1e-9)

in seconds, with ``log+(x) = max(log x, 0)``, ``error`` and ``chatter`` those after 0.9 s, ``bound`` the single-lag
bound ``distance / K_v + 26.8 ms``, and 1.5 s where it never settles. A candidate costs the mean plus half the worst.
With sensor errors chatter is left out: it is the noise's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers._vud.fast import vud_fast
from leadscrew.kernel.metrics import chatter, overshoot, settling_time, steady_state_error
from leadscrew.references._step import step
from leadscrew.sensors.grating._ruler import grating_ruler

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop
    from leadscrew.studies.vud_lathe.scenarios import Machine

BOUNDS: dict[str, tuple[float, float, bool]] = {
    "error_full_scale_mm": (0.3, 50.0, True),
    "speed_full_scale_mm_s": (20.0, 800.0, True),
    "e_tau": (0.0, 1.2, False),
    "e_floor": (0.005, 1.0, True),
    "ec_tau": (0.0, 1.2, False),
    "ec_floor": (0.005, 2.0, True),
    "output_gain": (1.5, 10.0, True),
    "braking": (0.4, 1.0, False),
}
"""Lower and upper end of what is searched, and whether by its logarithm."""

LEARNED: dict[str, tuple[float, float, bool]] = {
    "chain.walk_mm": (5e-5, 3e-3, True),
    "chain.timing_s": (1e-6, 3e-3, True),
    "chain.forget": (0.003, 0.3, True),
}
"""The same for an observer that learns the gain."""

TARGETS_MM = (-50.0, -170.0)
TRAINING_SEED = 42
"""Of the 16 speeds at full duty, one in each sixteenth of 259 to 334 mm/s."""
SENSOR_ERRORS = {"interpolation_1_mm": 1.5e-4, "interpolation_2_mm": 0.8e-4, "noise_mm": 5e-5}
"""Amplitudes and standard deviation."""
SECONDS = 1.1
METRICS = {
    "t2": settling_time(percent=0.0, band=0.002),
    "t05": settling_time(percent=0.0, band=0.0005),
    "overshoot": overshoot,
    "error": steady_state_error(from_time=0.9),
    "chatter": chatter(from_time=0.9),
}


class Found(NamedTuple):
    """Result of a search."""

    settings: dict[str, float]
    cost: float
    candidates: int
    runs: int


def training_gains() -> np.ndarray:
    """Speeds at full duty of the training set."""
    share = (np.arange(16) + np.random.default_rng(TRAINING_SEED).uniform(size=16)) / 16.0
    return 259.0 + 75.0 * share


def search(machine: Machine, fixed: dict[str, float], robust: bool, seed: int, generations: int) -> Found:
    """The best settings that this seed and budget find; ``fixed`` are those that are not searched.

    With ``robust`` the training set holds 16 speeds at full duty, every second one again with sensor errors, and the
    observer's settings are searched too; without, the machine's own speed alone.
    """
    from scipy.optimize import differential_evolution

    space = {k: v for k, v in {**BOUNDS, **(LEARNED if robust else {})}.items() if k not in fixed}
    log = np.array([by_log for _, _, by_log in space.values()])[:, None]
    ends = [tuple(np.log((low, high)) if by_log else (low, high)) for low, high, by_log in space.values()]
    loop, cases = training_loop(machine), training_cases(machine, robust)
    counted = 0

    def values(x: np.ndarray) -> np.ndarray:
        return np.where(log, np.exp(np.where(log, x, 0.0)), x)

    def costs(x: np.ndarray) -> Any:
        nonlocal counted
        columns = values(x.reshape(len(space), -1))
        counted += columns.shape[1]
        found = cost(loop, cases, dict(zip(space, columns, strict=True)), fixed)
        return found if x.ndim > 1 else float(found[0])

    best = differential_evolution(
        costs,
        ends,
        popsize=10,
        maxiter=generations,
        seed=np.random.default_rng(seed),
        vectorized=True,
        updating="deferred",
        polish=False,
        tol=1e-9,
        mutation=(0.4, 0.9),
        recombination=0.8,
    )
    settings = dict(zip(space, values(best.x[:, None])[:, 0].tolist(), strict=True))
    return Found({**fixed, **settings}, float(best.fun), counted, counted * len(cases["reference.target"]))


def training_loop(machine: Machine) -> Loop:
    """The loop of the training runs."""
    from leadscrew.kernel.loop import Loop

    return Loop(
        reference=step(initial=0.0, target=-50.0, time=0.0),
        controller=vud_fast,
        plant=machine.plant,
        actuator=machine.actuator,
        sensor=grating_ruler,
        period=0.001,
        metrics=METRICS,
    )


def training_cases(machine: Machine, robust: bool) -> dict[str, np.ndarray]:
    """What each run of a candidate has for parameters; the runs with sensor errors last."""
    gains = training_gains() if robust else np.array([machine.plant.params.full_duty_speed_mm_s])
    wrong = gains[::2] if robust else gains[:0]
    each = np.repeat(np.concatenate([gains, wrong]), len(TARGETS_MM))
    erring = np.repeat(np.concatenate([np.zeros(len(gains)), np.ones(len(wrong))]), len(TARGETS_MM))
    return {
        "plant.full_duty_speed_mm_s": each,
        "reference.target": np.tile(TARGETS_MM, len(each) // len(TARGETS_MM)),
        "sensor.interpolation_phase": 0.4 * np.arange(len(each)) * erring,
        **{f"sensor.{name}": size * erring for name, size in SENSOR_ERRORS.items()},
    }


def cost(
    loop: Loop, cases: dict[str, np.ndarray], candidates: dict[str, np.ndarray], fixed: dict[str, float]
) -> np.ndarray:
    """What each candidate costs, by the module's formula."""
    many, each = len(next(iter(candidates.values()))), len(cases["reference.target"])
    varied = {f"controller.{name}": np.repeat(column, each) for name, column in candidates.items()}
    varied |= {f"controller.{name}": np.full(many * each, value) for name, value in fixed.items()}
    varied |= {key: np.tile(column, many) for key, column in cases.items()}
    found = {name: v.reshape(many, each) for name, v in loop.batch(SECONDS, varied).metrics.items()}
    bound = np.abs(cases["reference.target"]) / cases["plant.full_duty_speed_mm_s"] + 0.0268
    late = [np.nan_to_num(found[name], nan=1.5) - bound for name in ("t2", "t05")]
    over = np.log2(np.maximum(1000.0 * np.nan_to_num(found["overshoot"], nan=1e3), 1.0))
    off = np.log2(np.maximum(4000.0 * np.nan_to_num(found["error"], nan=1e3), 1.0))
    busy = np.log10(np.maximum(1e9 * np.nan_to_num(found["chatter"], nan=1.0), 1.0)) * (cases["sensor.noise_mm"] == 0.0)
    runs = late[0] + 0.1 * late[1] + 0.03 * (over + off) + 0.02 * busy
    return runs.mean(axis=1) + 0.5 * runs.max(axis=1)
