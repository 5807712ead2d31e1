"""The paper's experiments run again: each case under many noise seeds, side by side, with what they are judged by.

A case is a set of scaling factors under one law: the traditional fuzzy controller (TFC) or the grey-prediction one
(GPFC), reading B or A, with another predictor where it says so. Cases of the same law differ in values alone, so they
are one batch of one compiled loop. Run ``k`` of a case has noise of its own; what is told of a case is a mean of seeds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from leadscrew.controllers.grey_fuzzy.gpfc import READING_A, READING_B
from leadscrew.controllers.grey_fuzzy.rule_tables import TABLES
from leadscrew.controllers.grey_fuzzy.tunings import FACTORS, Factors
from leadscrew.grey.predictors import GM_CLAMPED, OFF_BY_ONE, PRINTED, TWO_POINT
from leadscrew.studies.grey_turning.machines import PERIOD_S, SLOW
from leadscrew.studies.grey_turning.readings import read
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.scenarios import FALLING

FORCE_N = 150.0
SEEDS = 30
"""Noise seeds of a case, as in the digest."""
SIGNALS = ("feedback", "output", "actual.force", "actual.feed")

LAWS: dict[str, dict[str, int]] = {
    "tfc": {},
    "b": {"predictor": GM_CLAMPED, "reading": READING_B},
    "a": {"predictor": GM_CLAMPED, "reading": READING_A},
    "two_point": {"predictor": TWO_POINT, "reading": READING_B},
    "off_by_one": {"predictor": OFF_BY_ONE, "reading": READING_B},
    "printed": {"predictor": PRINTED, "reading": READING_B},
}
"""What makes a law of the GPFC; the TFC is a block of its own."""
WORDS = {"tfc": "TFC", "b": "GPFC (B)", "a": "GPFC (A)", "two_point": "two-point predictor in B"}

PLANT_N = {f"plant.{key}": value for key, value in SLOW.items()}
QUIET: dict[str, Any] = {"sensor.noise_n": 0.0, "plant.runout": 0.0}
FOLLOWED: dict[str, Any] = {"plant.radial.gain": 8.57}
"""The depth follows its programme in 0.25 s, as the depth loop of the lathe does."""
STAIRS: dict[str, Any] = {f"plant.depth.{key}": value for key, value in FALLING._asdict().items()}


class Case(NamedTuple):
    """Factors, law, and what else differs from plant F with 2 N of noise."""

    factors: str | Factors
    law: str = "tfc"
    changes: Mapping[str, Any] = {}


class Cuts(NamedTuple):
    """The runs of a case, a row a seed."""

    y: np.ndarray
    """Filtered force, N."""
    u: np.ndarray
    """Feed voltage, V."""
    force: np.ndarray
    """True force, N."""
    feed: np.ndarray
    """mm/min."""
    period: float = PERIOD_S

    @property
    def overshoot(self) -> np.ndarray:
        """Of the filtered force, %."""
        return np.asarray(read(self.y, FORCE_N, period=self.period).overshoot)

    @property
    def rise_s(self) -> np.ndarray:
        """From the first sample at 10 % to the first at 90 %, s."""
        return self.period * ((self.y >= 0.9 * FORCE_N).argmax(axis=1) - (self.y >= 0.1 * FORCE_N).argmax(axis=1))

    def steady(self, window: tuple[float, float] | None = None) -> np.ndarray:
        """Mean size of the error in a window, else in the last second, % of the set-point."""
        return np.asarray(read(self.y, FORCE_N, window, self.period).steady)

    def activity_mv(self, since: float, until: float) -> np.ndarray:
        """Mean change of the voltage a sample from ``since`` to ``until`` s, mV."""
        a, b = round(since / self.period), round(until / self.period)
        return np.asarray(1e3 * np.abs(np.diff(self.u[:, a:b], axis=1)).mean(axis=1))

    def extreme(self, since: float, until: float, least: bool) -> np.ndarray:
        """Least or largest filtered force of a window, % from the set-point."""
        part = self.y[:, round(since / self.period) : round(until / self.period)]
        found = part.min(axis=1) if least else part.max(axis=1)
        return np.asarray(100.0 * (found / FORCE_N - 1.0))


class Told(NamedTuple):
    """A mean over seeds."""

    mean: float
    spread: float
    """Standard deviation of one seed."""
    seeds: int

    def tolerance(self, digit: float, others: int = SEEDS) -> float:
        """Three standard errors of the difference to a mean of ``others`` seeds, and half of its last digit."""
        return 3.0 * self.spread * math.sqrt(1.0 / self.seeds + 1.0 / others) + 0.5 * digit


def told(values: np.ndarray) -> Told:
    """The mean of one value a seed."""
    return Told(float(values.mean()), float(values.std(ddof=1)) if values.size > 1 else 0.0, int(values.size))


def factors_of(case: Case) -> Factors:
    """The scaling factors of a case."""
    return FACTORS[case.factors] if isinstance(case.factors, str) else case.factors


def _values(case: Case) -> dict[str, Any]:
    f = factors_of(case)
    law = {f"controller.{key}": value for key, value in LAWS[case.law].items()}
    scales = {f"controller.{key}_scale": value for key, value in f._asdict().items()}
    return law | scales | dict(case.changes)


def _default(loop: Any, key: str) -> Any:
    block, *path = key.split(".")
    found = loop.blocks[block].params
    for part in path:
        found = getattr(found, part)
    return found


def together(
    loops: Loops,
    cases: Mapping[str, Case],
    seconds: float,
    seeds: int = SEEDS,
    scenario: str = "fig6_fixed_depth",
    **options: Any,
) -> dict[str, Cuts]:
    """Runs the cases under ``seeds`` noise seeds each; one batch for the TFC, one for the GPFC."""
    found: dict[str, Cuts] = {}
    for block in ("tfc", "gpfc"):
        mine = {name: case for name, case in cases.items() if (case.law == "tfc") == (block == "tfc")}
        if not mine:
            continue
        named = "corrected.tfc_s6" if block == "tfc" else "corrected.gpfc_b_s6"
        loop = loops.get(named, scenario, **options)
        rows = [_values(case) for case in mine.values()]
        keys = {key: None for row in rows for key in row}
        many = {
            key: np.repeat(np.array([row.get(key, _default(loop, key)) for row in rows]), seeds, axis=0) for key in keys
        }
        done = loop.batch(seconds, many, record=SIGNALS)
        parts = [np.asarray(done[signal]).reshape(len(mine), seeds, -1) for signal in SIGNALS]
        for i, name in enumerate(mine):
            y, u, force, feed = (part[i] for part in parts)
            found[name] = Cuts(y, u, force, feed, loop.period)
    return found


EDGE_NOISE = {**PLANT_N, "sensor.noise_n": 1.0}
"""Plant N with 1 N of noise, where 5.1's steady errors come back."""
WEAK = {"controller.rules": TABLES["weak_ec"]}


def edge(share: float) -> Factors:
    """The factors at the edge of a limit cycle, with the loop gain off by a share."""
    return FACTORS["edge_n"]._replace(output=share * FACTORS["edge_n"].output)


def _both(name: str, factors: str | Factors, laws: tuple[str, ...], changes: Mapping[str, Any]) -> dict[str, Case]:
    return {f"{name}_{law}": Case(factors, law, changes) for law in laws}


FIXED: dict[str, Case] = {
    **_both("s6", "s6", ("tfc", "b", "a"), {}),
    **_both("s9", "s9", ("tfc", "b", "two_point"), {}),
    **_both("stfc", "stfc", ("tfc", "b"), {}),
    **_both("sg", "sg", ("b",), {}),
    **_both("s6n", "s6n", ("tfc", "b", "off_by_one"), PLANT_N),
    **_both("sbn", "sbn", ("tfc", "b", "off_by_one"), PLANT_N),
    **_both("edge", "edge_n", ("tfc", "b", "a"), EDGE_NOISE),
    **_both("edge_low", edge(0.9), ("tfc", "b"), EDGE_NOISE),
    **_both("edge_high", edge(1.1), ("tfc", "b"), EDGE_NOISE),
    **_both("weak", "s9", ("tfc", "b", "a"), WEAK),
    **_both("rough", "rough", ("tfc", "b"), {}),
}
"""Cuts of 3 s at 1 mm; section 6 of the digest."""
JUDGED_S = 3.0
"""Where the paper's axis of Figures 6 and 7 ends; what is judged ends there unless told otherwise."""

LONG = ("s6_tfc", "s6_b", "s9_tfc", "s9_b", "stfc_tfc", "stfc_b")
LONG_S = 4.0
"""Cuts whose fourth second is judged too."""

FALL: dict[str, Case] = {
    f"{name}_{law}{suffix}": Case(name, law, STAIRS | {"plant.depth.steps": 4} | depth)
    for name in ("s9", "s6")
    for law in ("tfc", "b")
    for suffix, depth in (("", FOLLOWED), ("_at_once", {}))
}
FALL_S = 10.0
FALL_SEEDS = 12
CHANGES_S = (2.0, 4.0, 6.0, 8.0)
"""When the depth falls: to 0.8, 0.6, 0.4 and 0.2 mm."""


class Grid(NamedTuple):
    """Rule tables and factor sets, each pair with and without prediction."""

    tables: tuple[str, ...]
    factors: tuple[str, ...]
    overshoot: dict[str, np.ndarray]
    """By law: rows by table, columns by factors; %."""
    steady: dict[str, np.ndarray]
    rise_s: dict[str, np.ndarray]
    """NaN where 90 % is not reached."""

    def bad(self, law: str) -> np.ndarray:
        """Steady error above 5 % or overshoot above 30 %, as in the digest's Monte Carlo."""
        return np.asarray((self.steady[law] > 5.0) | (self.overshoot[law] > 30.0))


GRID_FACTORS = ("s6", "s9", "s9_half", "stfc", "sg")
GRID_SEEDS = 4


class Reproduction:
    """Runs that claims and pictures share, each made once."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops

    @cached_property
    def long(self) -> dict[str, Cuts]:
        """The cases of :data:`LONG`, 4 s."""
        return together(self.loops, {name: FIXED[name] for name in LONG}, LONG_S)

    @cached_property
    def fixed(self) -> dict[str, Cuts]:
        """All cases of :data:`FIXED`, 3 s."""
        n = round(JUDGED_S / PERIOD_S)
        others = {name: case for name, case in FIXED.items() if name not in LONG}
        return {
            **{name: Cuts(c.y[:, :n], c.u[:, :n], c.force[:, :n], c.feed[:, :n]) for name, c in self.long.items()},
            **together(self.loops, others, JUDGED_S),
        }

    @cached_property
    def quiet(self) -> dict[str, Cuts]:
        """Without noise and runout, one run a case, 3 s."""
        cases = {
            f"{name}_{law}": Case(name, law, QUIET)
            for name in ("s6", "s9", "stfc", "sg")
            for law in ("tfc", "b", "printed")
        }
        return together(self.loops, cases, JUDGED_S, 1)

    @cached_property
    def fall(self) -> dict[str, Cuts]:
        """The cases of :data:`FALL`."""
        return together(self.loops, FALL, FALL_S, FALL_SEEDS)

    @cached_property
    def grid(self) -> Grid:
        """All rule tables with all factor sets, 3 s."""
        cases = {
            f"{table}/{name}/{law}": Case(name, law, {"controller.rules": TABLES[table]})
            for table in TABLES
            for name in GRID_FACTORS
            for law in ("tfc", "b")
        }
        cuts = together(self.loops, cases, JUDGED_S, GRID_SEEDS)

        def judged(law: str, what: Any) -> np.ndarray:
            return np.array([[float(what(cuts[f"{t}/{f}/{law}"]).mean()) for f in GRID_FACTORS] for t in TABLES])

        laws = ("tfc", "b")
        return Grid(
            tuple(TABLES), GRID_FACTORS,
            {law: judged(law, lambda c: c.overshoot) for law in laws},
            {law: judged(law, lambda c: c.steady()) for law in laws},
            {law: judged(law, lambda c: read(c.y, FORCE_N).rise_s) for law in laws},
        )  # fmt: skip
