"""Runs of the controllers beyond the paper: entries, stairs of the depth, and what they make of wrong beliefs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.force.tunings import TUNINGS
from leadscrew.controllers.grey_fuzzy.tunings import TUNINGS as GREY_FUZZY
from leadscrew.kernel.block import Block
from leadscrew.studies.grey_turning.machines import FOLLOWING
from leadscrew.studies.grey_turning.montecarlo import FORCE_N, Judged, draws, judge
from leadscrew.studies.grey_turning.montecarlo_runs import montecarlo_of
from leadscrew.studies.grey_turning.readings import Reading, read
from leadscrew.studies.grey_turning.runs import Loops, filtered, takes_cut

SEEDS = 30
"""Noise numbers of one entry."""
STAIR_SEEDS = 10
"""The same of one staircase."""
FIRST_S = 1.9
"""The entry is over: from here on the stairs are judged."""
ENTRY, QUIET, STAIRS = "fig6_fixed_depth", "noise_free", "fig9_falling_depth"
SLOW_ENTRY = "tool_entry"
"""The edge engages within 0.4 s."""
OUTINGS = {"air": (0.0, 0.0), "air_then_cut": (0.0, 1.0), "exit": (1.0, -1.0)}
"""Programmed depth at first and what is added to it after 2 s, mm."""
RADIAL = {f"controller.{key}": value for key, value in FOLLOWING.items()}
"""The controller believes in the radial servo that is there."""

NAMES = {"tfc": "corrected.tfc_stfc", "tfc_n": "corrected.tfc_stfc_n"} | {
    name.split(".", 1)[1]: name for name in TUNINGS
}
"""Names in the study by short name."""
BLOCKS: dict[str, Block] = {short: (GREY_FUZZY | TUNINGS)[name] for short, name in NAMES.items()}
"""By short name."""


class Entry(NamedTuple):
    """Tool in the cut, feed from rest: filtered force, and the peak of the true one."""

    reading: Reading
    peak: np.ndarray
    """Percent above the command."""


class Outing(NamedTuple):
    """From 0.1 s before the change of depth on."""

    peak: float
    """Largest true force, percent above the command; -100 in the air."""
    output: float
    """Largest feed voltage."""


class Stairs(NamedTuple):
    """Worst deviations after the entry, percent of the command, mean of the seeds: filtered and true force."""

    low: float
    high: float
    true_low: float
    true_high: float
    mean: float
    """Mean absolute deviation of the filtered force after 2 s."""

    @property
    def worst(self) -> float:
        """Largest deviation of the filtered force."""
        return max(-self.low, self.high)

    @property
    def true_worst(self) -> float:
        """The same of the true one."""
        return max(-self.true_low, self.true_high)


class Cases(NamedTuple):
    """A staircase of many variants."""

    time: np.ndarray
    force: np.ndarray
    """Filtered, by variant and seed."""
    true: np.ndarray
    output: np.ndarray

    def of(self, k: int) -> Stairs:
        """The readings of one variant."""
        late = self.time >= FIRST_S
        y, f = (100.0 * (v[k][:, late] / FORCE_N - 1.0) for v in (self.force, self.true))
        settled = np.abs(self.force[k][:, self.time >= 2.0] / FORCE_N - 1.0)
        ends = [float(v.mean()) for v in (y.min(axis=1), y.max(axis=1), f.min(axis=1), f.max(axis=1))]
        return Stairs(ends[0], ends[1], ends[2], ends[3], 100.0 * float(settled.mean()))


@dataclass(eq=False)
class Beyond:
    """Runs by name, each made once."""

    loops: Loops
    _kept: dict[Any, Any] = field(default_factory=dict)

    def _once(self, key: Any, make: Any) -> Any:
        if key not in self._kept:
            self._kept[key] = make()
        return self._kept[key]

    def entry(self, name: str, machine: str = "plant_f", scenario: str = ENTRY, **changes: float) -> Entry:
        """An entry of a controller; ``changes`` of its parameters by name."""
        return self._once((name, machine, scenario, *changes.items()), lambda: self._entry(
            name, machine, scenario, changes))  # fmt: skip

    def _entry(self, name: str, machine: str, scenario: str, changes: Mapping[str, float]) -> Entry:
        loop = self.loops.get(BLOCKS[name], scenario, machine=machine)
        keyed = {f"controller.{key}": value for key, value in changes.items()}
        loop = loop.using(keyed) if keyed else loop
        count = 1 if scenario == QUIET else SEEDS
        run = loop.batch(3.0, runs=count, record=("feedback", "plant.peak"))
        return Entry(read(filtered(run)), 100.0 * (run["plant.peak"][:, -1] / FORCE_N - 1.0))

    def outing(self, name: str, what: str) -> Outing:
        """A programme with air in it (:data:`OUTINGS`), without noise and runout; the depth changes at once."""
        return self._once(("outing", name, what), lambda: self._outing(name, OUTINGS[what]))

    def _outing(self, name: str, depth: tuple[float, float]) -> Outing:
        loop = self.loops.get(BLOCKS[name], QUIET)
        programme = {"start": depth[0], "step": depth[1], "every_s": 2.0, "steps": 1}
        told = {f"{place}.depth.{key}": v for place in ("reference", "plant") for key, v in programme.items()}
        loop = loop.using({key: value for key, value in told.items() if key in loop.sheet})
        run = loop.run(4.0, record=["actual.force", "output"])
        force, output = (run[key][run.time >= FIRST_S] for key in ("actual.force", "output"))
        return Outing(round(100.0 * (float(force.max()) / FORCE_N - 1.0), 9) + 0.0, float(output.max()))

    def stairs(self, name: str, machine: str, variants: Sequence[Mapping[str, float]] = ({},)) -> Cases:
        """The falling staircase under variants of a controller's parameters; each variant names the same ones."""
        key = name, machine, tuple(tuple(v.items()) for v in variants)
        return self._once(key, lambda: self._stairs(name, machine, variants))

    def _stairs(self, name: str, machine: str, variants: Sequence[Mapping[str, float]]) -> Cases:
        loop = self.loops.get(BLOCKS[name], STAIRS, machine=machine)
        varied = {
            f"controller.{key}": np.repeat([v[key] for v in variants], STAIR_SEEDS) for key in variants[0]
        }  # fmt: skip
        believed = takes_cut(BLOCKS[name]) and machine.endswith("_radial") and "controller.radial.gain" in loop.sheet
        loop = loop.using(RADIAL) if believed else loop
        run = loop.batch(8.0, varied or None, runs=len(variants) * STAIR_SEEDS if not varied else None,
                         record=("feedback", "actual.force", "output"))  # fmt: skip
        shape = (len(variants), STAIR_SEEDS, -1)
        return Cases(run.time, *(v.reshape(shape) for v in (filtered(run), run["actual.force"], run["output"])))

    def drawn(self, name: str, plant: str = "plant_f", told: bool = True, **changes: float) -> Judged:
        """The Monte Carlo of the study; ``told``: the programme has the depth that is cut, else it says 1 mm."""
        return self._once(("drawn", name, plant, told, *changes.items()), lambda: self._drawn(
            name, plant, told, changes))  # fmt: skip

    def _drawn(self, name: str, plant: str, told: bool, changes: Mapping[str, float]) -> Judged:
        block = BLOCKS[name](**changes) if changes else BLOCKS[name]
        if told and not changes and NAMES[name] in self.loops.controllers:
            return montecarlo_of(self.loops).of(NAMES[name], plant)
        if told:
            return montecarlo_of(self.loops).block(block, plant)
        return judge(self.loops.get(block, ENTRY, machine=plant).batch(3.0, draws(plant), record=("feedback",)))


_MADE: WeakKeyDictionary[Loops, Beyond] = WeakKeyDictionary()


def beyond_of(loops: Loops) -> Beyond:
    """The runs that go with some loops: claims and pictures share them."""
    return _MADE.setdefault(loops, Beyond(loops))


def iae_change(one: Judged, other: Judged) -> float:
    """Median change of the integral of the absolute error on the same draws, percent."""
    return 100.0 * float(np.median(one.iae / other.iae - 1.0))


def high(found: Judged) -> float:
    """90th percentile of the overshoot, percent."""
    return float(np.percentile(found.overshoot, 90.0))


PREVIEWS_S = (0.0, 0.04, 0.065, 0.09)
TRIED: tuple[dict[str, float], ...] = (
    *({"preview_s": p, "exponent": 0.77, "depth_error": 0.0} for p in PREVIEWS_S),
    {"preview_s": 0.065, "exponent": 0.70, "depth_error": 0.0},
    {"preview_s": 0.065, "exponent": 0.85, "depth_error": 0.0},
    {"preview_s": 0.065, "exponent": 0.77, "depth_error": 0.05},
)
"""Variants of the depth feed-forward: four previews, two wrong exponents, a wrong depth."""
BEST, LATE = 2, 0
WRONG = (4, 5, 6)
AT_ONCE = ({"preview_s": 0.065},)
