"""What is cut: three lines in three materials, calm, with a change of material on the way, lap after lap, straight.

The paper shows one curve (Figure 5) and says nothing of the material: lines, materials, texture and camera are a
reconstruction. The lines are in :mod:`leadscrew.paths.shapes`, the materials in
:obj:`leadscrew.plants.flexible_cut`. A sample is 10 ms, at 50 mm/s 0.5 mm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.actuators._saturation import saturation
from leadscrew.disturbances._cut_load import cut_load
from leadscrew.kernel.block import Block, metric, sensor
from leadscrew.kernel.metrics import iae, max_error, rms_error
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._flexible_cut import MATERIALS, RADIAN, Material, flexible_cut
from leadscrew.references._cut_line import cut_line
from leadscrew.references._step import step
from leadscrew.sensors._cut_camera import (
    CutCameraParams,
    CutCameraState,
    SeenCut,
    cut_camera,
    cut_reading,
    plan,
    watched,
)
from leadscrew.study_data import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop
    from leadscrew.paths.path import Path, Sampled

PERIOD_S = 0.01
FEED = 50.0
"""Feed along the line, mm/s."""
SAMPLE_MM = FEED * PERIOD_S
LENGTHS_MM = {"wave": 461.541, "flower": 394.960, "rrect": 454.248}
"""The lines and how long they are; the rounded rectangle is gone along one and a half times."""
LAPS = {"wave": 1.0, "flower": 1.0, "rrect": 1.5}
LINES = tuple(LAPS)
LINE_WORDS = {"wave": "wave", "flower": "flower", "rrect": "rounded rectangle"}
MATERIAL_NAMES = ("fabric", "leather", "foam")
MAX_OFFSET_DEG = 15.0
"""Largest offset of the tangential axis."""
SEED = 11
"""Of the runs that controllers are judged by; they were tuned on others."""

MISMATCH = {"softening": 12.0, "four_fold": 0.7, "ripple": 0.5, "hysteresis": 0.3}
"""Sharp curves add less shear, the fibre acts four-fold, a wave runs along the way, and the shear has play."""
MACHINES: dict[str, Block] = {"believed": flexible_cut, "mismatch": flexible_cut.using(**MISMATCH)}
"""By name; a scenario that ends in ``_on_NAME`` runs on that one, every other on ``believed``."""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "believed")


# ---- the lines
def shape(name: str) -> Path:
    """The line itself."""
    from leadscrew.paths import shapes

    makers = {"wave": shapes.wave, "flower": shapes.flower, "rrect": shapes.rounded_rectangle}
    return makers[name]()


@lru_cache
def line(name: str) -> Sampled:
    """The line, a sample a control period."""
    from leadscrew.paths.path import sampled

    return sampled(shape(name), SAMPLE_MM, LAPS[name])


def line_of(scenario: str) -> str:
    """Name of the line of a scenario: its first word; ``straight`` where it is none of them."""
    first = scenario.split("_")[0]
    return first if first in LAPS else "straight"


@lru_cache
def line_tables(scenario: str, feed: float) -> dict[str, Any]:
    """Parameters of ``cut_line`` and ``cut_load`` for the line of a scenario; laps have a whole number of samples."""
    from leadscrew.paths.path import sampled
    from leadscrew.references._cut_line import tables

    name = line_of(scenario)
    if name == "straight":
        return dict(tables(np.zeros(1), np.zeros(1)))
    if scenario.endswith("_laps"):
        once = sampled(shape(name), feed * PERIOD_S, 1, whole=True)
        return tables(once.heading, once.curvature) | {"again": True, "turn": float(once.turn)}
    found = sampled(shape(name), feed * PERIOD_S, LAPS[name])
    return dict(tables(found.heading, found.curvature))


def samples_of(scenario: str, feed: float = FEED) -> int:
    """Samples of the line of a scenario; the last place is held for one more. 0 of a straight one."""
    name = line_of(scenario)
    return 0 if name == "straight" else int(LENGTHS_MM[name] / (feed * PERIOD_S)) + 1


# ---- the scenarios
class Cut(NamedTuple):
    """A line in a material."""

    material: Material = Material()
    changed: Material = MATERIALS["foam"]
    change_share: Annotated[float, Ge(0), Le(1), Doc("share of the way after which it changes; 0: never")] = 0.0
    feed: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the blade along the line")] = FEED
    texture_deg: Annotated[float, Unit("deg"), Ge(0), Doc("standard deviation of the texture")] = 0.25
    texture_mm: Annotated[float, Unit("mm"), Gt(0), Doc("its correlation length")] = 3.0
    noise_deg: Annotated[float, Unit("deg"), Ge(0), Doc("standard deviation of a reading of the camera")] = 0.15
    trailing_s: Annotated[float, Unit("s"), Ge(0), Doc("time from the blade to where the camera sees")] = 0.04
    zero_deg: Annotated[float, Unit("deg"), Doc("error of the camera's zero")] = 0.0
    step_deg: Annotated[float, Unit("deg"), Doc("change of the steady shear")] = 0.0
    step_at_s: Annotated[float, Unit("s"), Ge(0), Doc("when it comes")] = 1.0


def _cut(name: str, doc: str, **values: float | Material) -> Scenario:
    """A scenario on the line that its name begins with, to the end of the line."""
    params = Cut()._replace(**values)  # type: ignore[arg-type]
    return Scenario(name, params, doc, (samples_of(name, params.feed) + 1) * PERIOD_S)


LAP_COUNT = 20
"""Laps of the long run on a closed line."""

SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        *(
            _cut(f"{line}_{material}", f"the {line} in {material}", material=MATERIALS[material])
            for line in LINES
            for material in MATERIAL_NAMES
        ),
        _cut("wave_fabric_quiet", "the wave in fabric, without texture and noise", texture_deg=0.0, noise_deg=0.0),
        *(_cut(f"{line}_change", f"the {line}: fabric, from half on foam", change_share=0.5) for line in LINES),
        *(_cut(f"{line}_fabric_on_mismatch", f"the {line} in fabric that is not as the model says") for line in LINES),
        Scenario("flower_laps", Cut(), f"{LAP_COUNT} laps of the flower in fabric", LAP_COUNT * 7.9),
        Scenario("straight", Cut(), "straight on, in fabric, 10,000 samples", 100.0),
        Scenario(
            "step",
            Cut(material=Material(fibre=0.0, bias=0.0), step_deg=-5.0, texture_deg=0.0, noise_deg=0.0),
            "straight on, and after 1 s the shear changes by -5 degrees",
            6.0,
        ),
    )
}


# ---- the loop
class Feed(NamedTuple):
    """How fast the blade goes."""

    feed: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the blade along the line")] = FEED


class Distance(NamedTuple):
    """Where the cut is, and how far it was."""

    place: float = 0.0
    largest: float = 0.0


def farthest(p, s):
    """The largest distance."""
    return s.largest


@metric(Feed(), Distance(), output=farthest, unit="mm")
def lateral(p, s, error, t, dt):
    """Largest distance of the cut from the programmed line, to either side: ``max abs(int sin e ds)``."""
    place = s.place - math.sin(RADIAN * error) * p.feed * dt
    return Distance(place, max(s.largest, abs(place)))


@sensor(CutCameraParams(), CutCameraState(), prepare=plan)
def blind_camera(p, s, actual, t, dt, noise):
    """The camera that does not say when it has lost the cut: its last reading stands, as if it were seen."""
    after, reading = watched(p, s, actual.deviation, t, dt, noise)
    return after, SeenCut(reading.deviation, 1.0)


def takes_cut_line(controller: Block) -> bool:
    """Whether a controller is given the programmed line and the camera's word; any other gets two angles."""
    return bool(getattr(controller.step, "takes_cut_line", False))


def build(
    controller: Block,
    scenario: Scenario,
    machine: str | None = None,
    blind: bool = False,
    changes: Mapping[str, Any] | None = None,
) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine unless another is named.

    ``blind``: the camera does not say when it has lost the cut; ``changes``: parameters by dotted key.
    """
    from leadscrew.kernel.loop import Loop

    cut: Cut = scenario.params
    whole = takes_cut_line(controller)
    table = line_tables(scenario.name, cut.feed) | {"feed": cut.feed}
    change = {"change_at": cut.change_share * samples_of(scenario.name, cut.feed) * cut.feed * PERIOD_S}
    materials = {
        f"{slot}.{key}": value
        for slot, material in (("material", cut.material), ("changed", cut.changed))
        for key, value in material._asdict().items()
    }
    camera = blind_camera if blind else cut_reading if whole else cut_camera
    loop = Loop(
        reference=cut_line(**table) if whole else step(target=0.0),
        controller=controller,
        plant=MACHINES[machine or machine_of(scenario.name)](
            feed=cut.feed, **materials, **(change if cut.change_share else {})
        ),
        sensor=camera(trailing_s=cut.trailing_s, noise_deg=cut.noise_deg, zero_deg=cut.zero_deg),
        actuator=saturation(lower=-MAX_OFFSET_DEG, upper=MAX_OFFSET_DEG),
        disturbance=cut_load(
            size=cut.texture_deg, length=cut.texture_mm, step=cut.step_deg, step_at=cut.step_at_s, **table
        ),
        period=PERIOD_S,
        metrics={
            "rms_error": rms_error(from_time=PERIOD_S),
            "max_error": max_error(from_time=PERIOD_S),
            "lateral": lateral(feed=cut.feed),
            "iae": iae,
        },
        seed=SEED,
        name=f"{controller.name} on {scenario.name}",
    )
    return loop.using(changes) if changes else loop
