"""Runs in which the rules learn: piece after piece, with rules from before, interrupted; and many variants.

A run alone is faster than a lane of a batch here: the 49 x 49 covariance of sixteen runs does not stay in the cache.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.kernel.block import sensor
from leadscrew.plants.flexible_cut import MATERIALS
from leadscrew.sensors.cut_camera import CutCameraParams, CutCameraState, SeenCut, plan, watched
from leadscrew.studies.sofnn_tangent.lines import MATERIAL_NAMES, PERIOD_S
from leadscrew.studies.sofnn_tangent.runs import CELLS, Loops

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live
    from leadscrew.kernel.loop import Loop

TABLE, PNN, TUNED = "corrected.sofnn_table", "paper.sofnn_pnn", "ours.sofnn_tuned"
"""The paper's scales with the table between its cells; with the performance network: the paper; tuned scales."""

LINES = ("wave", "flower", "rrect")

CALM: Mapping[str, Any] = {"disturbance.size": 0.0}
"""No texture; what is left is the noise of the camera."""

STRAIGHT: Mapping[str, Any] = {"plant.material.bias": 0.0, "plant.material.fibre": 0.0}
"""Nothing that turns the cut on a straight line."""

_LOOPS: WeakKeyDictionary[Loops, dict[tuple[str, str, bool], Loop]] = WeakKeyDictionary()


@sensor(CutCameraParams(), CutCameraState(), prepare=plan)
def blind_camera(p, s, actual, t, dt, noise):
    """The camera that does not say when it has lost the cut: its last reading stands, as if it were seen."""
    after, reading = watched(p, s, actual.deviation, t, dt, noise)
    return after, SeenCut(reading.deviation, 1.0)


def rms(values: Any) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def loop_of(
    loops: Loops, controller: str, scenario: str, changes: Mapping[str, Any] | None = None, blind: bool = False
) -> Loop:
    """A loop with parameters changed; ``blind``: its camera does not say when it has lost the cut."""
    kept = _LOOPS.setdefault(loops, {})
    key = (controller, scenario, blind)
    if key not in kept:
        loop = loops.get(controller, scenario)
        if blind:
            camera = loop.blocks["sensor"]
            assert camera is not None
            loop = loops.get(controller, scenario, sensor=blind_camera(**camera.params._asdict()))
        kept[key] = loop
    return kept[key].using(changes) if changes else kept[key]


def in_material(name: str) -> dict[str, float]:
    """Changes that make the material ``name``."""
    return {f"plant.material.{field}": value for field, value in MATERIALS[name]._asdict().items()}


def rules(live: Live) -> Any:
    """State of the controller as it is now: ``weights``, ``covariance`` and the rest; a copy."""
    return live.program.plan.state.unpack(live.state[0].copy(), live.state[1].copy()).controller


def first_rules(loops: Loops, controller: str) -> np.ndarray:
    """The 49 rules that a controller starts with, levels."""
    return np.asarray(cast(Any, loops.controllers[controller].state).weights)


def started(loop: Loop, number: int = 0, weights: Any = None, covariance: Any = None) -> Live:
    """A loop at its start, with these rules in place of its own."""
    live = loop.start(run=number)
    state = live.program.plan.state.unpack(*live.state)
    given = {k: np.array(v) for k, v in (("weights", weights), ("covariance", covariance)) if v is not None}
    if given:
        live.state = live.program.plan.state.pack(state._replace(controller=state.controller._replace(**given)))
    return live


def deviations(live: Live, samples: int) -> np.ndarray:
    """The deviation of the cut at the next ``samples`` samples, deg, from the plant's state after each."""
    return np.asarray(live.advance(samples + 1, record=("actual.deviation",))["actual.deviation"])[1:]


def to_the_end(loops: Loops, live: Live, scenario: str) -> np.ndarray:
    """The deviation at all samples of a scenario, deg."""
    return deviations(live, live.loop.periods(loops.scenarios[scenario].duration_s) - 1)


# ---- pieces, and what is left of the learning


@dataclass(frozen=True)
class Pieces:
    """Pieces cut one after another; the rules go on from piece to piece."""

    rms: np.ndarray
    """Of the deviation of each, deg."""
    weights: list[np.ndarray]
    """Consequents after each, levels."""
    covariance: np.ndarray


def pieces(
    loops: Loops, controller: str, scenario: str, count: int, number: int = 0, changes: Mapping[str, Any] | None = None
) -> Pieces:
    """``count`` pieces under a controller that learns, each with a texture of its own."""
    loop = loop_of(loops, controller, scenario, changes)
    found: list[float] = []
    weights: list[np.ndarray] = []
    covariance: Any = None
    for k in range(count):
        live = started(loop, number + k, weights[-1] if weights else None, covariance)
        found.append(rms(to_the_end(loops, live, scenario)))
        state = rules(live)
        weights.append(state.weights)
        covariance = state.covariance
    return Pieces(np.array(found), weights, covariance)


@dataclass(frozen=True)
class Recall:
    """What is left of the learning when the rules are held: RMS, deg."""

    none: float
    prior: float
    """Rules from before the learning, held."""
    learning: float
    held: float
    """Learned rules, held."""

    @property
    def kept(self) -> float:
        """Share of the gain over the held prior that the held learned rules keep, %."""
        return 100.0 * (self.prior - self.held) / (self.prior - self.learning)


def recall(loops: Loops, controller: str, line: str, leak: float = 0.0, textures: int = 4, laps: int = 5) -> Recall:
    """Learns over ``laps`` pieces of fabric, then cuts one more: without, with held prior, learning on, held rules.

    Means over ``textures`` such histories.
    """
    scenario = f"{line}_fabric"
    going = loop_of(loops, controller, scenario, {"controller.leak": leak})
    held = going.using({"controller.learning": False})
    none = loop_of(loops, "paper.uncompensated", scenario)
    found = []
    for history in range(textures):
        number = 10 * history
        learned = pieces(loops, controller, scenario, laps, number, {"controller.leak": leak})
        then = number + laps
        lives = (
            none.start(run=then),
            started(held, then),
            started(going, then, learned.weights[-1], learned.covariance),
            started(held, then, learned.weights[-1]),
        )
        found.append([rms(to_the_end(loops, live, scenario)) for live in lives])
    return Recall(*(float(v) for v in np.mean(found, axis=0)))


# ---- variants


def nine(
    loops: Loops, controller: str, runs: int = 1, changes: Mapping[str, Any] | None = None, learned: bool = False
) -> np.ndarray:
    """RMS of the nine cells ``[line, material, run]``, deg, in the textures of ``Loops.cells``.

    ``learned``: in its place, how far the rules of a controller that learns are from its first ones at the end, RMS
    in levels.
    """
    found = np.zeros((len(LINES), len(MATERIAL_NAMES), runs))
    for i, line in enumerate(LINES):
        loop = loop_of(loops, controller, f"{line}_fabric", changes)
        for j, material in enumerate(MATERIAL_NAMES):
            own = loop if material == "fabric" else loop.using(in_material(material))
            for k in range(runs):
                live = own.start(run=CELLS * j + k)
                e = to_the_end(loops, live, f"{line}_fabric")
                found[i, j, k] = rms(rules(live).weights - first_rules(loops, controller)) if learned else rms(e)
    return found


# ---- readings


def stays_within(row: np.ndarray, width: float, since: int = 0) -> float:
    """Seconds after sample ``since`` from which on a row stays within ``width`` of zero; NaN where it never does."""
    outside = np.flatnonzero(np.abs(row[since:]) > width)
    after = int(outside[-1]) + 1 if outside.size else 0
    return PERIOD_S * after if since + after < row.size else float("nan")


def listed(values: Any, digits: int = 2) -> str:
    """Numbers in a row, for a sentence."""
    return ", ".join(f"{v:.{digits}f}" for v in np.ravel(values))
