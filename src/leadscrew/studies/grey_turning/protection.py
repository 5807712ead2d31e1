"""The guard on the raw force and on the load cell: hard spots at 1 ms resolution, load cells that break.

The guard (:mod:`leadscrew.controllers._guard`) stands around the force controller and takes the voltage from the drive
where the raw force passes 180 N. A look is one reading that it judges: every 20 ms with the controller, or every
millisecond.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from leadscrew.controllers._guard import HOLDING, RUNNING, Clock, force_guard
from leadscrew.disturbances._hard_spot import hard_spot
from leadscrew.grey.vectorised import ahead, fit
from leadscrew.grey.window import LENGTH
from leadscrew.sensors._faulty_load_cell import faulty_load_cell
from leadscrew.studies.grey_turning.scenarios import FORCE_N, PERIOD_S, SLOW
from leadscrew.studies.grey_turning.tunings import FACTORS, TUNINGS
from leadscrew.studies.lab import Lab, measure

TFC = TUNINGS["corrected.tfc_stfc"]
FAST = force_guard(TFC, clock=Clock(every=20))
SLOW_GUARD = force_guard(TFC)
LEVEL_N = FAST.params.levels.hold_n
SPOT_S, PHASES = 2.5, 20
"""When the spots begin: the entry is over; and over how many milliseconds their begin is varied."""
SEEN = ("feedback.raw", "actual.force", "actual.feed", "output", "controller.guard.mode", "controller.filtered")
OFF: dict[str, float] = {
    "controller.levels.hold_n": 1e7, "controller.levels.reduce_n": 1e6, "controller.cell.range_n": 1e7,
    "controller.cell.still_s": 0.0, "controller.cell.rise": 0.0, "controller.cell.below_n": 1e7,
    "controller.air.air_v": 1e7,
}  # fmt: skip
"""No guard: levels that nothing reaches."""


class Case(NamedTuple):
    """One kind of run of the hard spots."""

    machine: str
    factors: str
    looks: int
    """Milliseconds between two looks."""
    guarded: bool = True


CASES = {
    "plant F, a look every 20 ms": Case("plant_f", "stfc", 20),
    "plant F, a look every 1 ms": Case("plant_f", "stfc", 1),
    "plant N, a look every 20 ms": Case("plant_n", "sbn", 20),
    "plant N, a look every 1 ms": Case("plant_n", "sbn", 1),
    "plant F, no guard": Case("plant_f", "stfc", 20, guarded=False),
}


def changes_of(case: Case) -> dict[str, Any]:
    """Parameters by key."""
    sizes = FACTORS[case.factors]
    servo = SLOW if case.machine == "plant_n" else {"servo.rate": 40.0, "servo.dead_time_s": 0.0}
    scales = {f"controller.inner.{key}_scale": value for key, value in sizes._asdict().items()}
    plant = {f"plant.{key}": value for key, value in servo.items()}
    return scales | plant | {"controller.clock.looks": case.looks} | ({} if case.guarded else OFF)


class Spots(NamedTuple):
    """Runs through a hard spot, rows by phase of the sampling."""

    run: Any
    start: np.ndarray
    """First index of the spot."""
    dead_ms: float
    """Dead time of the drive behind the guard."""

    def crossed(self) -> np.ndarray:
        """Index at which the raw force first exceeds the guard's level from the spot on; -1 where it never does."""
        return _first(self.run["feedback.raw"] > LEVEL_N, self.start)

    def held(self) -> np.ndarray:
        """Index at which the feed is held; -1 where it never is."""
        return _first(self.run["controller.guard.mode"] > RUNNING, self.start)

    def late_ms(self) -> np.ndarray:
        """From the raw force's crossing to 0 V at the drive; NaN without a hold."""
        held = self.held()
        return np.where(held < 0, np.nan, held - self.crossed() + self.dead_ms)

    def slowed_ms(self, share: float) -> np.ndarray:
        """From the crossing until the axis has this share of its feed left."""
        feed, held, crossed = self.run["actual.feed"], self.held(), self.crossed()
        return np.array([float(np.argmax(f[h:] < share * f[h]) + h - c) if min(h, c) >= 0 else math.nan
                         for f, h, c in zip(feed, held, crossed, strict=True)])  # fmt: skip

    def peak(self) -> np.ndarray:
        """Largest true force from 0.1 s before the spots on, percent of the set-point."""
        return np.asarray(self.run["actual.force"][:, round(1e3 * SPOT_S) - 100 :].max(axis=1) / (0.01 * FORCE_N))

    def back(self, within_n: float = 5.0) -> np.ndarray:
        """Whether the filtered force is back at its set-point in the last 0.5 s, the guard running."""
        late = np.abs(self.run["controller.filtered"][:, -500:] - FORCE_N).max(axis=1)
        return np.asarray((late < within_n) & (self.run["controller.guard.mode"][:, -1] == RUNNING))


def _first(rows: np.ndarray, start: np.ndarray) -> np.ndarray:
    return np.array([int(np.argmax(row[k:])) + k if row[k:].any() else -1 for row, k in zip(rows, start, strict=True)])


@measure
def spots(lab: Lab, case: str) -> Spots:
    """A spot that doubles the force within 40 ms and stays 0.2 s, at twenty phases of the sampling."""
    chosen = CASES[case]
    loop = lab.loop(FAST, "fig6_fixed_depth", period=1e-3, substeps=1, metrics={}, disturbance=hard_spot)
    start = SPOT_S + 1e-3 * np.arange(PHASES)
    run = loop.using(changes_of(chosen) | {"disturbance.stay_s": 0.2}).batch(
        4.6, {"disturbance.start": start}, record=SEEN, first=PHASES * list(CASES).index(case)
    )
    dead = 1e3 * SLOW["servo.dead_time_s"] if chosen.machine == "plant_n" else 0.0
    return Spots(run, np.round(1e3 * start).astype(int), dead)


HORIZONS = (1, 2, 3, 5)


@measure
def seen_ms(lab: Lab) -> dict[str, np.ndarray]:
    """Without guard, from the spot's beginning until a signal, sampled every 20 ms, exceeds 180 N; a value a phase."""
    found = spots(lab, "plant F, no guard")
    y = found.run["controller.filtered"][:, ::20]
    windows = np.lib.stride_tricks.sliding_window_view(y, LENGTH, axis=1)
    model = fit(windows)
    signals = {"raw force": found.run["feedback.raw"][:, ::20], "filtered force": y}
    for h in HORIZONS:
        unknown = np.zeros((len(y), LENGTH - 1))
        signals[f"GM(1,1), {h} ahead"] = np.hstack([unknown, ahead(windows, model, float(h))])
    first = -(-found.start // 20)
    return {name: 20.0 * _first(signal > LEVEL_N, first) - found.start for name, signal in signals.items()}


# ---- load cells that break
class Fault(NamedTuple):
    """A load cell that breaks."""

    kind: str
    size_n: float


FAULTS = {
    "shows 0 N": Fault("constant", 0.0),
    "saturated above": Fault("saturated", 1000.0),
    "saturated below": Fault("saturated", -1000.0),
    "error code": Fault("error_code", 8388607.0),
    "jump of 400 N": Fault("jump", 400.0),
    "reversed polarity": Fault("wrong_scale", -1.0),
    "dead: noise about 0": Fault("dead", 0.0),
    "jump of −120 N": Fault("jump", -120.0),
    "half the scale": Fault("wrong_scale", 0.5),
    "0.3 of the scale": Fault("wrong_scale", 0.3),
    "drift of −20 N/s": Fault("drift", -20.0),
    "drift of −2 N/s": Fault("drift", -2.0),
    "frozen at 75 N": Fault("frozen", 75.0),
    "frozen at 135 N": Fault("frozen", 135.0),
    "frozen at 150 N": Fault("frozen", 150.0),
}
BROKEN_S = (0.1, 1.5)
"""When it breaks: in the entry, in the steady cut."""
WATCHED_S = 60.0


class Broken(NamedTuple):
    """Columns by the moment at which the fault comes."""

    held_s: np.ndarray
    """From the fault to the hold; infinite without."""
    feed: np.ndarray
    """Largest feed after it, mm/min."""
    force: np.ndarray
    """Largest true force after it, N."""


@measure
def broken(lab: Lab) -> dict[str, Broken]:
    """The guarded loop of 20 ms with every fault, in the entry and in the steady cut."""
    loop = lab.loop(SLOW_GUARD, "fig6_fixed_depth", sensor=faulty_load_cell, metrics={})
    changes = {
        "sensor.fault": np.repeat([f.kind for f in FAULTS.values()], len(BROKEN_S)),
        "sensor.size_n": np.repeat([f.size_n for f in FAULTS.values()], len(BROKEN_S)),
        "sensor.from_s": np.tile(BROKEN_S, len(FAULTS)),
    }
    run = loop.batch(WATCHED_S, changes, record=("actual.feed", "actual.force", "controller.guard.mode"))
    shape = len(FAULTS), len(BROKEN_S)
    after = run.time >= changes["sensor.from_s"][:, None] - 0.5 * PERIOD_S
    held = (run["controller.guard.mode"] >= HOLDING) & after
    late = np.where(held.any(axis=1), run.time[held.argmax(axis=1)] - changes["sensor.from_s"], math.inf)
    feed, force = (np.where(after, run[f"actual.{s}"], 0.0).max(axis=1) for s in ("feed", "force"))
    rows = zip(*(part.reshape(shape) for part in (late, feed, force)), strict=True)
    return {name: Broken(*row) for name, row in zip(FAULTS, rows, strict=True)}
