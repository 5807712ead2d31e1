"""The loops of the study and the runs that claims and pictures need; each run is made once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.controllers.sliding.continuous import in_motion
from leadscrew.kernel.block import Block
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.metrics import max_error, max_output, overshoot, rms_error, settling_time
from leadscrew.sensors.ruler import ruler
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.machines import MACHINES, machine_of
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, FilteredStep, StepMove, command, start_speed
from leadscrew.studies.loops import StudyLoops
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PERIOD_S = 2.5e-4
"""Control period of the sampled controllers: 4 kHz."""

ENCODER_NM = 10.0
"""Resolution of the table's scale."""

SAMPLE_S = 2e-4
"""Interval between recorded samples of a loop in continuous time."""

SIGNALS = ("true_error", "output")


def metrics_of(scenario: Scenario) -> dict[str, Block]:
    """What a run is judged by, in seconds and mm of the true position; of sines and feeds the second half counts."""
    if isinstance(scenario.params, StepMove | FilteredStep):
        return {
            "settling_1um": settling_time(percent=0.0, band=0.001),
            "overshoot": overshoot,
            "max_torque": max_output,
        }
    late = 0.5 * scenario.duration_s
    return {"max_error": max_error(from_time=late), "rms_error": rms_error(from_time=late), "max_torque": max_output}


def build(
    controller: Block,
    scenario: Scenario,
    machine: str | None = None,
    period: float = PERIOD_S,
    encoder_nm: float = ENCODER_NM,
    changes: Mapping[str, Any] | None = None,
    sample: float = SAMPLE_S,
    **options: Any,
) -> Loop:
    """The loop of a controller in a scenario, without computation delay: a delay line cannot start in motion.

    A sampled controller reads a scale of ``encoder_nm`` (0: the true position) every ``period``. A controller without
    sampling sees position and speed exactly. ``changes``: parameters by dotted key; ``options``: of the loop (``rtol``,
    ``atol``, ``substeps``, ``method``, ``actuator``, ``metrics``).
    """
    from leadscrew.kernel.loop import Loop

    axis = MACHINES[machine or machine_of(scenario.name)]
    reference = command(scenario.params)
    speed = start_speed(scenario.params)
    common: dict[str, Any] = {"reference": reference, "actuator": axis.actuator, "metrics": metrics_of(scenario)}
    if controller.continuous:
        if axis.ideal is None:
            raise ValueRefused(f"{controller.name} is without sampling; on {axis.doc} only sampled controllers run")
        more: dict[str, Any] = {"period": None, "sample": sample, "rtol": 1e-6, "atol": 1e-11} | options
        loop = Loop(controller=controller, plant=axis.ideal, **(common | more))
    else:
        sensor = ruler(resolution_mm=1e-6 * encoder_nm) if encoder_nm > 0.0 else None
        more = {"period": period} | dict(axis.options) | options
        loop = Loop(controller=controller, plant=axis.plant, sensor=sensor, **(common | more))
    loop = loop.using(changes) if changes else loop
    if speed != 0.0:
        plant, law = loop.blocks["plant"], loop.blocks["controller"]
        assert plant is not None and law is not None
        loop.blocks["plant"] = axis.start(plant, speed)
        if law.continuous:
            loop.blocks["controller"] = in_motion(law, speed)
    return loop


class Loops(StudyLoops):
    """Loops of the study; those that differ in values alone share one compiled program. Runs are kept."""

    def __init__(self) -> None:
        super().__init__(CONTROLLERS, SCENARIOS, build, SIGNALS)


def tail_um(run: Any, after: float = 0.5) -> tuple[float, float]:
    """Largest and root-mean-square true error, in um, in what follows the part ``after`` of a run."""
    e = 1e3 * run["true_error"]
    e = e[int(after * len(e)) :]
    return float(np.abs(e).max()), float(np.sqrt(np.mean(e * e)))


def travel_per_second(run: Any, after: float = 0.5, signal: str = "output") -> float:
    """Total variation of a signal per second in the later part: what a chattering torque does to a motor, N m/s."""
    u, t = run[signal], run["time"]
    first = int(after * len(u))
    return float(np.abs(np.diff(u[first:])).sum() / (t[-1] - t[first]))
