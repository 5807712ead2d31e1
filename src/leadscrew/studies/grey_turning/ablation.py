"""What a predictor is worth when every controller is tuned with the same effort.

Each variant is the fuzzy controller of the paper with another prediction in reading B, tuned by itself: the factors
S1, S2, S3 in the logarithm between :data:`LOW` and :data:`HIGH`, CMA-ES from the middle of that box, :data:`BUDGET`
evaluations, three seeds of the search, on two noise seeds that are the same for every candidate. The cost of a cut of
2 s at 150 N, with the true force F and the filtered force y at the samples,

    J = 1/2 sum t |F - r| T + 1/2 sum t |y - r| T + 0.5 N s^2 for each percent of overshoot of y above 1 %

in N s^2. The digest gives neither the penalty nor the horizon: 1 % is the overshoot that noise alone makes, the weight
and the 2 s are ours. The factors that were found are kept in ``data/ablation_factors.csv``; :func:`found_anew` finds
them again, six digits alike on the same versions of CMA-ES and NumPy. :func:`judgement` runs them under
:data:`HELD_OUT` noise seeds that the search never saw. Intervals are over these: they hold for the factors that were
found, and say nothing of another choice of the two noise seeds of the search. Other costs:
:mod:`~leadscrew.studies.grey_turning.ablation_costs`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.grey_fuzzy import gpfc
from leadscrew.controllers.grey_fuzzy.gpfc import READING_A, READING_B
from leadscrew.controllers.grey_fuzzy.smith import smith
from leadscrew.grey.predictors import DGM, EXPONENTIAL, GM, GM_GUARDED, LAST, LINE, RESIDUAL, TWO_POINT, VERHULST
from leadscrew.kernel.block import Block, sensor
from leadscrew.kernel.noise import Noise
from leadscrew.kernel.sheet import Doc, Ge
from leadscrew.sensors.load_cell import LoadCellParams, LoadCellState, weighed
from leadscrew.studies.grey_turning.runs import Loops, filtered

FORCE_N = 150.0
FREE = 1.0
"""Percent of overshoot that cost nothing."""


class Cost(NamedTuple):
    """What a controller is tuned for and judged by."""

    horizon_s: float = 2.0
    """Length of the cut."""
    penalty: float = 0.5
    """N s^2 for each percent of overshoot above :data:`FREE`."""


COST = Cost()

FACTORS = ("error_scale", "change_scale", "output_scale")
LOW = (2.0, 0.5, 0.0005)
HIGH = (400.0, 100.0, 0.2)
"""The box of the search: S1 in N, S2 in N a sample, S3 in V."""
BUDGET = 600
"""Evaluations of a search."""
SEARCHES = (1, 2, 3)
"""Seeds of the search."""
TUNED_ON = (0, 1)
"""Noise seeds of the search."""
HELD_OUT = tuple(range(1000, 1040))
"""Noise seeds of the judgement."""
PLANTS = ("plant_f", "plant_n")
SCENARIO = "fig6_fixed_depth"

MODELS: dict[str, dict[str, float]] = {"plant_f": {}, "plant_n": {"model.rate": 20.0, "model.delay_s": 0.045}}
"""What the Smith predictor believes: the plant's servo; half a revolution and the dead time."""

VARIANTS: dict[str, dict[str, Any]] = {
    "tfc": {"predictor": LAST},
    "gpfc_b": {"predictor": GM},
    "line": {"predictor": LINE},
    "two_point": {"predictor": TWO_POINT},
    "gm_h2": {"predictor": GM_GUARDED, "horizon": 2.0},
    "dgm": {"predictor": DGM},
    "gpfc_a": {"predictor": GM, "reading": READING_A},
    "exponential": {"predictor": EXPONENTIAL},
    "residual": {"predictor": RESIDUAL},
    "verhulst": {"predictor": VERHULST},
}
"""Parameters of the GPFC, reading B unless told otherwise; with the last value as prediction it is the TFC."""
SWITCHES = ("predictor", "reading", "horizon")
"""Parameters by which they differ."""
SMITH = "smith"
NAMES = (*VARIANTS, SMITH)
RECORDED = ("feedback", "actual.force")
FILE = Path(__file__).parent / "data" / "ablation_factors.csv"


def variant(name: str, plant: str) -> Block:
    """The controller of a variant on a plant, its factors not yet tuned."""
    if name == SMITH:
        return smith(**MODELS[plant])
    return gpfc(**({"reading": READING_B} | VARIANTS[name]))


class RepeatedCellParams(NamedTuple):
    """A load cell, and which noise it has."""

    cell: LoadCellParams = LoadCellParams()
    which: Annotated[int, Ge(0), Doc("number of the run whose noise this is")] = 0


@sensor(RepeatedCellParams(), LoadCellState(), unit="N")
def repeated_cell(p, s, actual, noise):
    """The load cell with the noise of a run that is told: candidates beside each other can have the same noise."""
    now = weighed(p.cell, s, actual.force, Noise(noise.seed, p.which, noise.block, noise.period))
    return now, now.force


def costs(t: np.ndarray, force: np.ndarray, y: np.ndarray, cost: Cost = COST) -> np.ndarray:
    """J of the true and the filtered force, one row a run, of samples before the end of the cost's cut."""
    period = t[1] - t[0]
    within = t < cost.horizon_s - 0.5 * period
    off = np.abs(force - FORCE_N) + np.abs(y - FORCE_N)
    itae = 0.5 * period * (t[within] * off[:, within]).sum(axis=1)
    overshoot = 100.0 * (y[:, within].max(axis=1) / FORCE_N - 1.0)
    return np.asarray(itae + cost.penalty * np.maximum(overshoot - FREE, 0.0))


def costs_of(batch: Any, cost: Cost = COST) -> np.ndarray:
    """J of every run of a batch; infinite where one diverged."""
    found = costs(batch.time, batch["actual.force"], filtered(batch), cost)
    return np.where(np.isfinite(batch.diverged_at), np.inf, found)


@dataclass(frozen=True)
class Tuned:
    """What one search found."""

    plant: str
    name: str
    search: int
    factors: tuple[float, float, float]
    cost: float
    """J on the noise that it was tuned on, N s^2."""


def found_anew(loops: Loops, plant: str, name: str, search: int, budget: int = BUDGET, cost: Cost = COST) -> Tuned:
    """One search: the same plant, variant, seed, budget and cost give the same factors."""
    from leadscrew.tune.optimisers import OPTIMISERS, Answer, Search

    loop = loops.get(variant(name, plant), SCENARIO, machine=plant, sensor=repeated_cell)
    low, high = np.log(LOW), np.log(HIGH)
    best = (np.inf, np.zeros(3))

    def evaluate(points: np.ndarray) -> Answer:
        nonlocal best
        factors = np.exp(low + (high - low) * points)
        varied = {f"controller.{k}": np.repeat(factors[:, i], len(TUNED_ON)) for i, k in enumerate(FACTORS)}
        varied["sensor.which"] = np.tile(TUNED_ON, len(points))
        done = loop.batch(cost.horizon_s, varied, record=RECORDED)
        found = costs_of(done, cost).reshape(-1, len(TUNED_ON)).mean(axis=1)
        at = int(np.argmin(found))
        best = min(best, (float(found[at]), factors[at]), key=lambda pair: pair[0])
        return Answer(np.minimum(found, 1e9)[:, None], np.zeros((len(points), 0)))

    OPTIMISERS["cma"][0](Search(evaluate, np.full(3, 0.5), budget, search))
    s1, s2, s3 = (float(x) for x in best[1])
    return Tuned(plant, name, search, (s1, s2, s3), best[0])


def row_of(cells: Mapping[str, str]) -> Tuned:
    """A search as a file has it."""
    factors = (float(cells["s1"]), float(cells["s2"]), float(cells["s3"]))
    return Tuned(cells["plant"], cells["variant"], int(cells["search"]), factors, float(cells["cost"]))


@lru_cache(maxsize=1)
def tuned() -> tuple[Tuned, ...]:
    """What the searches found, as kept."""
    with FILE.open(newline="", encoding="utf-8") as file:
        return tuple(row_of(cells) for cells in csv.DictReader(file))


@dataclass(frozen=True)
class Judgement:
    """J of one variant on one plant, in N s^2."""

    held_out: np.ndarray
    """``(searches, noise seeds)``, on noise that no search has seen."""
    trained: float
    """Mean over the searches of J on the noise that they were tuned on, run again."""
    kept: float = math.nan
    """The same as the searches left it."""
    seen: int = 0
    """Held-out cuts whose forces are those of a cut that was tuned on, sample by sample."""

    @property
    def mean(self) -> float:
        """Over searches and noise seeds."""
        return float(self.held_out.mean())

    @property
    def by_noise(self) -> np.ndarray:
        """Mean over the searches, one number a noise seed."""
        return np.asarray(self.held_out.mean(axis=0))

    @property
    def repeatability(self) -> tuple[float, float]:
        """Least and greatest mean of a search."""
        means = self.held_out.mean(axis=1)
        return float(means.min()), float(means.max())


class Difference(NamedTuple):
    """Change of J against another variant in the same noise, percent of the other's, with a 95 % interval."""

    percent: float
    low: float
    high: float

    @property
    def shown(self) -> bool:
        """Whether the interval leaves 0 out."""
        return self.low > 0.0 or self.high < 0.0


def difference(one: Judgement, other: Judgement) -> Difference:
    """Paired over noise seeds, Student's interval."""
    from scipy.stats import ttest_1samp

    change = 100.0 * (one.by_noise - other.by_noise) / other.mean
    ends = ttest_1samp(change, 0.0).confidence_interval(0.95)
    return Difference(float(change.mean()), float(ends.low), float(ends.high))


def _cuts(loops: Loops, rows: Sequence[Tuned], noise: Sequence[int], seconds: float) -> list[tuple[Any, slice]]:
    """Cuts of every row under the same noise: the batch that they are in, and where; one batch a plant and a law."""
    found: list[tuple[Any, slice]] = [(None, slice(0))] * len(rows)
    for plant, smiths in sorted({(row.plant, row.name == SMITH) for row in rows}):
        at = [k for k, row in enumerate(rows) if (row.plant, row.name == SMITH) == (plant, smiths)]
        blocks = [variant(rows[k].name, plant) for k in at]
        loop = loops.get(blocks[0], SCENARIO, machine=plant, sensor=repeated_cell)
        varied = {f"controller.{f}": [rows[k].factors[i] for k in at] for i, f in enumerate(FACTORS)}
        if not smiths:
            varied |= {f"controller.{f}": [getattr(b.params, f) for b in blocks] for f in SWITCHES}
        each = {key: np.repeat(values, len(noise)) for key, values in varied.items()}
        done = loop.batch(seconds, each | {"sensor.which": np.tile(noise, len(at))}, record=RECORDED)
        for place, k in enumerate(at):
            found[k] = done, slice(place * len(noise), (place + 1) * len(noise))
    return found


def judgement(
    loops: Loops, rows: Sequence[Tuned] | None = None, cost: Cost = COST
) -> Mapping[tuple[str, str], Judgement]:
    """Every variant that was tuned, by plant and name, on the held-out noise and on that of the search."""
    asked = tuned() if rows is None else rows
    found: dict[tuple[str, str], list[tuple[np.ndarray, float, float, int]]] = {}
    cuts = _cuts(loops, asked, (*TUNED_ON, *HELD_OUT), cost.horizon_s)
    priced = {id(done): costs_of(done, cost) for done, _ in cuts}
    for row, (done, at) in zip(asked, cuts, strict=True):
        price, force = priced[id(done)][at], done["actual.force"][at]
        old, new = np.split(price, [len(TUNED_ON)])
        same = (force[len(TUNED_ON) :, None] == force[None, : len(TUNED_ON)]).all(axis=2).any(axis=1)
        found.setdefault((row.plant, row.name), []).append((new, float(old.mean()), row.cost, int(same.sum())))
    return {
        key: Judgement(
            np.array([each[0] for each in made]), float(np.mean([each[1] for each in made])),
            float(np.mean([each[2] for each in made])), sum(each[3] for each in made),
        )
        for key, made in found.items()
    }  # fmt: skip


_MADE: WeakKeyDictionary[Loops, Mapping[tuple[str, str], Judgement]] = WeakKeyDictionary()


def judgement_of(loops: Loops) -> Mapping[tuple[str, str], Judgement]:
    """The judgement of the kept factors, made once for some loops: claims and pictures share it."""
    if loops not in _MADE:
        _MADE[loops] = judgement(loops)
    return _MADE[loops]
