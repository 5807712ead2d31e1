"""Runs in which something changes: the material on the way, the shear in a step, the feed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.comparison import BILINEAR, FIXED, NONE, PAPER, PID, TUNED
from leadscrew.studies.sofnn_tangent.lines import FEED, LAPS, PERIOD_S, samples_of
from leadscrew.studies.sofnn_tangent.online import rules
from leadscrew.studies.sofnn_tangent.runs import CELLS, SEED, Loops
from leadscrew.studies.study import Scenario

ROWS = (NONE, FIXED, PAPER, TUNED, PID)
"""Controllers of the table of the changed material."""
RUNS = 2 * CELLS
"""Runs of a line: the first :data:`CELLS` are judged, all say how much runs differ."""


class Halves(NamedTuple):
    """Deviation before and after a change of material, deg, a run each."""

    before: np.ndarray
    """RMS."""
    after: np.ndarray
    """RMS."""
    most: np.ndarray
    """Largest after the change."""

    def judged(self) -> tuple[float, float, float]:
        """Means of the judged runs."""
        return tuple(float(part[:CELLS].mean()) for part in self)  # type: ignore[return-value]

    def spread(self) -> tuple[float, float, float]:
        """Standard deviations from run to run."""
        return tuple(float(part.std(ddof=1)) for part in self)  # type: ignore[return-value]


def halves(loops: Loops, controller: str, line: str) -> Halves:
    """A line whose second half is cut in foam, :data:`RUNS` times."""
    scenario = loops.asked(f"{line}_change")
    loop = loops.get(controller, scenario).using(seed=SEED)
    size = np.full(RUNS, scenario.params.texture_deg)
    batch = loop.batch(scenario.duration_s, {"disturbance.size": size}, record=("actual.deviation",))
    samples = samples_of(scenario.name)
    e = batch["actual.deviation"][:, 1 : samples + 1]
    half = math.ceil(scenario.params.change_share * samples)
    first, second = e[:, :half], e[:, half:]
    return Halves(np.sqrt(np.mean(first**2, axis=1)), np.sqrt(np.mean(second**2, axis=1)), np.abs(second).max(axis=1))


class Settled(NamedTuple):
    """Answer to a step of the shear."""

    iae: float
    """deg s, from the step on."""
    settling_s: float
    """Until the deviation stays within :data:`BAND_DEG`; infinite where it never does."""
    overshoot: float
    """Deviation to the other side, deg."""
    last: float
    """Deviation at the end, deg."""
    e: np.ndarray


STEP_AT_S = 0.5
BAND_DEG = 0.25
REPEATS = 4


def answer(e: np.ndarray) -> Settled:
    """What is read off the deviations of a run with a negative step at :data:`STEP_AT_S`."""
    after = e[round(STEP_AT_S / PERIOD_S) :]
    outside = np.flatnonzero(np.abs(after) > BAND_DEG)
    settled = 0.0 if not len(outside) else (outside[-1] + 1) * PERIOD_S
    settled = math.inf if len(outside) and outside[-1] == len(after) - 1 else settled
    return Settled(float(np.abs(after).sum() * PERIOD_S), settled, float(after.max()), float(after[-1]), e)


def steps(loops: Loops, block: Block, repeats: int = REPEATS) -> list[Settled]:
    """The same step again and again; a network keeps its rules and their covariance, everything else starts anew."""
    scenario = loops.asked("step")
    found = []
    for _ in range(repeats):
        live = loops.get(block, scenario, changes={"disturbance.step_at": STEP_AT_S}).start()
        run = live.advance(live.loop.periods(scenario.duration_s + PERIOD_S), record=("actual.deviation",))
        found.append(answer(run["actual.deviation"][1:]))
        if hasattr(block.state, "covariance"):
            state = rules(live)
            block = block.starting(weights=state.weights, covariance=state.covariance)
    return found


FEEDS = (20.0, 50.0, 100.0)
"""mm/s"""
FEED_ROWS = (NONE, BILINEAR, TUNED, PID)


def at_feed(loops: Loops, feed: float, line: str = "flower", material: str = "fabric") -> Scenario:
    """A scenario cut at another feed; the camera stays as late as it is, in time."""
    scenario = loops.asked(f"{line}_{material}")
    seconds = (samples_of(scenario.name, feed) + 1) * PERIOD_S
    return replace(scenario, params=scenario.params._replace(feed=feed), duration_s=seconds)


def feed_values(controller: str) -> Mapping[str, float]:
    """What a controller of :data:`FEED_ROWS` has differently when the feed changes."""
    return {"delay": 6} if controller == BILINEAR else {}


def with_values(words: str, values: Mapping[str, float]) -> str:
    """Words for a controller, and behind them the parameters that it has differently here."""
    return ", ".join([words, *(f"{key} {float(x):g}" for key, x in values.items())])


def fed(loops: Loops, controller: str, feed: float, by_sample: bool = False) -> np.ndarray:
    """RMS deviation of the flower in fabric at a feed, deg, :data:`RUNS` runs; m_c = 6 where the table corrects.

    ``by_sample``: the texture changes from sample to sample as at 50 mm/s, whatever the feed; else along the way.
    """
    scenario = at_feed(loops, feed)
    block = loops.controllers[controller](**feed_values(controller))
    loop = loops.get(block, scenario).using(seed=SEED)
    length = scenario.params.texture_mm * (feed / FEED if by_sample else 1.0)
    batch = loop.batch(scenario.duration_s, {"disturbance.length": np.full(RUNS, length)})
    return np.asarray(batch.metrics["rms_error"])


@dataclass(frozen=True)
class Changes:
    """All of them."""

    material: Mapping[tuple[str, str], Halves]
    """By controller and line."""
    step: Mapping[str, list[Settled]]
    """By a short name of the controller."""
    feed: Mapping[tuple[str, float], np.ndarray]
    """By controller and feed."""
    slow_by_sample: np.ndarray
    """The tuned network at the lowest feed in a texture by the sample."""


STEP_CONTROLLERS = {"fixed": FIXED, "table": BILINEAR, "net": PAPER, "tuned": TUNED, "pid": PID}
"""Controllers that meet the step, by a short name."""
STEP_VALUES: Mapping[str, Mapping[str, float]] = {
    "table": {"delay": 6}, "net": {"delay": 6}, "tuned": {"leak": 0.0, "freeze": False},
}  # fmt: skip
"""What they have differently there: the literal networks refer back by the camera's delay and the axis's, six samples,
and the tuned one neither leaks nor freezes, as in the digest."""


def step_blocks(loops: Loops) -> dict[str, Block]:
    """Controllers that meet the step."""
    return {short: loops.controllers[name](**STEP_VALUES.get(short, {})) for short, name in STEP_CONTROLLERS.items()}


_MADE: WeakKeyDictionary[Loops, Changes] = WeakKeyDictionary()


def changes_of(loops: Loops) -> Changes:
    """All runs, made once for some loops."""
    if loops not in _MADE:
        material = {(name, line): halves(loops, name, line) for name in ROWS for line in LAPS}
        step: dict[str, Any] = {short: steps(loops, block) for short, block in step_blocks(loops).items()}
        feed = {(name, value): fed(loops, name, value) for name in FEED_ROWS for value in FEEDS}
        _MADE[loops] = Changes(material, step, feed, fed(loops, TUNED, FEEDS[0], by_sample=True))
    return _MADE[loops]
