"""Monte Carlo of the controllers: the same draws and the same noise for each of them, so they are compared in pairs.

Draw ``k`` has the noise number ``k`` under every controller. Shares come with the interval of Wilson (1927),
percentiles with that of order statistics (:mod:`leadscrew.tune.statistics`), both of 95 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.grey_fuzzy import gpfc, rule_tables
from leadscrew.controllers.grey_fuzzy.tunings import FACTORS
from leadscrew.grey.predictors import GM, LAST
from leadscrew.kernel.block import Block
from leadscrew.studies.grey_turning.ablation import FACTORS as SCALES
from leadscrew.studies.grey_turning.ablation import tuned, variant
from leadscrew.studies.grey_turning.montecarlo import COUNTS, Judged, draws, judge
from leadscrew.studies.grey_turning.runs import Loops

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop
    from leadscrew.tune.statistics import Quantile

SCENARIO = "fig6_fixed_depth"
SECONDS = 3.0
OTHER_AXES = ("ours.spindle_", "ours.depth_")
"""Controllers of the study that do not hold a force."""
TABLES = 250
"""Random rule tables."""
SCALE = 4.0
"""Their factors: those of ``sbn`` times or divided by up to this, each by itself, uniform in the logarithm."""


class Share(NamedTuple):
    """How many of how many, and the interval of the probability behind it."""

    hits: int
    of: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The share itself."""
        return self.hits / self.of

    def __str__(self) -> str:
        return f"{self.hits} of {self.of} (95 %: {100.0 * self.low:.1f} to {100.0 * self.high:.1f} %)"


def share(holds: np.ndarray) -> Share:
    """Of draws in which something holds."""
    from scipy.stats import binomtest

    hits = int(np.count_nonzero(holds))
    ends = binomtest(hits, len(holds)).proportion_ci(0.95, method="wilson")
    return Share(hits, len(holds), float(ends.low), float(ends.high))


def percentile(values: np.ndarray, percent: float) -> Quantile:
    """A percentile and its interval."""
    from leadscrew.tune.statistics import quantiles

    return quantiles(values[np.isfinite(values)], (percent,))[0]


class Compared(NamedTuple):
    """One controller against another on the same draws."""

    overshoot: Share
    """Where its overshoot is lower."""
    steady: Share
    """Where its steady error is lower."""
    all_three: Share
    """Where overshoot and steady error are lower and the rise takes no more whole samples."""
    all_three_between: Share
    """The same with rise times between samples."""
    faster: Share
    """Where the rise takes fewer whole samples."""
    iae: Share
    """Where the integral of the absolute error is lower."""
    iae_change: Quantile
    """Median change of it, percent."""
    bad: tuple[Share, Share]
    """Bad runs of the other controller and of this one."""


def compared(one: Judged, other: Judged) -> Compared:
    """``one`` against ``other``."""
    lower, steadier = one.overshoot < other.overshoot, one.steady < other.steady
    both = lower & steadier
    return Compared(
        share(lower), share(steadier), share(both & (one.rise_samples <= other.rise_samples)),
        share(both & (one.rise_s <= other.rise_s)), share(one.rise_samples < other.rise_samples),
        share(one.iae < other.iae), percentile(100.0 * (one.iae / other.iae - 1.0), 50.0),
        (share(other.bad), share(one.bad)),
    )  # fmt: skip


def told(loop: Loop, varied: Mapping[str, Any]) -> dict[str, Any]:
    """The draws of a loop; a controller that reads the programme is told the depth that is cut."""
    known = {"reference.depth.start": varied["plant.depth.start"]} if "reference.depth.start" in loop.sheet else {}
    return {**varied, **known}


def ran(loop: Loop, varied: Mapping[str, Any]) -> Judged:
    """Cuts of 3 s, judged."""
    return judge(loop.batch(SECONDS, told(loop, varied), record=("feedback",)))


def force_controllers(loops: Loops) -> tuple[str, ...]:
    """All controllers of the study that hold a force."""
    return tuple(name for name in loops.controllers if not name.startswith(OTHER_AXES))


@dataclass(eq=False)
class MonteCarlo:
    """Judged draws by controller and plant, each run once."""

    loops: Loops
    kept: dict[Any, Judged] = field(default_factory=dict)

    def of(self, controller: str, plant: str = "plant_f", count: int | None = None) -> Judged:
        """A controller of the study on the draws of a plant."""
        key = controller, plant, COUNTS[plant] if count is None else count
        if key not in self.kept:
            self.kept[key] = self.block(self.loops.controllers[controller], *key[1:])
        return self.kept[key]

    def block(self, controller: Block, plant: str, count: int | None = None) -> Judged:
        """A controller of one's own on the draws of a plant."""
        return ran(self.loops.get(controller, SCENARIO, machine=plant), draws(plant, count))

    def tuned(self, name: str, plant: str, count: int | None = None) -> Judged:
        """A variant of the ablation, at the best factors of its searches, on the draws of a plant."""
        key = f"tuned {name}", plant, count
        if key not in self.kept:
            best = min((t for t in tuned() if (t.plant, t.name) == (plant, name)), key=lambda t: t.cost)
            block = variant(name, plant)(**dict(zip(SCALES, best.factors, strict=True)))
            self.kept[key] = self.block(block, plant, count)
        return self.kept[key]

    def pair(self, one: str, other: str, plant: str = "plant_f") -> Compared:
        """A controller of the study against another."""
        return compared(self.of(one, plant), self.of(other, plant))

    def everyone(self, count: int = 300) -> dict[str, Judged]:
        """All controllers of the study that hold a force, on plant F."""
        return {name: self.of(name, "plant_f", count) for name in force_controllers(self.loops)}

    def rough(self, predictor: int, antisymmetric: bool = True) -> Judged:
        """Random rule tables with random factors on plant N under its nominal noise: TFC (0) or another predictor."""
        key = "rough", predictor, antisymmetric
        if key not in self.kept:
            loop = self.loops.get(gpfc(predictor=predictor), SCENARIO, machine="plant_n")
            self.kept[key] = judge(loop.batch(SECONDS, rough_draws(antisymmetric), record=("feedback",)))
        return self.kept[key]


def rough_draws(antisymmetric: bool = True, count: int = TABLES, seed: int = 1) -> dict[str, np.ndarray]:
    """Rule tables that err by up to one set in every rule, and factors that err by up to :data:`SCALE`."""
    tables = np.array([rule_tables.rough(seed * 10_000 + k, antisymmetric) for k in range(count)])
    off = SCALE ** np.random.default_rng(seed).uniform(-1.0, 1.0, (3, count))
    scaled = {f"controller.{k}": factor * x for k, factor, x in zip(SCALES, FACTORS["sbn"], off, strict=True)}
    return {"controller.rules": tables, **scaled}


ROUGH = {"tfc": LAST, "gpfc_b": GM}
"""Predictors that the random rules are tried with."""

_MADE: WeakKeyDictionary[Loops, dict[Any, Judged]] = WeakKeyDictionary()


def montecarlo_of(loops: Loops) -> MonteCarlo:
    """The Monte Carlo that goes with some loops: claims and pictures share its runs."""
    return MonteCarlo(loops, _MADE.setdefault(loops, {}))


def table(found: Mapping[str, Judged]) -> str:
    """Controllers as text, a line each, those with the fewest bad runs first; intervals of 95 %."""
    head = f"{'controller':<34}{'bad, %':>20}{'overshoot p50, %':>26}{'overshoot p90, %':>26}{'rise p50, s':>22}"
    rows = []
    for name, judged in sorted(found.items(), key=lambda pair: (pair[1].bad.sum(), np.median(pair[1].iae))):
        bad = share(judged.bad)
        cells = f"{100.0 * bad.value:.1f} ({100.0 * bad.low:.1f} to {100.0 * bad.high:.1f})".rjust(20)
        for values, percent, digits, width in (
            (judged.overshoot, 50.0, 1, 26), (judged.overshoot, 90.0, 1, 26), (judged.rise_s, 50.0, 2, 22),
        ):  # fmt: skip
            q = percentile(values, percent)
            cells += f"{q.value:.{digits}f} ({q.low:.{digits}f} to {q.high:.{digits}f})".rjust(width)
        rows.append(f"{name:<34}{cells}")
    return "\n".join([head, "-" * len(head), *rows])
