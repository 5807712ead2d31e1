"""The loops of the study and the runs that claims and pictures need; each run is made once."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
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
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live
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


class Loops:
    """Loops of the study; those that differ in values alone share one compiled program. Runs are kept."""

    def __init__(self) -> None:
        self._built: list[Loop] = []
        self._runs: dict[Any, Any] = {}

    def get(self, controller: str | Block, scenario: str | Scenario, **options: Any) -> Loop:
        """The loop of :func:`build` for these names, on a program that exists where there is one."""
        block = CONTROLLERS[controller] if isinstance(controller, str) else controller
        asked = SCENARIOS[scenario] if isinstance(scenario, str) else scenario
        return self.adopt(build(block, asked, **options))

    def adopt(self, loop: Loop) -> Loop:
        """A loop of one's own, on a program that exists where there is one."""
        if not any(loop.shares(other) for other in self._built):
            self._built.append(loop)
        return loop

    def run(
        self,
        controller: str | Block,
        scenario: str | Scenario,
        seconds: float | None = None,
        record: tuple[str, ...] = SIGNALS,
        every: int = 1,
        **options: Any,
    ) -> Any:
        """A run of the loop, made once for the same arguments; as long as the scenario unless told otherwise."""
        key = self._key(controller, scenario, seconds, record, every, options)
        if isinstance(controller, str) and key in self._runs:
            return self._runs[key]
        loop, asked = self.get(controller, scenario, **options), self._asked(scenario)
        done = loop.run(asked.duration_s if seconds is None else seconds, record=record, every=every)
        if isinstance(controller, str):
            self._runs[key] = done
        return done

    def ahead(self, wanted: Iterable[tuple[str, str, Mapping[str, Any]]]) -> None:
        """Makes runs of :meth:`run` side by side, one a core, for what will be asked: controller, scenario, options."""
        from leadscrew.kernel.loop import DivergenceWarning

        lives: dict[Any, tuple[Live, float]] = {}
        for controller, scenario, options in wanted:
            key = self._key(controller, scenario, None, SIGNALS, 1, options)
            if key not in self._runs and key not in lives:
                live = self.get(controller, scenario, **options).start()
                lives[key] = live, self._asked(scenario).duration_s
        with ThreadPoolExecutor(os.cpu_count()) as side_by_side, warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            done = side_by_side.map(lambda m: m[0].advance(m[0].loop.periods(m[1]), record=SIGNALS), lives.values())
            self._runs.update(zip(lives, done, strict=True))

    @staticmethod
    def _asked(scenario: str | Scenario) -> Scenario:
        return SCENARIOS[scenario] if isinstance(scenario, str) else scenario

    def _key(self, controller: Any, scenario: str | Scenario, *rest: Any) -> Any:
        asked = self._asked(scenario)
        return (controller, asked.name, asked.params, *rest[:-1], repr(sorted(rest[-1].items())))

    @property
    def runs(self) -> dict[str, Any]:
        """The kept runs of plain scenarios, by ``scenario/controller``."""
        return {f"{key[1]}/{key[0]}": run for key, run in self._runs.items() if key[-1] == "[]"}


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
