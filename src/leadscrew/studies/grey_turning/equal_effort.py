"""What a predictor is worth when every controller is tuned with the same effort.

Each variant is the fuzzy controller of the paper with another prediction in reading B, tuned by itself: the factors
S1, S2, S3 in the logarithm between :data:`LOW` and :data:`HIGH`, CMA-ES from the middle of that box, :data:`BUDGET`
evaluations, three seeds of the search, on two noise seeds that are the same for every candidate. The cost of a cut of
2 s at 150 N, with the true force F and the filtered force y at the samples,

    J = 1/2 sum t |F - r| T + 1/2 sum t |y - r| T + 0.5 N s^2 for each percent of overshoot of y above 1 %

in N s^2. 1 % is the overshoot that noise alone makes; the weight and the 2 s are ours, and :data:`COSTS` has others.
The factors that were found are kept in ``data/ablation_factors.csv`` and, under the other costs for three variants, in
``data/ablation_costs.csv``; :func:`search` finds them again, six digits alike on the same versions of CMA-ES and NumPy.
:func:`judged` runs them under :data:`HELD_OUT` noise seeds that no search saw. Intervals are over these: they hold for
the factors that were found, and say nothing of another choice of the two noise seeds of the search.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.controllers._grey_fuzzy import gpfc
from leadscrew.controllers._grey_fuzzy.smith import smith
from leadscrew.kernel.block import Block, sensor
from leadscrew.kernel.noise import Noise
from leadscrew.kernel.parameters import Doc, Ge
from leadscrew.sensors._load_cell import LoadCellParams, LoadCellState, weighed
from leadscrew.studies.grey_turning.readings import filtered
from leadscrew.studies.grey_turning.scenarios import FORCE_N
from leadscrew.studies.grey_turning.tunings import SMITH_N
from leadscrew.studies.lab import Lab, measure

FREE = 1.0
"""Percent of overshoot that cost nothing."""


class Cost(NamedTuple):
    """What a controller is tuned for and judged by."""

    horizon_s: float = 2.0
    """Length of the cut."""
    penalty: float = 0.5
    """N s^2 for each percent of overshoot above :data:`FREE`."""


COSTS = {
    "": Cost(),
    "short": Cost(horizon_s=1.5),
    "long": Cost(horizon_s=3.0),
    "overshoot": Cost(penalty=5.0),
}
"""The cost, and three more by name: a shorter cut, a longer one, ten times the penalty on overshoot."""

FACTORS = ("error_scale", "change_scale", "output_scale")
LOW = (2.0, 0.5, 0.0005)
HIGH = (400.0, 100.0, 0.2)
"""The box of the search: S1 in N, S2 in N a sample, S3 in V."""
BUDGET = 600
"""Evaluations of a search."""
TUNED_ON = (0, 1)
"""Noise seeds of the search."""
HELD_OUT = tuple(range(1000, 1040))
"""Noise seeds of the judgement."""
PLANTS = ("plant_f", "plant_n")
SCENARIO = "fig6_fixed_depth"

VARIANTS: dict[str, dict[str, Any]] = {
    "tfc": {"predictor": "last"},
    "gpfc_b": {"predictor": "gm11"},
    "line": {"predictor": "line"},
    "two_point": {"predictor": "two_point"},
    "gm_h2": {"predictor": "gm11_guarded", "horizon": 2.0},
    "dgm": {"predictor": "dgm11"},
    "gpfc_a": {"predictor": "gm11", "reading": "measured_error"},
    "exponential": {"predictor": "gm11_exponential"},
    "residual": {"predictor": "gm11_residual"},
    "verhulst": {"predictor": "verhulst"},
}
"""Parameters of the GPFC, by default reading B; with the last value as prediction it is the TFC."""
SWITCHES = ("predictor", "reading", "horizon")
"""Parameters by which they differ."""
SMITH = "smith"
NAMES = (*VARIANTS, SMITH)
PREDICTORS = {
    "gpfc_b": "GM(1,1)",
    "line": "line through four samples",
    "two_point": "line through two samples",
    "gm_h2": "GM(1,1), two samples ahead",
    "dgm": "DGM(1,1)",
    "gpfc_a": "GM(1,1), reading A",
    "exponential": "GM(1,1), exact rate",
    "residual": "GM(1,1) with a model of its residuals",
    "verhulst": "Verhulst",
    "smith": "Smith predictor",
}
"""The variants but the TFC, as they are written."""
RECORDED = ("feedback", "actual.force")
DATA = Path(__file__).parent / "data"


def variant(name: str, plant: str) -> Block:
    """The controller of a variant on a plant, its factors not yet tuned."""
    if name == SMITH:
        return smith.using(**(SMITH_N if plant == "plant_n" else {}))
    return gpfc(**({"reading": "predicted_error"} | VARIANTS[name]))


class RepeatedCellParams(NamedTuple):
    """A load cell, and which noise it has."""

    cell: LoadCellParams = LoadCellParams()
    which: Annotated[int, Ge(0), Doc("number of the run whose noise this is")] = 0


@sensor(RepeatedCellParams(), LoadCellState(), unit="N")
def repeated_cell(p, s, actual, noise):
    """The load cell with the noise of the run ``which``: candidates beside each other can have the same noise."""
    now = weighed(p.cell, s, actual.force, Noise(noise.seed, p.which, noise.block, noise.period))
    return now, now.force


def costs(t: np.ndarray, force: np.ndarray, y: np.ndarray, cost: Cost) -> np.ndarray:
    """J of the true and the filtered force, one row a run, of samples before the end of the cost's cut."""
    period = t[1] - t[0]
    within = t < cost.horizon_s - 0.5 * period
    off = np.abs(force - FORCE_N) + np.abs(y - FORCE_N)
    itae = 0.5 * period * (t[within] * off[:, within]).sum(axis=1)
    overshoot = 100.0 * (y[:, within].max(axis=1) / FORCE_N - 1.0)
    return np.asarray(itae + cost.penalty * np.maximum(overshoot - FREE, 0.0))


def costs_of(batch: Any, cost: Cost) -> np.ndarray:
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


def search(lab: Lab, plant: str, name: str, seed: int, budget: int = BUDGET, under: str = "") -> Tuned:
    """One search: the same plant, variant, seed, budget and cost give the same factors."""
    from leadscrew.tune.optimisers import OPTIMISERS, Answer, Search

    loop, cost = lab.loop(variant(name, plant), SCENARIO, machine=plant, sensor=repeated_cell), COSTS[under]
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

    OPTIMISERS["cma"][0](Search(evaluate, np.full(3, 0.5), budget, seed))
    s1, s2, s3 = (float(x) for x in best[1])
    return Tuned(plant, name, seed, (s1, s2, s3), best[0])


def tuned(under: str = "") -> list[Tuned]:
    """What the searches found under a cost, as kept."""
    file = DATA / ("ablation_costs.csv" if under else "ablation_factors.csv")
    with file.open(newline="", encoding="utf-8") as text:
        rows = [row for row in csv.DictReader(text) if row.get("under", "") == under]
    found = []
    for row in rows:
        s1, s2, s3 = (float(row[key]) for key in ("s1", "s2", "s3"))
        found.append(Tuned(row["plant"], row["variant"], int(row["search"]), (s1, s2, s3), float(row["cost"])))
    return found


def lowest(rows: Sequence[Tuned]) -> list[Tuned]:
    """Of each plant and variant the search that ended lowest."""
    best: dict[tuple[str, str], Tuned] = {}
    for row in rows:
        key = row.plant, row.name
        best[key] = min(best.get(key, row), row, key=lambda each: each.cost)
    return list(best.values())


class Judgement(NamedTuple):
    """J of one variant on one plant, in N s^2."""

    held_out: np.ndarray
    """``(searches, noise seeds)``, on noise that no search has seen."""
    trained: float
    """Mean over the searches of J on the noise that they were tuned on."""

    @property
    def mean(self) -> float:
        """Over searches and noise seeds."""
        return float(self.held_out.mean())


Judged = dict[tuple[str, str], Judgement]
"""By plant and variant."""


class Difference(NamedTuple):
    """Change of J against another variant in the same noise, percent of the other's, with a 95 % interval."""

    percent: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.percent:+.1f} % (95 %: {self.low:+.1f} to {self.high:+.1f} %)"


def difference(one: Judgement, other: Judgement) -> Difference:
    """Paired over noise seeds, the mean of the searches for each; Student's interval."""
    from scipy.stats import ttest_1samp

    change = 100.0 * (one.held_out.mean(axis=0) - other.held_out.mean(axis=0)) / other.mean
    ends = ttest_1samp(change, 0.0).confidence_interval(0.95)
    return Difference(float(change.mean()), float(ends.low), float(ends.high))


def judgement(lab: Lab, rows: Sequence[Tuned], cost: Cost) -> Judged:
    """Every variant that was tuned, on the held-out noise and on that of the search; one batch a plant and a law."""
    noise = (*TUNED_ON, *HELD_OUT)
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for plant, smiths in sorted({(row.plant, row.name == SMITH) for row in rows}):
        mine = [row for row in rows if (row.plant, row.name == SMITH) == (plant, smiths)]
        blocks = [variant(row.name, plant) for row in mine]
        varied = {f"controller.{f}": [row.factors[i] for row in mine] for i, f in enumerate(FACTORS)}
        if not smiths:
            varied |= {f"controller.{f}": [getattr(b.params, f) for b in blocks] for f in SWITCHES}
        each = {key: np.repeat(values, len(noise)) for key, values in varied.items()}
        loop = lab.loop(blocks[0], SCENARIO, machine=plant, sensor=repeated_cell)
        done = loop.batch(cost.horizon_s, each | {"sensor.which": np.tile(noise, len(mine))}, record=RECORDED)
        for row, price in zip(mine, costs_of(done, cost).reshape(len(mine), -1), strict=True):
            found.setdefault((plant, row.name), []).append(price)
    seen = len(TUNED_ON)
    return {
        key: Judgement(np.array([p[seen:] for p in prices]), float(np.mean([p[:seen].mean() for p in prices])))
        for key, prices in found.items()
    }


@measure
def judged(lab: Lab, under: str = "") -> Judged:
    """The kept factors under a cost; of the other costs the lowest search of each variant."""
    rows = tuned(under)
    return judgement(lab, lowest(rows) if under else rows, COSTS[under])


def against(lab: Lab, name: str, plant: str, other: str = "tfc", under: str = "") -> Difference:
    """Change of J of a variant against another on a plant."""
    found = judged(lab, under)
    return difference(found[plant, name], found[plant, other])
