"""The simulations that the study's claims and figures need, and their loops."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import chatter, overshoot, rms_error, settling_time, steady_state_error
from leadscrew.kernel.sheet import entries
from leadscrew.studies.study import Scenario
from leadscrew.studies.vud_lathe.controllers import CONTROLLERS
from leadscrew.studies.vud_lathe.machines import MACHINES, machine_of
from leadscrew.studies.vud_lathe.scenarios import SCENARIOS, command, last_step_s

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PERIOD_S = 0.001
"""Sample period of the controller (section IV.b, end)."""

STEPPED = (
    "paper.vud", "corrected.vud_beta_e", "corrected.vud_beta_e_half", "ours.original_fit", "ours.pd",
)  # fmt: skip
"""Controllers whose steps are drawn and judged one by one."""

ON_THE_ENCODER = ("power_law", "duty_pid")
"""Controllers of the original servo, which reads the encoder (Figure 1); every other reads the grating (Figure 2)."""

METRICS: dict[str, Block] = {
    "settling_1pct": settling_time(percent=1.0),
    "settling_2um": settling_time(percent=0.0, band=0.002),
    "overshoot": overshoot,
    "error_after_2s": steady_state_error(from_time=2.0),
    "rms_error": rms_error,
    "chatter": chatter(from_time=2.0),
}
"""Seconds and millimetres of the true position."""

AFTER_2_S = ("error_after_2s", "chatter")
"""Of these, what is measured from 2 s after the last step of the command on."""

STEPS = ("fig11a_step_m50", "fig11b_step_m170")
TABLE_1_STEPS = {"r=-190": "step_m190", "r=-50": "fig11a_step_m50", "r=50": "step_p50", "r=190": "step_p190"}
GENTLE = ("trapezoid_m170", "s_curve_m170")
GAINS_MM_S = np.linspace(259.0, 334.0, 16)
"""Speeds at full duty that Table 1's moves ask for one by one (285 to 341), widened downwards."""
PRINTED_SECONDS = 32.0
"""How long the printed law needs to arrive at -170 mm, and two seconds more."""

SIGNALS = ("command", "actual.position", "feedback", "output")
INSIDE = ("controller.e", "controller.ec", "controller.alpha_e", "controller.alpha_ec", "controller.beta")


def build(controller: Block, scenario: Scenario, machine: str | None = None, sensor: str | None = None) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine and the sensor that the controller had.

    ``machine`` (of :data:`leadscrew.studies.vud_lathe.machines.MACHINES`) and ``sensor`` (``grating`` or ``encoder``)
    take the place of those.
    """
    from leadscrew.kernel.loop import Loop

    axis = MACHINES[machine or machine_of(scenario.name)]
    own = "encoder" if controller.name in ON_THE_ENCODER else "grating"
    return Loop(
        reference=command(scenario.params),
        controller=controller,
        plant=axis.plant,
        sensor=axis.encoder if (sensor or own) == "encoder" else axis.grating,
        actuator=axis.actuator,
        period=PERIOD_S,
        metrics={
            name: metric(from_time=last_step_s(scenario.params) + 2.0) if name in AFTER_2_S else metric
            for name, metric in METRICS.items()
        },
    )


def plan() -> list[tuple[str, str, float]]:
    """Scenario, controller and duration of every run."""
    runs = [
        (scenario, controller, PRINTED_SECONDS if controller == "paper.vud" else 4.0)
        for scenario in STEPS
        for controller in STEPPED
    ]
    runs += [(scenario, "ours.original_fit", 4.0) for scenario in TABLE_1_STEPS.values() if scenario not in STEPS]
    runs += [(scenario, c, 4.0) for scenario in GENTLE for c in ("corrected.vud_beta_e", "ours.pd")]
    return runs


class Loops:
    """Loops of the study; those that differ in parameters alone share one compiled program. Runs are kept."""

    def __init__(self) -> None:
        self._loops: dict[tuple[str, ...], Loop] = {}
        self._runs: dict[tuple[Any, ...], Any] = {}

    def get(
        self, controller: str | Block, scenario: str, machine: str | None = None, sensor: str | None = None
    ) -> Loop:
        """The loop of :func:`build` for these names."""
        block = CONTROLLERS[controller] if isinstance(controller, str) else controller
        loop = build(block, SCENARIOS[scenario], machine, sensor)
        family = tuple("" if found is None else found.name for found in loop.blocks.values())
        if family not in self._loops:
            _ = loop.program  # built once here, so that the loops derived from it share it
            self._loops[family] = loop
        changes = {
            entry.key: entry.default
            for slot, found in loop.blocks.items()
            if found is not None and found.params is not None
            for entry in entries(found.params, f"{slot}.")
        }
        return self._loops[family].using(changes)

    def run(
        self,
        controller: str | Block,
        scenario: str,
        seconds: float = 4.0,
        machine: str | None = None,
        sensor: str | None = None,
        record: tuple[str, ...] = SIGNALS,
    ) -> Any:
        """A run of the loop, made once for the same arguments; a block of one's own is run each time."""
        key = (controller, scenario, seconds, machine, sensor, record)
        if isinstance(controller, str) and key in self._runs:
            return self._runs[key]
        done = self.get(controller, scenario, machine, sensor).run(seconds, record=record)
        if isinstance(controller, str):
            self._runs[key] = done
        return done

    def batch(
        self,
        controller: str | Block,
        scenario: str,
        changes: Mapping[str, Any],
        seconds: float = 4.0,
        machine: str | None = None,
        sensor: str | None = None,
        **options: Any,
    ) -> Any:
        """A batch of the loop with parameters varied by dotted key."""
        return self.get(controller, scenario, machine, sensor).batch(seconds, changes, **options)


def simulate(progress: Callable[[str, float], None], loops: Loops) -> dict[str, Any]:
    """All runs, by ``scenario/controller``."""
    runs: dict[str, Any] = {}
    wanted = plan()
    for number, (scenario, controller, seconds) in enumerate(wanted):
        progress(f"{controller} in {scenario}", number / len(wanted))
        inside = INSIDE if "vud" in controller else ()
        runs[f"{scenario}/{controller}"] = loops.run(controller, scenario, seconds, record=(*SIGNALS, *inside))
    progress("gain sweep", 1.0)
    return runs


def sweep_gain(controller: str, scenario: str, loops: Loops) -> Any:
    """The batch of a controller over :data:`GAINS_MM_S`."""
    return loops.batch(controller, scenario, {"plant.full_duty_speed_mm_s": GAINS_MM_S})


def true_error_um(run: Any) -> np.ndarray:
    """Command minus true position, in micrometres."""
    return 1000.0 * (run["command"] - run["actual.position"])


def speed_between(run: Any, first_s: float, last_s: float) -> float:
    """Mean speed of the slide between two times, in mm/s, positive."""
    first, last = round(first_s / PERIOD_S), round(last_s / PERIOD_S)
    x = run["actual.position"]
    return float(abs(x[last] - x[first]) / (last_s - first_s))


def table_misfit_percent(runs: Mapping[str, Any], moves: Mapping[str, Any]) -> dict[str, float]:
    """Root mean square distance of our fit of the original servo from Table 1, in percent of each way."""
    misfit = {}
    for name, scenario in TABLE_1_STEPS.items():
        move = moves[name]
        at = np.rint(move.time_s / PERIOD_S).astype(int)
        simulated = (move.target_mm - runs[f"{scenario}/ours.original_fit"]["actual.position"][at]) / 190.0
        misfit[name] = float(100.0 * np.sqrt(np.mean((simulated - move.error) ** 2)) / abs(move.error[0]))
    return misfit
