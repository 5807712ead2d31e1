"""The paper's experiments run again: each case under many noise seeds, side by side.

A case is a set of scaling factors under one law: the traditional fuzzy controller (TFC) or the grey-prediction one
(GPFC), reading B or A of the predicted change, with another predictor where it says so. Cases of one law differ in
values alone, so they are one batch of one compiled loop. Run ``k`` of a batch has noise of its own: what is added to a
group of cases changes the noise of those behind it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from leadscrew.controllers._grey_fuzzy.gpfc import gpfc
from leadscrew.controllers._grey_fuzzy.rule_tables import TABLES, rough
from leadscrew.grey.predictors import GM, LAST
from leadscrew.studies.grey_turning.readings import Reading, SeedMean, filtered, read, seed_mean
from leadscrew.studies.grey_turning.scenarios import FALLING, FOLLOWING, FORCE_N, PERIOD_S, SCENARIOS, SLOW
from leadscrew.studies.grey_turning.tunings import FACTORS, Factors
from leadscrew.studies.lab import Lab, measure

SEEDS = 30
SIGNALS = ("feedback", "output", "actual.force", "actual.feed")

LAWS: dict[str, dict[str, str]] = {
    "tfc": {},
    "b": {"predictor": "gm11_clamped", "reading": "predicted_error"},
    "a": {"predictor": "gm11_clamped", "reading": "measured_error"},
    "two_point": {"predictor": "two_point", "reading": "predicted_error"},
    "off_by_one": {"predictor": "gm11_off_by_one", "reading": "predicted_error"},
    "printed": {"predictor": "gm11_printed", "reading": "predicted_error"},
}
"""What makes a law of the GPFC; the TFC is a block of its own."""
WORDS = {"tfc": "TFC", "b": "GPFC", "a": "GPFC, reading A", "two_point": "two-point predictor"}
BOTH = ("tfc", "b")
WRITTEN = {"s6": "S6", "s9": "S9", "s9_half": "S9/2", "stfc": "STFC", "sbn": "SBN, plant N", "edge_n": "edge, plant N"}
"""Scaling factors of :data:`~leadscrew.studies.grey_turning.tunings.FACTORS`."""

PLANT_N = {f"plant.{key}": value for key, value in SLOW.items()}
QUIET: dict[str, Any] = {"sensor.noise_n": 0.0, "plant.runout": 0.0}
FOLLOWED = {f"plant.{key}": value for key, value in FOLLOWING.items()}
"""The depth follows its programme as the depth loop of the lathe makes it."""
STAIRS: dict[str, Any] = {f"plant.depth.{key}": value for key, value in FALLING._asdict().items()}


class Case(NamedTuple):
    """Factors, law, and what else differs from plant F with 2 N of noise."""

    factors: Factors
    law: str = "tfc"
    changes: Mapping[str, Any] = {}

    def values(self) -> dict[str, Any]:
        """Parameters by dotted key."""
        law = {f"controller.{key}": value for key, value in LAWS[self.law].items()}
        scales = {f"controller.{key}_scale": value for key, value in self.factors._asdict().items()}
        return law | scales | dict(self.changes)


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

    @property
    def reading(self) -> Reading:
        """Of the filtered force."""
        return read(self.y)

    @property
    def overshoot(self) -> SeedMean:
        """Of the filtered force, %."""
        return seed_mean(self.reading.overshoot)

    @property
    def true_overshoot(self) -> SeedMean:
        """Of the true force, %."""
        return seed_mean(read(self.force).overshoot)

    @property
    def rise_s(self) -> SeedMean:
        """In whole samples, as it is read off a plot, s."""
        return seed_mean(PERIOD_S * self.reading.rise_samples)

    def steady(self, window: tuple[float, float] | None = None) -> SeedMean:
        """Mean size of the error in a window, else in the last second, %."""
        return seed_mean(read(self.y, window=window).steady)

    def activity(self, signal: str, since: float, until: float) -> float:
        """Mean change of ``u`` or ``feed`` a sample from ``since`` to ``until`` s, over all seeds."""
        part = getattr(self, signal)[:, round(since / PERIOD_S) : round(until / PERIOD_S)]
        return float(np.abs(np.diff(part, axis=1)).mean())

    def highest(self, since: float, until: float) -> SeedMean:
        """Largest filtered force of a window, % above the set-point."""
        part = self.y[:, round(since / PERIOD_S) : round(until / PERIOD_S)]
        return seed_mean(100.0 * (part.max(axis=1) / FORCE_N - 1.0))

    def until(self, seconds: float) -> Cuts:
        """The first part."""
        n = round(seconds / PERIOD_S)
        return Cuts(*(signal[:, :n] for signal in self))


def together(
    lab: Lab,
    cases: Mapping[str, Case],
    seconds: float,
    seeds: int = SEEDS,
    scenario: str = "fig6_fixed_depth",
    **options: Any,
) -> dict[str, Cuts]:
    """Runs the cases under ``seeds`` noise seeds each; one batch for the TFC, one for the GPFC."""
    found: dict[str, Cuts] = {}
    for named, is_tfc in (("corrected.tfc_s6", True), ("corrected.gpfc_b_s6", False)):
        mine = {name: case.values() for name, case in cases.items() if (case.law == "tfc") == is_tfc}
        if not mine:
            continue
        loop = lab.loop(named, scenario, **options)
        keys = dict.fromkeys(key for row in mine.values() for key in row)
        values = {key: np.array([row.get(key, loop.parameters[key]) for row in mine.values()]) for key in keys}
        done = loop.batch(
            seconds, {key: np.repeat(each, seeds, axis=0) for key, each in values.items()}, record=SIGNALS
        )
        parts = [np.asarray(done[signal]).reshape(len(mine), seeds, -1) for signal in SIGNALS]
        found |= {name: Cuts(*(part[i] for part in parts)) for i, name in enumerate(mine)}
    return {name: found[name] for name in cases}


def _each(name: str, factors: str | Factors, laws: tuple[str, ...], changes: Mapping[str, Any]) -> dict[str, Case]:
    sizes = FACTORS[factors] if isinstance(factors, str) else factors
    return {f"{name}_{law}": Case(sizes, law, changes) for law in laws}


EDGE_NOISE = {**PLANT_N, "sensor.noise_n": 1.0}
"""Plant N with 1 N of noise, where 5.1's steady errors come back."""
WEAK = {"controller.rules": TABLES["weak_ec"]}


def edge(share: float) -> Factors:
    """The factors at the edge of a limit cycle, with the loop gain off by a share."""
    return FACTORS["edge_n"]._replace(output=share * FACTORS["edge_n"].output)


LONG = {**_each("s6", "s6", BOTH, {}), **_each("s9", "s9", BOTH, {}), **_each("stfc", "stfc", BOTH, {})}
LONG_S, JUDGED_S = 4.0, 3.0
"""How long these cuts are; where the axes of Figures 6 and 7 end, and what is judged by default."""
OTHERS = {
    **_each("s6", "s6", ("a",), {}),
    **_each("s9", "s9", ("two_point",), {}),
    **_each("sg", "sg", ("b",), {}),
    **_each("s6n", "s6n", (*BOTH, "off_by_one"), PLANT_N),
    **_each("sbn", "sbn", (*BOTH, "off_by_one"), PLANT_N),
    **_each("edge", "edge_n", (*BOTH, "a"), EDGE_NOISE),
    **_each("edge_low", edge(0.9), BOTH, EDGE_NOISE),
    **_each("edge_high", edge(1.1), BOTH, EDGE_NOISE),
    **_each("weak", "s9", (*BOTH, "a"), WEAK),
    **_each("rough", "rough", BOTH, {}),
}


@measure
def long(lab: Lab) -> dict[str, Cuts]:
    """Cuts of 4 s at 1 mm."""
    return together(lab, LONG, LONG_S)


@measure
def others(lab: Lab) -> dict[str, Cuts]:
    """Cuts of 3 s at 1 mm."""
    return together(lab, OTHERS, JUDGED_S)


def fixed(lab: Lab, name: str) -> Cuts:
    """A case of :data:`LONG` or :data:`OTHERS`, 3 s of it."""
    return long(lab)[name].until(JUDGED_S) if name in LONG else others(lab)[name]


@measure
def quiet(lab: Lab) -> dict[str, Cuts]:
    """Without noise and runout, one run a case, 3 s."""
    names = ("s6", "s9", "stfc", "sg")
    cases = {k: v for name in names for k, v in _each(name, name, (*BOTH, "printed"), QUIET).items()}
    return together(lab, cases, JUDGED_S, 1)


FALL = {
    f"{name}_{law}{suffix}": Case(FACTORS[name], law, STAIRS | {"plant.depth.steps": 4} | depth)
    for name in ("s9", "s6")
    for law in BOTH
    for suffix, depth in (("", FOLLOWED), ("_at_once", {}))
}
FALL_S, FALL_SEEDS = 10.0, 12
CHANGES_S = (2.0, 4.0, 6.0, 8.0)
"""When the depth falls: to 0.8, 0.6, 0.4 and 0.2 mm."""


@measure
def fall(lab: Lab) -> dict[str, Cuts]:
    """The depth falls four times, by 0.2 mm each, as the depth loop moves it or at once."""
    return together(lab, FALL, FALL_S, FALL_SEEDS)


@measure
def without_and_with_falls(lab: Lab) -> dict[str, Cuts]:
    """TFC with S6 and S9, 8 s without noise: the depth stays, or falls three times."""
    programmes = {"fixed": QUIET, "falls": QUIET | STAIRS | FOLLOWED}
    cases = {f"{n}_{p}": Case(FACTORS[n], "tfc", changes) for n in ("s6", "s9") for p, changes in programmes.items()}
    return together(lab, cases, 8.0, 1)


# ---- Figure 5
SCATTER_N = 8.0
"""Noise of the load cell as Figure 5 shows it."""


@measure
def figure_5(lab: Lab, seeds: int = 1, feed_held: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Raw and filtered force of a feedback that scatters as Figure 5's, rows a seed, N; 6 s, TFC with S6."""
    held = {"controller.lower": 35.5 / 150.0, "controller.output_scale": 1e-30, "plant.runout": 0.0}
    loop = lab.loop("corrected.tfc_s6", "fig5_feedback")
    done = (loop.using(held) if feed_held else loop).batch(
        6.0, {"controller.upper": np.ones(seeds)}, record=("sensor",)
    )
    return np.asarray(done["sensor.raw"]), np.asarray(done["sensor.force"])


@measure
def raw_or_filtered(lab: Lab) -> dict[tuple[float, float], Cuts]:
    """TFC with S6 by noise in N and coefficient of the filter; 3 s."""
    at = [(noise, keep) for noise in (2.0, SCATTER_N) for keep in (0.0, 0.8)]
    cases = {f"{n}_{k}": Case(FACTORS["s6"], "tfc", {"sensor.noise_n": n, "sensor.keep": k}) for n, k in at}
    return dict(zip(at, together(lab, cases, 3.0).values(), strict=True))


@measure
def product_or_minimum(lab: Lab, factors: str, inference: str, seeds: int = 20) -> float:
    """Mean change of the TFC's voltage a sample, 2 to 4 s, mV."""
    loop = lab.loop(f"corrected.tfc_{factors}", "fig6_fixed_depth").using({"controller.inference": inference})
    u = np.asarray(loop.batch(4.0, {"controller.upper": np.ones(seeds)}, record=("output",))["output"])[:, 100:]
    return float(1e3 * np.abs(np.diff(u, axis=1)).sum(axis=1).mean() / round(2.0 / PERIOD_S))


# ---- Figure 11: rough rules and factors
GRID_FACTORS = ("s6", "s9", "s9_half", "stfc", "sg")
GRID_SEEDS = 4


class Grid(NamedTuple):
    """Rule tables with factor sets: rows by table, columns by factors, by law."""

    overshoot: dict[str, np.ndarray]
    steady: dict[str, np.ndarray]
    rise_s: dict[str, np.ndarray]

    def bad(self, law: str) -> np.ndarray:
        """Steady error above 5 % or overshoot above 30 %."""
        return np.asarray((self.steady[law] > 5.0) | (self.overshoot[law] > 30.0))


@measure
def grid(lab: Lab) -> Grid:
    """All rule tables with all factor sets, 3 s."""
    cases = {
        f"{table}/{name}/{law}": Case(FACTORS[name], law, {"controller.rules": TABLES[table]})
        for table in TABLES
        for name in GRID_FACTORS
        for law in BOTH
    }
    seen = {name: cuts.reading for name, cuts in together(lab, cases, JUDGED_S, GRID_SEEDS).items()}

    def judged(what: str) -> dict[str, np.ndarray]:
        return {
            law: np.array([[getattr(seen[f"{t}/{f}/{law}"], what).mean() for f in GRID_FACTORS] for t in TABLES])
            for law in BOTH
        }

    return Grid(judged("overshoot"), judged("steady"), judged("rise_s"))


RANDOM_TABLES = 250
SCALE = 4.0
"""Their factors: those of ``sbn`` times or divided by up to this, each by itself, uniform in the logarithm."""


def rough_draws(count: int = RANDOM_TABLES, seed: int = 1) -> dict[str, np.ndarray]:
    """Rule tables that err by up to one set in every rule, and factors that err by up to :data:`SCALE`."""
    tables = np.array([rough(seed * 10_000 + k) for k in range(count)])
    off = SCALE ** np.random.default_rng(seed).uniform(-1.0, 1.0, (3, count))
    pairs = zip(FACTORS["sbn"]._asdict().items(), off, strict=True)
    return {"controller.rules": tables, **{f"controller.{key}_scale": value * x for (key, value), x in pairs}}


@measure
def rough_rules(lab: Lab, law: str) -> Reading:
    """Random rule tables with random factors on plant N; without prediction the GPFC is the TFC."""
    loop = lab.loop(gpfc(predictor={"tfc": LAST, "b": GM}[law]), "fig6_fixed_depth", machine="plant_n")
    return read(loop.batch(3.0, rough_draws(), record=("feedback",))["feedback"])


# ---- every scenario
class Condition(NamedTuple):
    """A scenario in which the laws are compared."""

    scenario: str
    own: tuple[str, str] = ("stfc", "sg")
    """Factors tuned for TFC and for GPFC on its machine."""


CONDITIONS: dict[str, Condition] = {
    "fixed depth": Condition("fig6_fixed_depth"),
    "falling depth": Condition("fig9_falling_depth"),
    "rising depth": Condition("rising_depth"),
    "raw force fed back": Condition("raw_force"),
    "iron": Condition("fixed_depth_on_plant_f_iron"),
    "tool enters within 0.4 s": Condition("tool_entry"),
    "plant N": Condition("fixed_depth_on_plant_n", ("stfc_n", "sbn")),
    "no noise, no runout": Condition("noise_free"),
}
OURS = "ours.constant_force"


class Row(NamedTuple):
    """One law in one scenario; of the force that the controller gets, and of the true one."""

    overshoot: SeedMean
    rise: SeedMean
    steady: SeedMean
    true: float

    @classmethod
    def of(cls, y: np.ndarray, force: np.ndarray) -> Row:
        """The row of filtered and true forces."""
        seen = read(y)
        overshoot, rise, steady = (seed_mean(values) for values in (seen.overshoot, seen.rise_s, seen.steady))
        return cls(overshoot, rise, steady, float(read(force).overshoot.mean()))


@measure
def rows_of(lab: Lab, condition: str, seeds: int = 20) -> dict[str, Row]:
    """The six fuzzy laws and ours in one scenario: S6, S9, and each with its own factors."""
    chosen = CONDITIONS[condition]
    scenario = SCENARIOS[chosen.scenario]
    runs = seeds if scenario.params.noise_n > 0.0 else 1
    cases = {
        f"{law}_{name}": Case(FACTORS[factors], law)
        for name, pair in (("s6", ("s6", "s6")), ("s9", ("s9", "s9")), ("own", chosen.own))
        for law, factors in zip(BOTH, pair, strict=True)
    }
    found = {
        name: Row.of(cuts.y, cuts.force)
        for name, cuts in together(lab, cases, scenario.duration_s, runs, chosen.scenario).items()
    }
    run = lab.loop(OURS, chosen.scenario).batch(
        scenario.duration_s, {}, runs=runs, record=("feedback.force", "actual.force")
    )
    return {**found, "ours": Row.of(filtered(run), run["actual.force"])}


SHOWN = {"overshoot": 0.1, "rise": PERIOD_S, "steady": 0.05}
"""A smaller difference counts as none: %, one sample, %."""


def better(one: SeedMean, other: SeedMean, least: float) -> int:
    """1 where ``one`` is smaller by more than three standard errors of the difference, -1 where larger, else 0."""
    apart = other.mean - one.mean
    doubt = max(3.0 * float(np.hypot(one.spread / one.seeds**0.5, other.spread / other.seeds**0.5)), least)
    return int(apart > doubt) - int(apart < -doubt)


def compared(rows: Mapping[str, Row], factors: str) -> dict[str, int]:
    """GPFC against TFC with the same factors (or each with its own): 1 better, 0 undecided, -1 worse."""
    b, tfc = rows[f"b_{factors}"], rows[f"tfc_{factors}"]
    return {what: better(getattr(b, what), getattr(tfc, what), least) for what, least in SHOWN.items()}
