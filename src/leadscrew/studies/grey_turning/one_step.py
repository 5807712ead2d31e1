"""One-step predictions in the study: the digest's vectors, the load cell's filter alone, and errors on closed loops."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.grey.vectorised_others import predictions
from leadscrew.kernel.block import controller, plant, reference
from leadscrew.plants.turning import Turned
from leadscrew.sensors.load_cell import load_cell
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.readings import Reading, read
from leadscrew.studies.grey_turning.runs import Loops, filtered

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

VECTORS = Path(__file__).parent / "data" / "gm11_vectors.csv"
SAMPLES = ("y_km4", "y_km3", "y_km2", "y_km1", "y_k")
SET_POINT = 150.0
RUNS = 30
TRANSIENT_S, STEADY_S = 0.8, 1.0
"""Until when a prediction counts as transient, and from when as steady."""

MODELS: dict[str, dict[str, float]] = {
    "last": {}, "gm11": {}, "gm11_clamped": {"reference": SET_POINT}, "gm11_guarded": {},
    "gm11_shifted": {"shift": SET_POINT}, "line": {}, "two_point": {}, "gm11_exponential": {}, "dgm11": {},
    "gm11_residual": {}, "verhulst": {},
}  # fmt: skip
"""Predictors compared, with their options."""


class Vector(NamedTuple):
    """A row of the digest's table; NaN where it has none."""

    name: str
    samples: np.ndarray
    c: float
    u: float
    prediction: float
    shifted: float
    line: float


def vectors() -> list[Vector]:
    """The twenty windows of the digest, of 13 digits, computed with 60."""
    with VECTORS.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = ("c", "u", "pred_next", "pred_shift150", "ls4_line")
    return [
        Vector(r["name"], np.array([float(r[k]) for k in SAMPLES]),
               *(float(r[k]) if r[k] else math.nan for k in names))
        for r in rows
    ]  # fmt: skip


# ---- the filter of the load cell alone
class Fed(NamedTuple):
    """A force: constant, slope, or sine."""

    level: float = 0.0
    slope: float = 0.0
    size: float = 0.0
    frequency: float = 20.0


@reference(Fed(), unit="N")
def fed(p, t):
    """The force that the cell gets."""
    return p.level + p.slope * t + p.size * math.sin(2.0 * math.pi * p.frequency * t)


@controller(unit="N")
def passes(command):
    """What is commanded is applied."""
    return command


class Pressed(NamedTuple):
    """The force at the edge."""

    force: float = 0.0


def as_turned(s):
    """What the cell measures."""
    return Turned(s.force, 0.0, 0.0, 0.0, 0.0, 0.0)


@plant(Fed(), Pressed(), output=as_turned)
def pressed(p, s, u, dt):
    """The force is what is applied."""
    return Pressed(u)


def on_the_load_cell(samples: int = 4000, **changes: float) -> np.ndarray:
    """The filtered force of a cell under a given force, N; changes by the names of :class:`Fed`, or ``noise_n``."""
    loop = _cell().using(
        {f"sensor.{k}" if k == "noise_n" else f"reference.{k}": v for k, v in ({"noise_n": 0.0} | changes).items()}
    )
    found: np.ndarray = loop.run(samples * PERIOD_S, record=("feedback",))["feedback"]
    return found


def _cell() -> Loop:
    from leadscrew.kernel.loop import Loop

    return Loop(reference=fed, controller=passes, plant=pressed, sensor=load_cell, period=PERIOD_S, metrics={})


# ---- on the force of closed loops
class Errors(NamedTuple):
    """Root mean square errors of one-step predictions, N: one value a run."""

    transient: np.ndarray
    steady: np.ndarray


def closed_loops(loops: Loops, name: str, machine: str, count: int = RUNS) -> np.ndarray:
    """Filtered forces of the fixed depth, rows by noise seed, N."""
    loop = loops.get(name, "fig6_fixed_depth", machine=machine)
    key = "controller.output_scale"
    value = loops.controllers[name].params.output_scale
    found: np.ndarray = filtered(loop.batch(3.0, {key: np.full(count, value)}, record=("feedback",)))
    return found


def judged(loops: Loops, name: str, machine: str, kinds: Sequence[int], count: int = RUNS) -> list[Reading]:
    """Readings of a grey controller with each of several predictors, 30 noise seeds each."""
    loop = loops.get(name, "fig6_fixed_depth", machine=machine)
    batch = loop.batch(3.0, {"controller.predictor": np.repeat(kinds, count)}, record=("feedback",))
    return [read(rows) for rows in np.split(filtered(batch), len(kinds))]


def errors(forces: np.ndarray) -> dict[str, Errors]:
    """Errors of every predictor on rows of forces, apart for the rise and for the rest."""
    at = PERIOD_S * np.arange(1, forces.shape[1])
    found: dict[str, Errors] = {}
    for model, options in MODELS.items():
        missed: Any = np.array([predictions(row, model, 5, 1.0, **options)[:-1] - row[1:] for row in forces])
        rms = [np.sqrt(np.mean(missed[:, part] ** 2, axis=1)) for part in (at < TRANSIENT_S, at >= STEADY_S)]
        found[model] = Errors(*rms)
    return found
