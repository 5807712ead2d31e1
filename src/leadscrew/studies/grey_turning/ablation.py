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
found, and say nothing of another choice of the two noise seeds of the search.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.grey_fuzzy import gpfc
from leadscrew.controllers.grey_fuzzy.gpfc import READING_A, READING_B
from leadscrew.controllers.grey_fuzzy.smith import smith
from leadscrew.grey.predictors import DGM, GM, GM_GUARDED, LAST, LINE, TWO_POINT
from leadscrew.kernel.block import Block, sensor
from leadscrew.kernel.noise import Noise
from leadscrew.kernel.sheet import Doc, Ge
from leadscrew.sensors.load_cell import LoadCellParams, LoadCellState, weighed
from leadscrew.studies.grey_turning.runs import Loops, filtered

HORIZON_S = 2.0
FORCE_N = 150.0
PENALTY = 0.5
"""N s^2 for each percent of overshoot above :data:`FREE`."""
FREE = 1.0
"""Percent of overshoot that cost nothing."""

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
}
"""Parameters of the GPFC, reading B unless told otherwise; with the last value as prediction it is the TFC."""
SMITH = "smith"
NAMES = (*VARIANTS, SMITH)
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


def costs(t: np.ndarray, force: np.ndarray, y: np.ndarray) -> np.ndarray:
    """J of the true and the filtered force, one row a run."""
    period = t[1] - t[0]
    itae = 0.5 * period * (t * (np.abs(force - FORCE_N) + np.abs(y - FORCE_N))).sum(axis=1)
    overshoot = 100.0 * (y.max(axis=1) / FORCE_N - 1.0)
    return np.asarray(itae + PENALTY * np.maximum(overshoot - FREE, 0.0))


def costs_of(batch: Any) -> np.ndarray:
    """J of every run of a batch; infinite where one diverged."""
    found = costs(batch.time, batch["actual.force"], filtered(batch))
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


def found_anew(loops: Loops, plant: str, name: str, search: int, budget: int = BUDGET) -> Tuned:
    """One search: the same plant, variant, seed and budget give the same factors."""
    from leadscrew.tune.optimisers import OPTIMISERS, Answer, Search

    loop = loops.get(variant(name, plant), SCENARIO, machine=plant, sensor=repeated_cell)
    low, high = np.log(LOW), np.log(HIGH)
    best = (np.inf, np.zeros(3))

    def evaluate(points: np.ndarray) -> Answer:
        nonlocal best
        factors = np.exp(low + (high - low) * points)
        varied = {f"controller.{k}": np.repeat(factors[:, i], len(TUNED_ON)) for i, k in enumerate(FACTORS)}
        varied["sensor.which"] = np.tile(TUNED_ON, len(points))
        done = loop.batch(HORIZON_S, varied, record=("feedback", "actual.force"))
        cost = costs_of(done).reshape(-1, len(TUNED_ON)).mean(axis=1)
        at = int(np.argmin(cost))
        best = min(best, (float(cost[at]), factors[at]), key=lambda pair: pair[0])
        return Answer(np.minimum(cost, 1e9)[:, None], np.zeros((len(points), 0)))

    OPTIMISERS["cma"][0](Search(evaluate, np.full(3, 0.5), budget, search))
    s1, s2, s3 = (float(x) for x in best[1])
    return Tuned(plant, name, search, (s1, s2, s3), best[0])


@lru_cache(maxsize=1)
def tuned() -> tuple[Tuned, ...]:
    """What the searches found, as kept."""
    with FILE.open(newline="", encoding="utf-8") as file:
        return tuple(
            Tuned(r["plant"], r["variant"], int(r["search"]), (float(r["s1"]), float(r["s2"]), float(r["s3"])),
                  float(r["cost"]))
            for r in csv.DictReader(file)
        )  # fmt: skip


@dataclass(frozen=True)
class Judgement:
    """J of one variant on one plant: ``(searches, noise seeds)``, in N s^2; and its readings of y in the mean."""

    held_out: np.ndarray
    trained: float
    """Mean over the searches of J on the noise that they were tuned on."""

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


def judgement(loops: Loops, rows: tuple[Tuned, ...] | None = None) -> Mapping[tuple[str, str], Judgement]:
    """Every variant that was tuned, by plant and name, on the held-out noise."""
    found: dict[tuple[str, str], list[tuple[np.ndarray, float]]] = {}
    for row in rows or tuned():
        loop = loops.get(variant(row.name, row.plant), SCENARIO, machine=row.plant)
        loop = loop.using({f"controller.{k}": v for k, v in zip(FACTORS, row.factors, strict=True)})
        done = loop.batch(HORIZON_S, runs=len(HELD_OUT), first=HELD_OUT[0], record=("feedback", "actual.force"))
        found.setdefault((row.plant, row.name), []).append((costs_of(done), row.cost))
    return {
        key: Judgement(np.array([c for c, _ in each]), float(np.mean([kept for _, kept in each])))
        for key, each in found.items()
    }


_MADE: WeakKeyDictionary[Loops, Mapping[tuple[str, str], Judgement]] = WeakKeyDictionary()


def judgement_of(loops: Loops) -> Mapping[tuple[str, str], Judgement]:
    """The judgement of the kept factors, made once for some loops: claims and pictures share it."""
    if loops not in _MADE:
        _MADE[loops] = judgement(loops)
    return _MADE[loops]
