"""The loops of the study and the runs that claims and pictures need; each run is made once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.actuators.saturation import saturation
from leadscrew.disturbances.cut_load import cut_load
from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import iae, max_error, rms_error
from leadscrew.references.cut_line import cut_line
from leadscrew.references.step import step
from leadscrew.sensors.cut_camera import cut_camera, cut_reading
from leadscrew.studies.loops import StudyLoops
from leadscrew.studies.sofnn_tangent.controllers import CONTROLLERS
from leadscrew.studies.sofnn_tangent.judged import lateral
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES, PERIOD_S, samples_of, values_of
from leadscrew.studies.sofnn_tangent.machines import MACHINES, machine_of
from leadscrew.studies.sofnn_tangent.scenarios import SCENARIOS, Cut
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

SIGNALS = ("actual.deviation", "actual.angle", "actual.lateral", "output")

MOST_DEG = 15.0
"""Largest offset of the tangential axis."""

SEED = 11
"""Of the runs that controllers are judged by; they were tuned on others."""

CELLS = 5
"""Runs of a cell: each with a texture and noise of its own."""


def takes_cut_line(controller: Block) -> bool:
    """Whether a controller is given the programmed line and the camera's word; any other gets two angles."""
    return bool(getattr(controller.step, "takes_cut_line", False))


def build(
    controller: Block,
    scenario: Scenario,
    machine: str | None = None,
    changes: Mapping[str, Any] | None = None,
    **options: Any,
) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine unless another is named.

    ``changes``: parameters by dotted key; ``options``: of the loop (``metrics``, ``seed``, ``disturbance``).
    """
    from leadscrew.kernel.loop import Loop

    asked: Cut = scenario.params
    whole = takes_cut_line(controller)
    line = values_of(scenario.name, asked.feed) | {"feed": asked.feed}
    samples = samples_of(scenario.name, asked.feed)
    change = {"change_at": asked.change_share * samples * asked.feed * PERIOD_S} if asked.change_share else {}
    plant = MACHINES[machine or machine_of(scenario.name)]
    materials = {
        f"{slot}.{key}": value
        for slot, material in (("material", asked.material), ("changed", asked.changed))
        for key, value in material._asdict().items()
    }
    camera = cut_reading if whole else cut_camera
    given: dict[str, Any] = {
        "reference": cut_line(**line) if whole else step(target=0.0),
        "controller": controller,
        "plant": plant(feed=asked.feed, **materials, **change),
        "sensor": camera(trailing_s=asked.trailing_s, noise_deg=asked.noise_deg, zero_deg=asked.zero_deg),
        "actuator": saturation(lower=-MOST_DEG, upper=MOST_DEG),
        "disturbance": cut_load(
            size=asked.texture_deg, length=asked.texture_mm, step=asked.step_deg, step_at=asked.step_at_s, **line
        ),
        "period": PERIOD_S,
        "metrics": {
            "rms_error": rms_error(from_time=PERIOD_S),
            "max_error": max_error(from_time=PERIOD_S),
            "lateral": lateral(feed=asked.feed),
            "iae": iae,
        },
        "seed": SEED,
        "name": f"{controller.name} on {scenario.name}",
    }
    loop = Loop(**(given | options))
    return loop.using(changes) if changes else loop


class Cells(NamedTuple):
    """What a controller does on all lines in all materials: arrays ``[line, material, run]``."""

    rms: np.ndarray
    """deg"""
    most: np.ndarray
    """deg"""
    lateral: np.ndarray
    """mm"""


class Loops(StudyLoops):
    """Loops of the study; those that differ in values alone share one compiled program. Runs are kept."""

    def __init__(self) -> None:
        super().__init__(CONTROLLERS, SCENARIOS, build, SIGNALS)
        self._cells: dict[Any, Cells] = {}

    def cells(
        self,
        controller: str | Block,
        runs: int = CELLS,
        lines: Sequence[str] = tuple(LAPS),
        materials: Sequence[str] = MATERIAL_NAMES,
        suffix: str = "",
        seed: int = SEED,
        changes: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> Cells:
        """All lines in all materials, ``runs`` times each: every controller meets the same textures and noise.

        One batch a line. ``suffix``: of the scenarios' names (``_on_mismatch``). What has no changes is kept.
        """
        key = (controller, runs, tuple(lines), tuple(materials), suffix, seed)
        plain = isinstance(controller, str) and not changes and not options
        if plain and key in self._cells:
            return self._cells[key]
        found = []
        for line in lines:
            scenario = self.asked(f"{line}_fabric{suffix}")
            loop = self.get(controller, scenario, changes=changes, **options).using(seed=seed)
            batch = loop.batch(scenario.duration_s, material_columns(materials, runs))
            found.append(
                [batch.metrics[name].reshape(len(materials), runs) for name in ("rms_error", "max_error", "lateral")]
            )
        cells = Cells(*np.moveaxis(np.array(found), 1, 0))
        if plain:
            self._cells[key] = cells
        return cells


def material_columns(materials: Sequence[str], runs: int) -> dict[str, np.ndarray]:
    """Columns of a batch: ``runs`` runs in each material."""
    from leadscrew.plants.flexible_cut import MATERIALS

    return {
        f"plant.material.{field}": np.repeat([getattr(MATERIALS[m], field) for m in materials], runs)
        for field in MATERIALS["fabric"]._fields
    }
