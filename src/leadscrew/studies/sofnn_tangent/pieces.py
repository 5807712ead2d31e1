"""Pieces of one path, cut one after the other: what the next one gets from those before.

A piece starts from rest at the start of the line, as the first did. From piece to piece go the table of offsets
(:func:`leadscrew.analysis.piece_learning.next_offsets`), and, of controllers that take a ``prior``, the weights and
their covariance. Each piece has a texture and noise of its own, the same for every controller.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.piece_learning import next_offsets, next_offsets_textbook
from leadscrew.controllers.tangent.taught_offset import taught_alone, taught_offset
from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.changing import at_feed
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.machines import MISMATCH as SIZES
from leadscrew.studies.sofnn_tangent.runs import SEED, Loops, material_columns, takes_cut_line

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

ROOM = 1024
"""Places of a table: the longest line, 924 samples, and some."""
MISMATCH: dict[str, float] = {f"plant.{key}": value for key, value in SIZES.items()}
"""The plant that no controller knows of, as changes of a loop."""
METRICS = ("rms_error", "max_error", "lateral")


class Teaching(NamedTuple):
    """How the table of a piece is made of the last one."""

    gains: tuple[float, ...] = (0.8,)
    """Of the first piece, the second, ...; the last one stays."""
    width: float = 1.5
    lead: int = 6
    plant_gain: float = 0.9
    textbook: bool = False


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
    most: np.ndarray
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

    def largest(self, piece: int) -> float:
        """Mean over all cells and runs of the largest deviation in a piece, deg."""
        return float(self.most[piece - 1].mean())

    def aside(self, piece: int) -> tuple[float, float]:
        """Largest distance of the cut from its line in a piece, mm: mean over all cells, and of the worst one."""
        by_cell = self.lateral[piece - 1].mean(axis=-1)
        return float(by_cell.mean()), float(by_cell.max())

    def spread(self, piece: int) -> float:
        """Standard deviation over the runs of the mean RMS over all cells, deg."""
        return float(self.rms[piece - 1].mean(axis=(0, 1)).std(ddof=1))

    def chance(self, piece: int, digit: float = 0.005) -> float:
        """By how much two means of so many runs may differ by chance: three standard deviations, and half a digit."""
        return float(3.0 * np.sqrt(2.0 / self.rms.shape[-1]) * self.spread(piece) + digit)


def pieces(
    loops: Loops,
    controller: str | Block | None,
    count: int,
    teaching: Teaching | None = None,
    carry: bool = False,
    runs: int = 5,
    lines: Sequence[str] = tuple(LAPS),
    materials: Sequence[str] = MATERIAL_NAMES,
    suffix: str = "",
    swap: tuple[int, str] | None = None,
    start: Learned | None = None,
    first: int = 0,
    changes: Mapping[str, Any] | None = None,
    feed: float | None = None,
    seed: int = SEED,
) -> Pieces:
    """Cuts ``count`` pieces of every line in every material, ``runs`` times each.

    Args:
        loops: of the study.
        controller: by name, or a block; None: no feedback, the table alone.
        count: of pieces.
        teaching: how the table is made; None: there is none.
        carry: weights and covariance of a controller with a prior go on to the next piece.
        runs: of every cell.
        lines: by name.
        materials: by name.
        suffix: of the scenarios' names (``_on_mismatch``).
        swap: from the piece of this number (the first is 1) on the material is this one.
        start: what the controller knows before the first piece.
        first: how many pieces of noise were used up before.
        changes: of the loop, by dotted key.
        feed: mm/s, if it is not the scenario's; only without a table.
        seed: of textures and noises.
    """
    block = loops.controllers[controller] if isinstance(controller, str) else controller
    inner = "controller.inner." if teaching is not None and block is not None else "controller."
    table_key = "controller.table" if block is None else "controller.taught.table"
    if block is None:
        block = taught_alone(np.zeros(ROOM))
    elif teaching is not None:
        block = taught_offset(block, np.zeros(ROOM))
    seen = "feedback.deviation" if takes_cut_line(block) else "feedback"
    cut = Cut(inner, table_key, seen, count, teaching, carry, runs, tuple(materials), swap, first)
    jobs = []
    for line in lines:
        scenario = loops.asked(f"{line}_fabric{suffix}")
        scenario = scenario if feed is None else at_feed(loops, feed, line)
        loop = loops.get(block, scenario, changes=changes).using(seed=seed)
        loop.program  # noqa: B018
        jobs.append((loop, scenario.duration_s, {} if start is None else start.of(line)))
    with ThreadPoolExecutor(os.cpu_count()) as side_by_side:
        done = list(side_by_side.map(lambda job: cut_line(cut, *job), jobs))
    found = np.stack([numbers for numbers, _, _ in done], axis=2)
    tables = {line: table for line, (_, table, _) in zip(lines, done, strict=True)} if teaching is not None else {}
    knows = [known for _, _, known in done]
    learned = Learned(
        {line: k["prior"] for line, k in zip(lines, knows, strict=True) if carry},
        {line: k["prior_covariance"] for line, k in zip(lines, knows, strict=True) if carry},
    )
    return Pieces(found[0], found[1], found[2], tables, learned)


class Cut(NamedTuple):
    """What the pieces of every line have in common; as in :func:`pieces`."""

    inner: str
    table_key: str
    seen: str
    pieces: int
    teaching: Teaching | None
    carry: bool
    runs: int
    materials: tuple[str, ...]
    swap: tuple[int, str] | None
    first: int


def cut_line(
    cut: Cut, loop: Loop, duration_s: float, known: dict[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """The pieces of one line: numbers ``[metric, piece, material, run]``, the last table, what is known at the end."""
    cells = len(cut.materials) * cut.runs
    periods = loop.periods(duration_s)
    table = np.zeros((cells, ROOM))
    found = np.zeros((len(METRICS), cut.pieces, len(cut.materials), cut.runs))
    for j in range(cut.pieces):
        swapped = cut.swap is not None and j + 1 >= cut.swap[0]
        materials = [cut.swap[1]] * len(cut.materials) if cut.swap and swapped else cut.materials
        columns = material_columns(materials, cut.runs)
        columns |= {cut.inner + key: value for key, value in known.items()}
        if cut.teaching is not None:
            columns[cut.table_key] = table
        record = () if cut.teaching is None else ("output", cut.seen)
        noise = (cut.first + j) * cells
        if cut.carry:
            metrics, signals, known = one_by_one(loop, periods, columns, record, cut.inner, noise)
        else:
            batch = loop.batch(duration_s, columns, record=record, first=noise)
            metrics, signals = batch.metrics, batch.signals
        for k, name in enumerate(METRICS):
            found[k, j] = metrics[name].reshape(found.shape[2:])
        if cut.teaching is not None:
            after = following(cut.teaching, j, table[:, :periods], signals["output"], signals[cut.seen])
            table = np.pad(after, ((0, 0), (0, ROOM - periods)), mode="edge")
    return found, table.reshape(len(cut.materials), cut.runs, ROOM), known


def one_by_one(
    loop: Loop, periods: int, columns: Mapping[str, np.ndarray], record: tuple[str, ...], inner: str, first: int
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The runs of a batch one after the other: metrics, signals, and what the controller knows at their ends."""
    done, ends = [], []
    alike: dict[tuple[float, ...], Loop] = {}
    numbers = {key: column for key, column in columns.items() if column.ndim == 1}
    arrays = {key: column for key, column in columns.items() if column.ndim > 1}
    for k in range(len(next(iter(columns.values())))):
        of_run = {key: float(column[k]) for key, column in numbers.items()}
        if tuple(of_run.values()) not in alike:
            alike[tuple(of_run.values())] = loop.using(of_run)
        same = alike[tuple(of_run.values())]
        live = same.using({key: column[k] for key, column in arrays.items()}).start(run=first + k)
        done.append(live.advance(periods, record=record, every=1 if record else 0))
        ends.append(live.save().arrays)
    leaves = {x.key: x for x in loop.program.plan.state.arrays}

    def at_the_end(name: str) -> np.ndarray:
        leaf = leaves[inner + name]
        return np.array([e[leaf.at : leaf.at + leaf.size] for e in ends])

    weights, covariance = at_the_end("weights"), at_the_end("covariance")
    square = covariance.reshape(len(weights), weights.shape[1], weights.shape[1])
    return (
        {name: np.array([r.metrics[name] for r in done]) for name in METRICS},
        {name: np.array([r.signals[name] for r in done]) for name in record},
        {"prior": weights, "prior_covariance": square},
    )


def following(teaching: Teaching, piece: int, table: np.ndarray, sent: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """The next tables of a batch, after a piece (the first is 0)."""
    how = {"gain": teaching.gains[min(piece, len(teaching.gains) - 1)], "lead": teaching.lead, "width": teaching.width}
    if teaching.textbook:
        return next_offsets_textbook(table, seen, **how)  # type: ignore[arg-type]
    return next_offsets(table, sent, seen, plant_gain=teaching.plant_gain, **how)  # type: ignore[arg-type]
