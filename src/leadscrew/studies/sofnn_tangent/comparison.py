"""Every controller of the study on three lines in three materials, under the same five textures and noises.

Beside each row stands the digest's (section 7), from five textures and noises of its own. Two means of five runs differ
by chance: :meth:`Standing.allowed` says by how much for a cell, :meth:`Standing.allowed_mean` for the mean of all nine,
from these runs and :data:`OTHER_RUNS` that are not judged.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.chance import HALF_DIGIT, WIDE, by_chance
from leadscrew.studies.sofnn_tangent.fixed_fuzzy import fixed_fuzzy
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import CELLS, SEED, Cells, Loops, material_columns
from leadscrew.studies.sofnn_tangent.tuning import LAWS, best

NONE = "paper.uncompensated"
FIXED = "corrected.fnn"
PAPER = "paper.sofnn_pnn"
BILINEAR = "corrected.sofnn_table"
TUNED = "ours.sofnn_tuned"
PID = "ours.pid"

OTHER_SEED = SEED + 1000
"""Of the runs that say how much a run differs from the next."""
OTHER_RUNS = 20


class Row(NamedTuple):
    """A row of section 7 of the digest: RMS deviation by line and material, its mean, mean of the largest, deg."""

    words: str
    rms: tuple[float, ...]
    mean: float
    most: float


DIGEST: Mapping[str, Row] = {
    NONE: Row("no compensation", (1.19, 0.94, 1.92, 2.67, 1.83, 4.20, 2.05, 1.62, 3.10), 2.17, 5.0),
    "corrected.fuzzy": Row(
        "fixed rules, untrained", (1.03, 0.82, 1.71, 2.32, 1.61, 3.75, 1.80, 1.43, 2.77), 1.92, 4.4
    ),
    FIXED: Row("fixed network", (1.03, 0.82, 1.71, 2.32, 1.61, 3.74, 1.79, 1.42, 2.77), 1.91, 4.4),
    "corrected.fnn_15": Row(
        "fixed network, six times the gain", (0.63, 0.52, 1.09, 1.43, 1.01, 2.43, 1.19, 0.94, 1.82), 1.23, 3.2
    ),
    "paper.sofnn_rounded": Row(
        "SOFNN, rounded table", (1.03, 0.82, 1.71, 2.32, 1.61, 3.74, 1.79, 1.42, 2.77), 1.91, 4.4
    ),
    BILINEAR: Row("SOFNN, table between cells", (0.51, 0.33, 0.85, 1.73, 1.07, 2.84, 1.27, 0.80, 1.90), 1.26, 3.5),
    PAPER: Row("SOFNN of the paper, safe net", (0.66, 0.40, 1.12, 1.88, 1.16, 3.02, 1.35, 0.84, 2.00), 1.38, 3.8),
    "paper.sofnn_no_prior": Row(
        "the same, no rules at the start", (0.71, 0.43, 1.20, 2.08, 1.30, 3.23, 1.50, 0.94, 2.17), 1.51, 4.1
    ),
    TUNED: Row("SOFNN tuned", (0.27, 0.27, 0.27, 1.00, 0.68, 1.38, 0.98, 0.65, 1.15), 0.74, 2.6),
    PID: Row("PID 0.7, 14, 0.005", (0.27, 0.25, 0.34, 1.07, 0.70, 1.66, 0.95, 0.62, 1.26), 0.79, 2.6),
    "ours.pid_mild": Row("PID 0.3, 6, 0", (0.41, 0.29, 0.65, 1.69, 1.03, 2.79, 1.29, 0.79, 1.91), 1.21, 3.4),
}  # fmt: skip
"""By controller. Of the PID 0.7, 22, 0.01 the digest has the mean alone: :data:`FAST_MEAN`."""
FAST, FAST_MEAN = "ours.pid_fast", 0.69
MAMDANI = "fixed_fuzzy"
"""The name under which Mamdani's inference stands in the table."""
FLOOR = {"fabric": 0.19, "leather": 0.21, "foam": 0.14}
"""RMS deviation of a cut in which nothing but the texture acts, deg."""


@dataclass(frozen=True)
class Standing:
    """A controller on the nine cells, and how much its runs differ."""

    cells: Cells
    other: Cells
    """Runs with other textures and noises."""

    def deviation(self, what: str = "rms", lines: bool = True) -> np.ndarray:
        """Standard deviation from run to run, from all runs: of a cell, or without ``lines`` of a material's mean."""
        parts = [getattr(cells, what) for cells in (self.cells, self.other)]
        parts = parts if lines else [part.mean(axis=0) for part in parts]
        free = [part.shape[-1] - 1 for part in parts]
        pooled = sum(n * part.var(axis=-1, ddof=1) for n, part in zip(free, parts, strict=True)) / sum(free)
        return np.asarray(np.sqrt(pooled))

    def allowed(self, what: str = "rms", half_digit: float = HALF_DIGIT, others: int = CELLS) -> np.ndarray:
        """By how much a mean of five runs and one of ``others`` may differ, a cell each."""
        return by_chance(self.deviation(what), half_digit, others)

    def allowed_mean(self, what: str = "rms", half_digit: float = HALF_DIGIT, others: int = CELLS) -> float:
        """The same of the mean of all cells.

        A run of ours has one texture on all lines and another in each material; the digest's runs, by their seeds, have
        one in all nine cells, so that less of it goes in the mean.
        """
        each = self.deviation(what, lines=False)
        ours, theirs = float(np.square(each).sum()) / len(each) ** 2, float(each.mean()) ** 2
        return WIDE * math.sqrt(ours / CELLS + theirs / others) + half_digit

    @property
    def mean(self) -> float:
        """RMS deviation, mean of all runs, deg."""
        return float(self.cells.rms.mean())

    @property
    def most(self) -> float:
        """Largest deviation, mean of all runs, deg."""
        return float(self.cells.most.mean())

    @property
    def aside(self) -> float:
        """Largest distance of the cut from its line, mean of all runs, mm."""
        return float(self.cells.lateral.mean())

    @property
    def aside_worst(self) -> float:
        """The same of the worst cell, mm."""
        return float(self.cells.lateral.mean(axis=-1).max())

    def by_cell(self) -> np.ndarray:
        """RMS deviation of each cell, deg, in the order of the digest."""
        return np.asarray(self.cells.rms.mean(axis=-1).ravel())

    def agreeing(self, row: Row) -> int:
        """How many of the nine cells are the digest's but for chance."""
        off = np.abs(self.by_cell() - np.array(row.rms))
        return int((off <= self.allowed().ravel()).sum())


@dataclass
class Comparison:
    """The table, and how long it took."""

    loops: Loops
    seconds: float = 0.0
    """For the cells of every controller, none of them made before; programs are compiled where they were not."""
    cells: dict[str, Cells] = field(default_factory=dict)
    _standings: dict[str, Standing] = field(default_factory=dict)

    def block(self, name: str) -> Block:
        """A controller of the table."""
        if name.startswith("equal."):
            return best(name.removeprefix("equal.")).block()
        return fixed_fuzzy() if name == MAMDANI else self.loops.controllers[name]

    def standing(self, name: str) -> Standing:
        """A controller's row with the runs that say how far to trust it; made once."""
        if name not in self._standings:
            other = self.loops.cells(self.block(name), runs=OTHER_RUNS, seed=OTHER_SEED)
            self._standings[name] = Standing(self.cells[name], other)
        return self._standings[name]

    def mean(self, name: str) -> float:
        """RMS deviation, mean of all cells and runs, deg."""
        return float(self.cells[name].rms.mean())

    def apart(self, name: str, other: str) -> tuple[float, float]:
        """By how much the mean RMS deviation of one is above that of the other, deg, and half the 95 % interval.

        Run by run, as both meet the same textures and noises.
        """
        from scipy.stats import t

        runs = (self.cells[name].rms - self.cells[other].rms).mean(axis=(0, 1))
        half = t.ppf(0.975, len(runs) - 1) * runs.std(ddof=1) / math.sqrt(len(runs))
        return float(runs.mean()), float(half)


def names_of(loops: Loops) -> list[str]:
    """All rows: the controllers of the study, Mamdani's inference, and the laws that were tuned alike."""
    return [*loops.controllers, MAMDANI, *(f"equal.{law}" for law in LAWS)]


def compared(loops: Loops) -> Comparison:
    """The table, made now: on loops of its own, so that no cell was made before."""
    made, own = Comparison(loops), Loops()
    began = time.perf_counter()
    for name in names_of(loops):
        made.cells[name] = own.cells(made.block(name))
    made.seconds = time.perf_counter() - began
    return made


_MADE: WeakKeyDictionary[Loops, Comparison] = WeakKeyDictionary()


def comparison_of(loops: Loops) -> Comparison:
    """The table, made once for some loops."""
    if loops not in _MADE:
        _MADE[loops] = compared(loops)
    return _MADE[loops]


def period_us(loops: Loops, name: str, times: int = 5) -> float:
    """Time of one period of a whole loop (reference, camera, controller, axis, cut, metrics), us; the least of some."""
    scenario = loops.asked("flower_fabric")
    loop = loops.get(name, scenario)
    least = math.inf
    for _ in range(times):
        began = time.perf_counter()
        loop.run(scenario.duration_s, record=(), every=0)
        least = min(least, time.perf_counter() - began)
    return 1e6 * least / loop.periods(scenario.duration_s)


def learning_step_us(rounds: int = 7) -> float:
    """What a step of the self-organising network adds to a period of a compiled loop, us.

    As ``leadscrew bench`` measures its row "Kalman, four rules, marginal cost of a step in the loop": a loop with it
    less the same loop without, in turn, process time, medians.
    """
    from leadscrew.bench import entries, probes
    from leadscrew.bench.sofnn import BLOCKS as LEARNERS
    from leadscrew.bench.sofnn import KALMAN, POINTS
    from leadscrew.bench.timing import interleaved

    both = {"with": LEARNERS[KALMAN], "without": probes.adds}
    found = interleaved({key: entries.single(probes.probe(block), POINTS) for key, block in both.items()}, rounds)
    return 1e6 * (found["with"] - found["without"]) / POINTS


class Floor(NamedTuple):
    """RMS deviation where only the texture acts, deg."""

    mean: float
    """Of five runs, on three lines each."""
    deviation: float
    """From run to run."""


def texture_floor(loops: Loops) -> dict[str, Floor]:
    """By material, without shear, fibre and bevel; a run has the same texture on every line."""
    runs = 2 * CELLS
    found = np.zeros((len(MATERIAL_NAMES), runs))
    for line in LAPS:
        scenario = loops.asked(f"{line}_fabric")
        loop = loops.get(NONE, scenario).using(seed=SEED)
        columns = material_columns(MATERIAL_NAMES, runs)
        still = {key: 0.0 * columns[key] for key in columns if key.split(".")[-1] in ("shear", "fibre", "bias")}
        batch = loop.batch(scenario.duration_s, columns | still)
        found += batch.metrics["rms_error"].reshape(found.shape) / len(LAPS)
    return {
        material: Floor(float(row[:CELLS].mean()), float(row.std(ddof=1)))
        for material, row in zip(MATERIAL_NAMES, found, strict=True)
    }
