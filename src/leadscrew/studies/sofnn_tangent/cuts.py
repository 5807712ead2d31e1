"""Cuts that claims, experiments and figures measure: nine cells by controller, and single runs whose rules go on.

A *cell* is a line in a material. A batch of cells gives every controller the same textures and noises; single runs are
for networks whose rules are looked at or go on from piece to piece.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.plants._flexible_cut import MATERIALS
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.sofnn_tangent.laws import fixed_fuzzy
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MATERIAL_NAMES, samples_of

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import Loop

NONE, FIXED, UNTRAINED = "paper.uncompensated", "corrected.fnn", "corrected.fuzzy"
ROUNDED, PNN, TABLE, TUNED, PID = (
    "paper.sofnn_rounded",
    "paper.sofnn_pnn",
    "corrected.sofnn_table",
    "ours.sofnn_tuned",
    "ours.pid",
)
"""The paper's network with levels that are whole numbers; with levels between them; with Table 1 in place of its
performance network; the tuned one; a PID."""
MAMDANI = "Mamdani's inference"
"""The fuzzy system that the rules are trained on, as a controller."""
RUNS = 5
"""Runs of a cell: each with a texture and noise of its own."""
CALM: Mapping[str, Any] = {"disturbance.size": 0.0}
"""No texture; what is left is the noise of the camera."""
STRAIGHT: Mapping[str, Any] = {"plant.material.bias": 0.0, "plant.material.fibre": 0.0}
"""Nothing that turns the cut on a straight line."""


def rms(values: Any) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


# ---- nine cells
class Cells(NamedTuple):
    """What a controller does on all lines in all materials: arrays ``[line, material, run]``."""

    rms: np.ndarray
    """deg"""
    largest: np.ndarray
    """deg"""
    lateral: np.ndarray
    """mm"""


def block_of(lab: Lab, name: str) -> Block:
    """A controller of the study, or Mamdani's inference."""
    return fixed_fuzzy() if name == MAMDANI else lab.study.controller(name)


@measure
def cells(
    lab: Lab,
    controller: str,
    changes: tuple[tuple[str, float], ...] = (),
    runs: int = RUNS,
    lines: tuple[str, ...] = LINES,
    materials: tuple[str, ...] = MATERIAL_NAMES,
) -> Cells:
    """Lines in materials, ``runs`` times each, with parameters changed; one batch a line."""
    rows = []
    for line in lines:
        scenario = lab.study.scenario(f"{line}_fabric")
        loop = lab.loop(block_of(lab, controller), scenario).using(dict(changes))
        batch = loop.batch(scenario.duration_s, material_columns(materials, runs))
        shape = (len(materials), runs)
        rows.append([batch.metrics[name].reshape(shape) for name in ("rms_error", "max_error", "lateral")])
    return Cells(*np.moveaxis(np.array(rows), 1, 0))


def mean_rms(lab: Lab, controller: str, **changes: float) -> float:
    """RMS deviation, mean of all cells and runs, deg; ``changes`` of the controller's parameters."""
    return float(cells(lab, controller, tuple((f"controller.{k}", v) for k, v in changes.items())).rms.mean())


def by_cell(lab: Lab, controller: str) -> np.ndarray:
    """RMS deviation ``[line, material]``, mean of the runs, deg."""
    return np.asarray(cells(lab, controller).rms.mean(axis=-1))


def material_columns(materials: Sequence[str], runs: int) -> dict[str, np.ndarray]:
    """Columns of a batch: ``runs`` runs in each material."""
    return {
        f"plant.material.{field}": np.repeat([getattr(MATERIALS[m], field) for m in materials], runs)
        for field in MATERIALS["fabric"]._fields
    }


def in_material(name: str) -> dict[str, float]:
    """Changes that make the material ``name``."""
    return {f"plant.material.{field}": value for field, value in MATERIALS[name]._asdict().items()}


@measure
def texture_floor(lab: Lab) -> dict[str, float]:
    """RMS deviation where only the texture acts, by material, deg: no shear, fibre and bevel, mean of three lines."""
    total = np.zeros((len(MATERIAL_NAMES), 2 * RUNS))
    for line in LINES:
        columns = material_columns(MATERIAL_NAMES, 2 * RUNS)
        columns |= {f"plant.material.{key}": np.zeros(total.size) for key in ("shear", "fibre", "bias")}
        found = lab.batch(NONE, f"{line}_fabric", columns).metrics["rms_error"]
        total += found.reshape(total.shape) / len(LINES)
    return dict(zip(MATERIAL_NAMES, total[:, :RUNS].mean(axis=1).tolist(), strict=True))


# ---- single runs, rules that go on
def rules(live: Live) -> Any:
    """State of the controller as it is now: ``weights``, ``covariance`` and the rest; a copy."""
    return live.program.plan.state.unpack(live.state[0].copy(), live.state[1].copy()).controller


def first_rules(lab: Lab, controller: str) -> np.ndarray:
    """The 49 rules that a controller starts with, levels."""
    return np.asarray(cast(Any, lab.study.controller(controller).state).weights)


def started(loop: Loop, number: int = 0, weights: Any = None, covariance: Any = None) -> Live:
    """A loop at its start, with these rules in place of its own."""
    live = loop.start(replicate=number)
    known = {k: np.array(v) for k, v in (("weights", weights), ("covariance", covariance)) if v is not None}
    if known:
        state = live.program.plan.state.unpack(*live.state)
        live.state = live.program.plan.state.pack(state._replace(controller=state.controller._replace(**known)))
    return live


def deviations(live: Live, samples: int) -> np.ndarray:
    """The deviation of the cut at the next ``samples`` samples, deg, from the plant's state after each."""
    return np.asarray(live.advance(samples + 1, record=("actual.deviation",))["actual.deviation"])[1:]


def along_the_line(
    lab: Lab, controller: str | Block, scenario: str, number: int = 0, changes: Mapping[str, Any] | None = None
) -> np.ndarray:
    """The deviation at all samples of a scenario's line, deg."""
    loop = lab.loop(controller, scenario)
    live = (loop.using(changes) if changes else loop).start(replicate=number)
    return deviations(live, samples_of(scenario))


class Pieces(NamedTuple):
    """Pieces cut one after another; the rules go on from piece to piece."""

    rms: np.ndarray
    """Of the deviation of each, deg."""
    weights: list[np.ndarray]
    """Consequents after each, levels."""
    covariance: np.ndarray


@measure
def learned(lab: Lab, controller: str, scenario: str, count: int, number: int = 0) -> Pieces:
    """``count`` pieces under a controller that learns, each with a texture of its own; no leak."""
    loop = lab.loop(controller, scenario).using({"controller.leak": 0.0})
    found: list[float] = []
    weights: list[np.ndarray] = []
    covariance: Any = None
    for k in range(count):
        live = started(loop, number + k, weights[-1] if weights else None, covariance)
        found.append(rms(deviations(live, samples_of(scenario))))
        state = rules(live)
        weights.append(state.weights)
        covariance = state.covariance
    return Pieces(np.array(found), weights, covariance)


class Recall(NamedTuple):
    """What is left of the learning when the rules are held: RMS, deg."""

    none: float
    prior: float
    """Rules from before the learning, held."""
    learning: float
    held: float
    """Learned rules, held."""

    @property
    def kept(self) -> float:
        """Share of the gain over the held prior that the held learned rules keep, %."""
        return 100.0 * (self.prior - self.held) / (self.prior - self.learning)


LESSONS = 5
HISTORIES = 3


@measure
def recall(lab: Lab, controller: str, line: str) -> Recall:
    """Learns over five pieces of fabric, then cuts one more: without, with held prior, learning on, held rules.

    Means over three such histories, each with textures of its own.
    """
    scenario = f"{line}_fabric"
    going = lab.loop(controller, scenario).using({"controller.leak": 0.0})
    held = going.using({"controller.learning": False})
    none = lab.loop(NONE, scenario)
    found = []
    for history in range(HISTORIES):
        known = learned(lab, controller, scenario, LESSONS, 10 * history)
        then = 10 * history + LESSONS
        lives = (
            none.start(replicate=then),
            started(held, then),
            started(going, then, known.weights[-1], known.covariance),
            started(held, then, known.weights[-1]),
        )
        found.append([rms(deviations(live, samples_of(scenario))) for live in lives])
    return Recall(*(float(v) for v in np.mean(found, axis=0)))


def stays_within(row: np.ndarray, width: float, since: int = 0) -> int | float:
    """Samples after ``since`` from which on a row stays within ``width`` of zero; NaN where it never does."""
    outside = np.flatnonzero(np.abs(row[since:]) > width)
    after = int(outside[-1]) + 1 if outside.size else 0
    return after if since + after < row.size else float("nan")
