"""Pieces of one path, cut one after the other: what the next one gets from those before.

A piece starts from rest at the start of the line, as the first did. From piece to piece go the table of offsets
(:func:`leadscrew.tangent.piece_learning.next_offsets`), and, of controllers that take a ``prior``, the weights and
their covariance. Each piece has a texture and noise of its own, the same for every controller.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers._tangent.curvature_feed_forward import COUNT, START, curvature_feed_forward
from leadscrew.controllers._tangent.taught_offset import taught_alone, taught_offset
from leadscrew.kernel.block import Block
from leadscrew.studies.lab import measure
from leadscrew.studies.sofnn_tangent.cuts import NONE, PNN, RUNS, TUNED, material_columns
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MATERIAL_NAMES, MISMATCH, SEED, takes_cut_line
from leadscrew.tangent.piece_learning import next_offsets

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop
    from leadscrew.studies.lab import Lab

PLACES = 1024
"""Places of a table: the longest line, 924 samples, and some."""
METRICS = ("rms_error", "max_error", "lateral")
PLAIN = (0.8,)
FALLING = (1.0, 0.9, 0.5, 0.4, 0.3)
"""Gains of the table from piece to piece, the last one stays: what is learned later has more pieces behind it."""
SWAP_AT = 5
"""Piece from which the flower is cut in foam instead of fabric."""


class Learned(NamedTuple):
    """What a controller with a prior knows: one row a cell of the batch, ``[material x run, ...]``, by line."""

    prior: dict[str, np.ndarray]
    covariance: dict[str, np.ndarray]

    def of(self, line: str) -> dict[str, np.ndarray]:
        """What is known for a line, as parameters; without a covariance the controller's own stays."""
        known = {"prior": self.prior, "prior_covariance": self.covariance}
        return {key: rows[line] for key, rows in known.items() if line in rows}


class Pieces(NamedTuple):
    """What came of the pieces: arrays ``[piece, line, material, run]``."""

    rms: np.ndarray
    """deg"""
    largest: np.ndarray
    """deg"""
    lateral: np.ndarray
    """mm"""
    tables: dict[str, np.ndarray]
    """The table after the last piece by line, ``[material, run, sample]``, deg; empty where nothing was taught."""
    learned: Learned
    """What the controller knows after the last piece; empty where it has no prior."""

    def mean(self, piece: int) -> float:
        """Mean RMS of a piece, the first is 1, over all cells and runs, deg."""
        return float(self.rms[piece - 1].mean())

    def spread(self, piece: int) -> float:
        """Standard deviation over the runs of the mean RMS over all cells, deg."""
        return float(self.rms[piece - 1].mean(axis=(0, 1)).std(ddof=1))


class Plan(NamedTuple):
    """What the pieces of every line have in common."""

    total: int
    """How many."""
    gains: tuple[float, ...] = ()
    """Of the table, from piece to piece; none: there is no table."""
    carry: bool = False
    """Weights and covariance of a controller with a prior go on to the next piece."""
    runs: int = RUNS
    materials: tuple[str, ...] = MATERIAL_NAMES
    swap: bool = False
    """From piece :data:`SWAP_AT` on the material is foam."""
    first: int = 0
    """How many pieces of noise were used up before."""


def pieces(
    lab: Lab,
    controller: str | Block | None,
    plan: Plan,
    lines: Sequence[str] = LINES,
    start: Learned | None = None,
    changes: Mapping[str, Any] | None = None,
    seed: int = SEED,
) -> Pieces:
    """Cuts pieces of every line in every material.

    Args:
        lab: of the study.
        controller: by name, or a block; None: no feedback, the table alone.
        plan: how many pieces, and what goes on from one to the next.
        lines: by name.
        start: what the controller knows before the first piece.
        changes: of the loop, by dotted key.
        seed: of textures and noises.
    """
    block = lab.study.controller(controller) if isinstance(controller, str) else controller
    inner = "controller.inner." if plan.gains and block is not None else "controller."
    if block is None:
        block = taught_alone(np.zeros(PLACES))
    elif plan.gains:
        block = taught_offset(block, np.zeros(PLACES))
    jobs = []
    for line in lines:
        loop = lab.loop(block, f"{line}_fabric", changes=changes).using(seed=seed)
        _ = loop.program  # built once, before the threads ask for it
        duration = lab.study.scenario(f"{line}_fabric").duration_s
        jobs.append((loop, duration, {} if start is None else start.of(line)))
    with ThreadPoolExecutor(os.cpu_count()) as side_by_side:
        done = list(side_by_side.map(lambda job: _cut_line(plan, inner, *job), jobs))
    numbers = np.stack([found for found, _, _ in done], axis=2)
    tables = {line: table for line, (_, table, _) in zip(lines, done, strict=True) if plan.gains}
    known = {line: k for line, (_, _, k) in zip(lines, done, strict=True) if plan.carry}
    learned = Learned(*({line: k[key] for line, k in known.items()} for key in ("prior", "prior_covariance")))
    return Pieces(numbers[0], numbers[1], numbers[2], tables, learned)


def _cut_line(
    plan: Plan, inner: str, loop: Loop, duration_s: float, known: dict[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """The pieces of one line: numbers ``[metric, piece, material, run]``, the last table, what is known at the end."""
    cells = len(plan.materials) * plan.runs
    periods = loop.periods(duration_s)
    block = loop.blocks["controller"]
    assert block is not None
    table_key = "controller.table" if inner == "controller." else "controller.taught.table"
    seen = "feedback.deviation" if takes_cut_line(block) else "feedback"
    table = np.zeros((cells, PLACES))
    numbers = np.zeros((len(METRICS), plan.total, len(plan.materials), plan.runs))
    for j in range(plan.total):
        swapped = plan.swap and j + 1 >= SWAP_AT
        columns = material_columns(["foam"] * len(plan.materials) if swapped else plan.materials, plan.runs)
        columns |= {inner + key: value for key, value in known.items()}
        if plan.gains:
            columns[table_key] = table
        record = ("output", seen) if plan.gains else ()
        noise = (plan.first + j) * cells
        if plan.carry:
            metrics, signals, known = _one_by_one(loop, periods, columns, inner, noise)
        else:
            batch = loop.batch(duration_s, columns, record=record, first=noise)
            metrics, signals = batch.metrics, batch.signals
        for k, name in enumerate(METRICS):
            numbers[k, j] = metrics[name].reshape(numbers.shape[2:])
        if plan.gains:
            gain = plan.gains[min(j, len(plan.gains) - 1)]
            after = next_offsets(
                table[:, :periods], signals["output"], signals[seen], gain=gain, lead=6, width=1.5, plant_gain=0.9
            )
            table = np.pad(after, ((0, 0), (0, PLACES - periods)), mode="edge")
    return numbers, table.reshape(len(plan.materials), plan.runs, PLACES), known


def _one_by_one(
    loop: Loop, periods: int, columns: Mapping[str, np.ndarray], inner: str, first: int
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The runs of a batch one after the other: metrics, no signals, and what the controller knows at their ends."""
    done, ends = [], []
    numbers = {key: column for key, column in columns.items() if column.ndim == 1}
    arrays = {key: column for key, column in columns.items() if column.ndim > 1}
    for k in range(len(next(iter(columns.values())))):
        changes: dict[str, Any] = {key: float(column[k]) for key, column in numbers.items()}
        live = loop.using(changes | {key: column[k] for key, column in arrays.items()}).start(replicate=first + k)
        done.append(live.advance(periods, record=(), every=0))
        ends.append(live.save().arrays)
    leaves = {x.key: x for x in loop.program.plan.state.arrays}

    def at_the_end(name: str) -> np.ndarray:
        leaf = leaves[inner + name]
        return np.array([e[leaf.at : leaf.at + leaf.size] for e in ends])

    weights, covariance = at_the_end("weights"), at_the_end("covariance")
    square = covariance.reshape(len(weights), weights.shape[1], weights.shape[1])
    return (
        {name: np.array([r.metrics[name] for r in done]) for name in METRICS},
        {},
        {
            "prior": weights,
            "prior_covariance": square,
        },
    )


# ---- the series of pieces that experiments and figures share
WAYS: dict[str, tuple[str | Block | None, Plan]] = {
    "a table of offsets alone": (None, Plan(6, PLAIN)),
    "paper.sofnn_pnn and the table": (PNN, Plan(6, PLAIN)),
    "paper.sofnn_pnn and the table, falling gains": (PNN, Plan(6, FALLING)),
    "ours.sofnn_tuned and the table": (TUNED, Plan(3, PLAIN)),
    "adaptive feed-forward": (curvature_feed_forward, Plan(3, carry=True)),
}


TABLE_ALONE, FALLING_NET, TUNED_TABLE, AHEAD = (w for w in WAYS if w != "paper.sofnn_pnn and the table")
ON_THE_OTHER_PLANT = (TABLE_ALONE, FALLING_NET, AHEAD)
WITH_NEW_MATERIAL = (TABLE_ALONE, TUNED_TABLE, AHEAD)


@measure
def series(lab: Lab, way: str, mismatch: bool = False) -> Pieces:
    """Pieces of three lines in three materials, five runs each; three pieces where the plant is not as believed."""
    controller, plan = WAYS[way]
    return pieces(lab, controller, plan._replace(total=3) if mismatch else plan, changes=unknown_plant(mismatch))


@measure
def swapped(lab: Lab, way: str) -> np.ndarray:
    """RMS deviation of eight flowers ``[piece, run]``, deg: in fabric, and in foam from :data:`SWAP_AT` on."""
    controller, plan = WAYS[way]
    plan = plan._replace(total=8, materials=("fabric",), swap=True)
    return pieces(lab, controller, plan, lines=("flower",)).rms[:, 0, 0]


def unknown_plant(mismatch: bool) -> dict[str, float]:
    """Changes that make the plant the one that no controller knows of."""
    return {f"plant.{key}": value for key, value in MISMATCH.items()} if mismatch else {}


@measure
def with_prior(lab: Lab, mismatch: bool = False) -> Pieces:
    """The first piece of each line in each material, by a feed-forward that has seen neither line nor material.

    Its weights are the mean of what two pieces of the two other lines taught in the two other materials.
    """
    changes = unknown_plant(mismatch)
    known = {
        m: pieces(lab, curvature_feed_forward, Plan(2, (), True, 2, (m,), first=50), changes=changes).learned
        for m in MATERIAL_NAMES
    }
    weights = {line: np.repeat([others_mean(known, m, line) for m in MATERIAL_NAMES], RUNS, axis=0) for line in LINES}
    block = curvature_feed_forward(prior_covariance=START * np.eye(COUNT))
    return pieces(lab, block, Plan(1), start=Learned(weights, {}), changes=changes)


def others_mean(known: Mapping[str, Learned], material: str, line: str) -> np.ndarray:
    """Mean of the weights that the other two lines have taught in the other two materials."""
    means = [
        np.mean([known[other].prior[o].mean(axis=0) for o in LINES if o != line], axis=0)
        for other in MATERIAL_NAMES
        if other != material
    ]
    return np.asarray(np.mean(means, axis=0))


@measure
def uncompensated(lab: Lab, mismatch: bool = False) -> Pieces:
    """The first piece without any compensation."""
    return pieces(lab, NONE, Plan(1), changes=unknown_plant(mismatch))
