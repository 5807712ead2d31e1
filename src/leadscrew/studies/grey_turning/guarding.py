"""Runs of the guard: hard spots at 1 ms resolution, load cells that break, and holds for nothing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers.grey_fuzzy.tunings import FACTORS, TUNINGS
from leadscrew.controllers.guard import HOLDING, RUNNING, Clock, force_guard
from leadscrew.controllers.guard.watching import UNANSWERED
from leadscrew.disturbances.hard_spot import hard_spot
from leadscrew.grey.gm11 import ahead, fit
from leadscrew.grey.window import Window
from leadscrew.references.cutting_program import CutCommand
from leadscrew.sensors.faulty_load_cell import KINDS, faulty_load_cell
from leadscrew.sensors.load_cell import CutReading
from leadscrew.studies.grey_turning.machines import PERIOD_S, SLOW
from leadscrew.studies.grey_turning.montecarlo import draws
from leadscrew.studies.grey_turning.runs import Loops, build
from leadscrew.studies.grey_turning.scenarios import SCENARIOS

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

FORCE_N = 150.0
TFC = TUNINGS["corrected.tfc_stfc"]
FAST = force_guard(TFC, clock=Clock(every=20))
SLOW_GUARD = force_guard(TFC)
SPOT_S = 2.5
"""When the spots of the phases begin: the entry is over."""
SEEN = ("feedback.raw", "actual.force", "actual.feed", "output", "controller.guard.mode", "controller.filtered")

QUIET, QUIET_S = 4, 24.0
"""Runs without spots, and how long each is."""

OFF: dict[str, float] = {
    "controller.levels.hold_n": 1e7, "controller.levels.reduce_n": 1e6, "controller.cell.range_n": 1e7,
    "controller.cell.still_s": 0.0, "controller.cell.rise": 0.0, "controller.cell.below_n": 1e7,
    "controller.air.air_v": 1e7,
}  # fmt: skip
"""No guard: levels that nothing reaches."""
LEVELS_OFF = {key: value for key, value in OFF.items() if "levels" in key or "range" in key}
"""Checks of the load cell alone."""


class Case(NamedTuple):
    """One kind of run of the hard spots."""

    machine: str
    factors: str
    looks: int
    guarded: bool = True


LONG_S = 1.0
"""How long the spot stays in the last case: its peak is the digest's."""

CASES = (
    Case("plant_f", "stfc", 20), Case("plant_f", "stfc", 1), Case("plant_n", "sbn", 20), Case("plant_n", "sbn", 1),
    Case("plant_f", "stfc", 20, False), Case("plant_n", "stfc", 20, False),
)  # fmt: skip
"""The last two without guard."""


def fast_loop(loops: Loops) -> Loop:
    """A loop of 1 ms whose inner controller runs every 20 ms; the guard looks in each ``controller.clock.looks``-th."""
    scenario = SCENARIOS["fig6_fixed_depth"]
    return build(FAST, scenario, period=1e-3, substeps=1, metrics={}, disturbance=hard_spot)


def changes_of(cases: list[Case]) -> dict[str, np.ndarray]:
    """Parameters by key, a value a run."""
    sizes = [FACTORS[c.factors] for c in cases]
    servo = [SLOW if c.machine == "plant_n" else {} for c in cases]
    plain = FAST.params
    found: dict[str, Any] = {
        "controller.inner.error_scale": [f.error for f in sizes],
        "controller.inner.change_scale": [f.change for f in sizes],
        "controller.inner.output_scale": [f.output for f in sizes],
        "controller.clock.looks": [c.looks for c in cases],
        "plant.servo.rate": [s.get("servo.rate", 40.0) for s in servo],
        "plant.servo.dead_time_s": [s.get("servo.dead_time_s", 0.0) for s in servo],
    }
    for key, value in OFF.items():
        part, name = key.split(".")[1:]
        found[key] = [getattr(getattr(plain, part), name) if c.guarded else value for c in cases]
    return {key: np.array(values) for key, values in found.items()}


class Spots(NamedTuple):
    """Runs through a hard spot, rows by run."""

    run: Any
    cases: list[Case]
    start: np.ndarray
    """First index of the spot."""

    def of(self, case: Case) -> np.ndarray:
        """The rows of a case."""
        return np.array([k for k, c in enumerate(self.cases) if c == case])

    def crossed(self, level: float = 180.0) -> np.ndarray:
        """Index at which the raw force first exceeds the level from the spot on; -1 where it never does."""
        return _first(self.run["feedback.raw"] > level, self.start)

    def held(self) -> np.ndarray:
        """Index at which the feed is held; -1 where it never is."""
        return _first(self.run["controller.guard.mode"] > RUNNING, self.start)

    def early(self) -> np.ndarray:
        """Whether the feed was held before the spot came."""
        held = self.run["controller.guard.mode"] > RUNNING
        return np.array([bool(row[:k].any()) for row, k in zip(held, self.start, strict=True)])

    def slowed(self, share: float) -> np.ndarray:
        """Milliseconds from the crossing until the axis has this share of its feed left."""
        feed, held, crossed = self.run["actual.feed"], self.held(), self.crossed()
        return np.array([float(np.argmax(f[h:] < share * f[h]) + h - c) if min(h, c) >= 0 else math.nan
                         for f, h, c in zip(feed, held, crossed, strict=True)])  # fmt: skip

    def back(self, within_n: float = 5.0) -> np.ndarray:
        """Whether the filtered force is back at its set-point in the last 0.5 s, the guard running."""
        late = np.abs(self.run["controller.filtered"][:, -500:] - FORCE_N).max(axis=1)
        return (late < within_n) & (self.run["controller.guard.mode"][:, -1] == RUNNING)


def _first(rows: np.ndarray, start: np.ndarray) -> np.ndarray:
    return np.array([int(np.argmax(row[k:])) + k if row[k:].any() else -1 for row, k in zip(rows, start, strict=True)])


def doubling(loops: Loops, seconds: float = 4.6) -> Spots:
    """A spot that doubles the force within 40 ms and stays 0.2 s, at twenty phases of the sampling, for each case."""
    cases = [c for c in CASES for _ in range(20)]
    start = np.tile(SPOT_S + 1e-3 * np.arange(20), len(CASES))
    stay = np.array([LONG_S if c == CASES[5] else 0.2 for c in cases])
    changes = changes_of(cases) | {"disturbance.start": start, "disturbance.stay_s": stay}
    run = fast_loop(loops).batch(seconds, changes, record=SEEN)
    return Spots(run, cases, np.round(1e3 * start).astype(int))


def drawn(loops: Loops, count: int = 60, seconds: float = 4.0, seed: int = 9) -> tuple[Spots, dict[str, np.ndarray]]:
    """Spots of 1.3 to 3 times the force, at random times, in noise of 0.5 to 5 N: each seen at 20 ms and at 1 ms."""
    rng = np.random.default_rng(seed)
    one = {"disturbance.size": rng.uniform(0.3, 2.0, count), "disturbance.start": rng.uniform(1.5, 2.0, count),
           "sensor.noise_n": rng.uniform(0.5, 5.0, count)}  # fmt: skip
    both = {key: np.tile(value, 2) for key, value in one.items()}
    cases = [case for case in CASES[:2] for _ in range(count)]
    run = fast_loop(loops).batch(seconds, changes_of(cases) | both, record=SEEN)
    return Spots(run, cases, np.round(1e3 * both["disturbance.start"]).astype(int)), both


class Steps(NamedTuple):
    """Milliseconds from the spot's beginning until a signal, sampled every 20 ms, exceeds 180 N: a value a run."""

    raw: np.ndarray
    filtered: np.ndarray
    grey: dict[int, np.ndarray]
    first_n: np.ndarray
    """GM(1,1), five periods ahead, at the first sample after the beginning, N."""
    second_n: np.ndarray
    """The filtered force at the second, N."""


def sampled_crossings(loops: Loops, runs: int = 40, level: float = 180.0) -> Steps:
    """The unguarded loop, the spot beginning with a sample: what would see it when."""
    free = CASES[4]
    start = SPOT_S + PERIOD_S * (np.arange(runs) % 5)
    changes = changes_of([free] * runs) | {"disturbance.start": start, "disturbance.stay_s": np.full(runs, 1.0)}
    run = fast_loop(loops).batch(3.0, changes, record=SEEN)
    raw, filtered, grey = [], [], {h: [] for h in (1, 2, 3, 5)}  # type: ignore[var-annotated]
    first, second = [], []
    for k, begin in enumerate(np.round(1e3 * start).astype(int)):
        y = run["controller.filtered"][k, ::20]
        at = begin // 20
        raw.append(20 * int(np.argmax(run["feedback.raw"][k, begin::20] > level)))
        filtered.append(20 * int(np.argmax(y[at:] > level)))
        windows = [_window(y[at + n - 4 : at + n + 1].tolist()) for n in range(5)]
        for h, found in grey.items():
            found.append(20 * next((n for n, w in enumerate(windows) if ahead(w, fit(w), float(h)) > level), 99))
        first.append(ahead(windows[1], fit(windows[1]), 5.0))
        second.append(y[at + 2])
    return Steps(np.array(raw), np.array(filtered), {h: np.array(v) for h, v in grey.items()}, np.array(first),
                 np.array(second))  # fmt: skip


def _window(samples: list[float]) -> Window:
    y0, y1, y2, y3, y4 = samples
    return Window(y0, y1, y2, y3, y4, 5)


class Fault(NamedTuple):
    """A load cell that breaks."""

    name: str
    kind: str
    size_n: float


FAULTS = (
    Fault("constant", "constant", 0.0), Fault("saturated above", "saturated", 1000.0),
    Fault("saturated below", "saturated", -1000.0), Fault("error code", "error code", 8388607.0),
    Fault("jump of 400 N", "jump", 400.0), Fault("reversed polarity", "wrong scale", -1.0), Fault("dead", "dead", 0.0),
    Fault("jump of -120 N", "jump", -120.0), Fault("half the scale", "wrong scale", 0.5),
    Fault("0.3 of the scale", "wrong scale", 0.3), Fault("drift of -20 N/s", "drift", -20.0),
    Fault("drift of -2 N/s", "drift", -2.0),
)  # fmt: skip
"""The first six are to hold the feed, a dead one to get the feed of air at most, the rest is not seen in time."""
HELD, BROKEN_S = 6, (0.1, 1.5)


class Broken(NamedTuple):
    """Rows by fault, columns by the moment at which it comes (:data:`BROKEN_S`)."""

    held_ms: np.ndarray
    """From the fault to the hold; NaN without."""
    feed: np.ndarray
    """Largest feed after it, mm/min."""
    kept: np.ndarray
    """Whether the feed is held at the end."""
    force: np.ndarray
    """Largest true force after it, N."""
    end_feed: np.ndarray
    """Mean feed of the last second, mm/min."""
    end_force: np.ndarray
    """Mean true force of the last second, N."""


def broken(loops: Loops, seconds: float = 60.0) -> Broken:
    """The guarded loop of 20 ms with every fault, in the entry and in the steady cut."""
    scenario = SCENARIOS["fig6_fixed_depth"]
    loop = build(SLOW_GUARD, scenario, sensor=faulty_load_cell, metrics={})
    count = len(FAULTS)
    changes = {
        "sensor.fault": np.repeat([KINDS[f.kind] for f in FAULTS], 2),
        "sensor.size_n": np.repeat([f.size_n for f in FAULTS], 2),
        "sensor.from_s": np.tile(BROKEN_S, count),
    }
    run = loop.batch(seconds, changes, record=("actual.feed", "actual.force", "output", "controller.guard.mode"))
    held_ms, feed, kept, force, end_feed, end_force = (np.full((count, 2), math.nan) for _ in range(6))
    for k in range(2 * count):
        at = round(float(changes["sensor.from_s"][k]) / PERIOD_S)
        mode = run["controller.guard.mode"][k, at:]
        place = divmod(k, 2)
        held = bool((mode >= HOLDING).any())
        held_ms[place] = 1e3 * PERIOD_S * int(np.argmax(mode >= HOLDING)) if held else math.nan
        kept[place] = float(mode[-1] >= HOLDING)
        feed[place], force[place] = run["actual.feed"][k, at:].max(), run["actual.force"][k, at:].max()
        end_feed[place], end_force[place] = run["actual.feed"][k, -50:].mean(), run["actual.force"][k, -50:].mean()
    return Broken(held_ms, feed, kept, force, end_feed, end_force)


FROZEN_AT = (0.2, 0.5, 0.7, 0.9, 0.95, 0.99, 1.0, 1.1, 1.3)
"""Levels that a cell freezes at, in parts of the set-point."""
FROZEN_NOISE = (0.2, 0.5, 1.0, 2.0)


class Frozen(NamedTuple):
    """Rows by level, columns by noise and then by moment; 60 s after it."""

    held_s: np.ndarray
    """From the fault to the hold; NaN without."""
    feed: np.ndarray
    """Largest feed after it, mm/min."""
    end_feed: np.ndarray
    """Mean feed of the last second, mm/min."""


def frozen(loops: Loops, seconds: float = 60.0, changes: dict[str, Any] | None = None) -> Frozen:
    """The guarded loop of 20 ms, its cell standing at a level under noise, from the entry or the steady cut on."""
    loop = build(SLOW_GUARD, SCENARIOS["fig6_fixed_depth"], sensor=faulty_load_cell, metrics={})
    shape = len(FROZEN_AT), len(FROZEN_NOISE) * 2
    level, noise, from_s = (v.ravel() for v in np.meshgrid(FROZEN_AT, FROZEN_NOISE, BROKEN_S, indexing="ij"))
    rows = {"sensor.fault": np.full(level.size, KINDS["frozen"]), "sensor.size_n": FORCE_N * level,
            "sensor.lathe.noise_n": noise, "sensor.from_s": from_s}  # fmt: skip
    run = loop.using(changes or {}).batch(seconds, rows, record=("actual.feed", "controller.guard.mode"))
    after = run.time >= from_s[:, None] - 0.5 * PERIOD_S
    held = (run["controller.guard.mode"] >= HOLDING) & after
    late = np.where(held.any(axis=1), run.time[held.argmax(axis=1)] - from_s, math.nan)
    feed = np.where(after, run["actual.feed"], 0.0).max(axis=1)
    return Frozen(late.reshape(shape), feed.reshape(shape), run["actual.feed"][:, -50:].mean(axis=1).reshape(shape))


SOUND = {"plant_f": ("stfc", "s6", "sg"), "plant_n": ("sbn", "s6n", "sg")}
"""Factors of the sound cuts of the Monte Carlo."""
SOUND_STEPS = (0.0, -0.2, 0.2)
"""The depth's change every 2 s, in parts of the drawn one: fixed, falling, rising."""


def doubted(loops: Loops, count: int = 10) -> tuple[int, int]:
    """Cuts with a sound cell in which the check of the answer holds the feed, of how many: draws of the Monte Carlo."""
    hits = total = 0
    for plant, names in SOUND.items():
        varied = draws(plant, count)
        loop = build(SLOW_GUARD, SCENARIOS["fig6_fixed_depth"], machine=plant, metrics={})
        for name, step in ((n, s) for n in names for s in SOUND_STEPS):
            sizes, start = FACTORS[name], varied["plant.depth.start"]
            own = {"controller.inner.error_scale": sizes.error, "controller.inner.change_scale": sizes.change,
                   "controller.inner.output_scale": sizes.output, "plant.depth.every_s": 2.0,
                   "plant.depth.steps": 3 if step else 0, "controller.cell.jump_n": 1e7} | LEVELS_OFF  # fmt: skip
            run = loop.using(own).batch(
                8.0 if step else 3.0,
                varied | {"plant.depth.step": step * start, "reference.depth.start": start},
                record=("controller.guard.cause",),
            )
            hits += int((run["controller.guard.cause"] == UNANSWERED).any(axis=1).sum())
            total += count
    return hits, total


def nan_holds(command: bool = False) -> bool:
    """Whether NaN or infinity in any field of reading (or command) gives output 0 in that step, and a finite state."""
    params = SLOW_GUARD.prepare(SLOW_GUARD.params, PERIOD_S) if SLOW_GUARD.prepare else SLOW_GUARD.params
    asked, sound = CutCommand(FORCE_N, 1.0, 1.0), CutReading(FORCE_N, FORCE_N, 1.0, 20.0)
    begun = SLOW_GUARD.align(params, asked, sound, 0.24) if SLOW_GUARD.align else SLOW_GUARD.state
    good = []
    for field in (CutCommand if command else CutReading)._fields:
        for bad in (math.nan, math.inf, -math.inf):
            state, output = SLOW_GUARD.step(params, begun, asked, sound, PERIOD_S)
            told = asked._replace(**{field: bad}) if command else asked
            shown = sound if command else sound._replace(**{field: bad})
            after, held = SLOW_GUARD.step(params, state, told, shown, PERIOD_S)
            good.append(output > 0.2 and held == 0.0 and all(math.isfinite(x) for x in _numbers(after)))
    return all(good)


def _numbers(value: Any) -> list[float]:
    return [x for part in value for x in (_numbers(part) if isinstance(part, tuple) else [float(part)])]


def for_nothing(
    loops: Loops, noise: tuple[float, ...] = (2.0, 5.0, 8.0), runs: int = QUIET, seconds: float = QUIET_S
) -> Any:
    """Holds in cuts without a spot: rows noise; columns looks every 20 ms, every 1 ms, and these thrice confirmed."""
    cases = [case for _ in noise for case in (*CASES[:2], CASES[1]) for _ in range(runs)]
    full = np.ones(len(cases))
    changes = changes_of(cases) | {
        "disturbance.size": 0.0 * full, "sensor.noise_n": np.repeat(noise, 3 * runs),
        "controller.levels.confirm": np.tile(np.repeat([1, 1, 3], runs), len(noise)),
        "controller.recover.forget_s": 1e9 * full, "controller.recover.retries": (1000 * full).astype(int),
    }  # fmt: skip
    run = fast_loop(loops).batch(seconds, changes, record=("controller.guard.holds",), every=1000)
    return run["controller.guard.holds"][:, -1].reshape(len(noise), 3, runs).sum(axis=2)


def entry_trips(loops: Loops) -> tuple[int, int]:
    """Holds of the guard in 3 s of fixed depth, by the controllers fitted to 5.2 and the well-tuned one."""
    cases = [Case("plant_f", "s9", 20), Case("plant_f", "stfc", 20)]
    run = fast_loop(loops).batch(
        3.0, changes_of(cases) | {"disturbance.size": np.zeros(2)}, record=("controller.guard.holds",), every=10
    )
    found = run["controller.guard.holds"].max(axis=1)
    return int(found[0]), int(found[1])
