"""The loops of the study and the runs that claims and pictures need; each run is made once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.actuators.saturation import saturation
from leadscrew.controllers.wrapping import takes_motion
from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import chatter, max_error, overshoot, rms_error, settling_time
from leadscrew.plants.xy_table_cutting import xy_table_cutting
from leadscrew.sensors.noisy_ruler import noisy_ruler
from leadscrew.studies.loops import StudyLoops
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, LINES_HZ, PERIOD_S
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.machines import MACHINES, machine_of
from leadscrew.studies.npid_xytable.scenarios import SCENARIOS, StepMove, command, load, spindle
from leadscrew.studies.study import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

SIGNALS = ("true_error", "output")

AMPLIFIER = saturation
"""The drive takes -10 to 10 V."""

FINEST_UM = 1e-9
"""Resolution of an encoder that only has noise."""


def metrics_of(scenario: Scenario) -> dict[str, Block]:
    """What a run is judged by, in mm of the true position and V: the second half counts, of a step all of it."""
    if isinstance(scenario.params, StepMove):
        return {"overshoot": overshoot, "settling_1um": settling_time(percent=0.0, band=0.001), "chatter": chatter}
    late = 0.5 * scenario.duration_s
    return {
        "rms_error": rms_error(from_time=late),
        "max_error": max_error(from_time=late),
        "chatter": chatter(from_time=late),
    }


def build(
    controller: Block,
    scenario: Scenario,
    machine: str | None = None,
    period: float = PERIOD_S,
    encoder_um: float | None = None,
    noise_um: float | None = None,
    changes: Mapping[str, Any] | None = None,
    **options: Any,
) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine.

    ``machine``, ``encoder_um`` and ``noise_um`` take the place of the scenario's; 0 and 0 is the position itself.
    ``changes``: parameters by dotted key; ``options``: of the loop (``substeps``, ``computation_delay``, ``metrics``,
    ``seed``).
    """
    from leadscrew.kernel.loop import Loop

    asked = scenario.params
    axis = MACHINES[machine or machine_of(scenario.name)]
    mark = asked.encoder_um if encoder_um is None else encoder_um
    noise = asked.noise_um if noise_um is None else noise_um
    sensor = noisy_ruler(resolution_mm=1e-3 * max(mark, FINEST_UM), noise_mm=1e-3 * noise) if mark or noise else None
    plant = axis.plant
    if plant.step is xy_table_cutting.step:
        plant = plant(**spindle(asked))
    given: dict[str, Any] = {
        "reference": command(asked, takes_motion(controller, period)),
        "controller": controller,
        "plant": plant,
        "sensor": sensor,
        "actuator": AMPLIFIER,
        "disturbance": load(asked),
        "period": period,
        "substeps": axis.substeps,
        "computation_delay": axis.computation_delay,
        "metrics": metrics_of(scenario),
    }
    loop = Loop(**(given | options))
    return loop.using(changes) if changes else loop


class Loops(StudyLoops):
    """Loops of the study; those that differ in values alone share one compiled program. Runs are kept."""

    def __init__(self) -> None:
        super().__init__(CONTROLLERS, SCENARIOS, build, SIGNALS)


def tail_um(run: Any, after: float = 0.5) -> tuple[float, float]:
    """Largest and root-mean-square true error, in um, in what follows the part ``after`` of a run."""
    e = 1e3 * run["true_error"]
    e = e[int(after * len(e)) :]
    return float(np.abs(e).max()), float(np.sqrt(np.mean(e * e)))


def spindle_lines_hz(loop: Loop, spindle_hz: float | None = None) -> tuple[float, ...]:
    """Where the lines of spindle and teeth stand in sampled signals, Hz: folded where above Nyquist."""
    from leadscrew.analysis.harmonics import folded

    plant = loop.blocks["plant"]
    params: Any = None if plant is None else plant.params
    turning = getattr(params, "spindle_hz", 0.0) if spindle_hz is None else spindle_hz
    if turning <= 0.0 or not hasattr(params, "teeth"):
        return ()
    seen = {round(float(folded(f, 1.0 / loop.period)), 9) for f in (turning, params.teeth * turning)}
    return tuple(sorted(f for f in seen if f > 0.0))


def amplitudes_um(run: Any, frequencies: Sequence[float] = LINES_HZ) -> np.ndarray:
    """Amplitudes of the true error at the lines of Table II in the last half of a run, um; of a batch a row a run.

    By least squares together with the motion's own frequency, the lines of the spindle and a trend: nothing leaks.
    """
    from leadscrew.analysis.harmonics import LineFit

    e = 1e3 * np.atleast_2d(run["true_error"])
    half = e.shape[1] // 2
    turning = getattr(run, "varied", {}).get("plant.spindle_hz")
    speeds = np.full(len(e), np.nan) if turning is None else np.broadcast_to(turning, len(e))
    found = np.full((len(e), len(frequencies)), np.nan)
    finite = np.isfinite(e).all(axis=1)
    for speed in np.unique(speeds):
        rows = finite & (np.isnan(speeds) if np.isnan(speed) else speeds == speed)
        asked = dict.fromkeys((BASE_HZ, *frequencies))
        asked |= dict.fromkeys(spindle_lines_hz(run.loop, None if np.isnan(speed) else float(speed)))
        if rows.any():
            fit = LineFit(run.time[half:], tuple(asked)).fit(e[rows, half:], noise="none")
            found[rows] = fit.amplitudes[..., [list(asked).index(f) for f in frequencies]]
    return found if run["true_error"].ndim > 1 else found[0]
