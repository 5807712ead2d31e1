"""The loops of the study and the runs that claims and pictures need; each run is made once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from leadscrew.disturbances.pulse_load import pulse_load
from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import chatter, iae, max_error, overshoot, rise_time, steady_state_error
from leadscrew.references.cutting_program import cutting_force, cutting_program
from leadscrew.sensors.load_cell import lathe_reading, load_cell
from leadscrew.studies.grey_turning.controllers import CONTROLLERS
from leadscrew.studies.grey_turning.judged import filtered_overshoot, filtered_rise, filtered_steady
from leadscrew.studies.grey_turning.machines import FOLLOWING, MACHINES, PERIOD_S, SUBSTEPS, machine_of
from leadscrew.studies.grey_turning.scenarios import SCENARIOS, Turn
from leadscrew.studies.loops import StudyLoops
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

SIGNALS = ("feedback", "output", "actual")


def takes_cut(controller: Block) -> bool:
    """Whether a controller reads the programme and all sensors; any other gets the force, commanded and filtered."""
    return bool(getattr(controller.step, "takes_cut", False))


def metrics_of(scenario: Scenario) -> dict[str, Block]:
    """What a run is judged by: the filtered force as in the paper, the true one in N; steady: the last second."""
    late = scenario.duration_s - 1.0
    return {
        "filtered_overshoot": filtered_overshoot,
        "filtered_rise": filtered_rise,
        "filtered_steady": filtered_steady(from_time=late),
        "overshoot": overshoot,
        "rise_time": rise_time,
        "steady_state_error": steady_state_error(from_time=late),
        "max_error": max_error(from_time=1.0),
        "iae": iae,
        "chatter": chatter,
    }


def build(
    controller: Block,
    scenario: Scenario,
    machine: str | None = None,
    changes: Mapping[str, Any] | None = None,
    **options: Any,
) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine unless another is named.

    A controller that takes the depth ahead is told how the machine's radial axis moves. ``changes``: parameters by
    dotted key; ``options``: of the loop (``substeps``, ``metrics``, ``seed``, ``period``).
    """
    from leadscrew.kernel.loop import Loop

    asked: Turn = scenario.params
    whole = takes_cut(controller)
    depth = {f"depth.{key}": value for key, value in asked.depth._asdict().items()}
    plant = MACHINES[machine or machine_of(scenario)].plant(**depth, spindle_rpm=asked.spindle_rpm, runout=asked.runout)
    if plant.params.radial.gain > 0.0 and hasattr(controller.params, "radial"):
        controller = controller(**FOLLOWING)
    sensor = lathe_reading if whole else load_cell
    given: dict[str, Any] = {
        "reference": cutting_program(force=asked.force, **depth) if whole else cutting_force(force=asked.force),
        "controller": controller,
        "plant": plant,
        "sensor": sensor(noise_n=asked.noise_n, keep=asked.keep),
        "disturbance": pulse_load(size=asked.hard_spot, start=asked.hard_from_s, duration=asked.hard_for_s),
        "period": PERIOD_S,
        "substeps": SUBSTEPS,
        "metrics": metrics_of(scenario),
        "name": f"{controller.name} in {scenario.name}",
    }
    loop = Loop(**(given | options))
    return loop.using(changes) if changes else loop


class Loops(StudyLoops):
    """Loops of the study; those that differ in values alone share one compiled program. Runs are kept."""

    def __init__(self) -> None:
        super().__init__(CONTROLLERS, SCENARIOS, build, SIGNALS)


def filtered(run: Any) -> Any:
    """The filtered force of a run or a batch, whichever the controller was given."""
    return run["feedback.force"] if "feedback.force" in run.signals else run["feedback"]
