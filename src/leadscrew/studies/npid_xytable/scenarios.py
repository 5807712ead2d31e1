"""What the table is asked to do, on which axis, and the loop of a controller in it.

The paper names neither the motion nor the forces. The lines of Table II are the odd harmonics of 0.7 Hz, so the motion
is a sine of that frequency; its amplitude is ours. The forces at those lines are calibrated to the PID column
(:mod:`leadscrew.studies.npid_xytable.calibration`); runout and tooth passing are ours.

The paper prints no dead time, yet its plot crosses the negative real axis at -0.4. In a loop sampled at 2 kHz with a
backward difference that takes 0.775 ms: the loop L*.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.actuators._saturation import saturation
from leadscrew.controllers._wrapping import takes_motion
from leadscrew.disturbances._five_sines import Line, five_sines
from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import chatter, max_error, overshoot, rms_error, settling_time
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit
from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.plants._xy_table_lugre import xy_table_lugre
from leadscrew.references._eased_sine import eased_sine, eased_sine_motion
from leadscrew.references._quintic import quintic
from leadscrew.references._step import step
from leadscrew.sensors._counts import noisy_ruler
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S, PERIOD_S, volts
from leadscrew.studies.npid_xytable.table2 import BASE_HZ, LINES_HZ, PID_UM, SPEEDS
from leadscrew.study_data import Scenario
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

AMPLIFIER = saturation
"""The drive takes -10 to 10 V."""
DEAD_ZONE = dead_zone(threshold=0.02, subtract=True)
"""A drive that loses 20 mV of every output."""


class Machine(NamedTuple):
    """An axis, and how it is stepped."""

    doc: str
    plant: Block
    substeps: int = 1
    computation_delay: float = 0.0
    """Dead time, for a plant that has none of its own."""
    actuator: Block = AMPLIFIER


FRICTION_STEPS = 20
"""Integration steps a period of an axis with friction: 25 us."""


def _rough(friction_mv: float, presliding_um: float) -> Machine:
    return Machine(
        f"the same with LuGre friction of {friction_mv:g} mV and {presliding_um:g} um of presliding",
        xy_table_lugre(friction_mv=friction_mv, presliding_um=presliding_um),
        FRICTION_STEPS,
        DEAD_TIME_S,
    )


MACHINES: dict[str, Machine] = {
    "l_star": Machine("equation (1) with 0.775 ms of dead time", xy_table_cutting),
    "l_zero": Machine("equation (1) as printed, without dead time", xy_table_cutting(dead_time_s=0.0)),
    "dead_zone": Machine(
        "the first with a drive that loses 20 mV of every output", xy_table_cutting, actuator=DEAD_ZONE
    ),
    "friction_low": _rough(2.6, 2.0),
    "friction_medium": _rough(20.0, 5.0),
    "friction_high": _rough(150.0, 10.0),
}
"""By name; a scenario that ends in ``_on_NAME`` runs on that one, every other on ``l_star``."""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "l_star")


Amplitude = Annotated[float, Unit("mm"), Ge(0), Le(500), Doc("half of peak to peak of the motion")]
Phase = Annotated[float, Unit("rad"), Doc("angle of this line of the disturbance at t = 0")]
Encoder = Annotated[float, Unit("um"), Ge(0), Le(1000), Doc("resolution of the encoder; 0: the position itself")]
Noise = Annotated[float, Unit("um"), Ge(0), Le(1000), Doc("standard deviation of a reading before it is rounded")]


class Cutting(NamedTuple):
    """A sine of 0.7 Hz while the spindle cuts."""

    amplitude_mm: Amplitude = 1.0
    spindle_rpm: Annotated[float, Unit("1/min"), Ge(0), Le(1e6), Doc("spindle speed; 0: no line of the spindle")] = (
        1000.0
    )
    column: Annotated[int, Doc("spindle speed of Table II whose PID amplitudes the lines have; 0: no lines")] = 1000
    phase3: Phase = 0.0
    phase5: Phase = 0.0
    phase7: Phase = 0.0
    phase9: Phase = 0.0
    phase11: Phase = 0.0
    runout_mv: Annotated[float, Unit("mV"), Ge(0), Doc("force line once a revolution")] = 1.0
    tooth_mv: Annotated[float, Unit("mV"), Ge(0), Doc("force line once a tooth")] = 2.0
    teeth: Annotated[int, Ge(1), Le(100), Doc("teeth of the cutter")] = 2
    encoder_um: Encoder = 0.0
    noise_um: Noise = 0.0


class Load(NamedTuple):
    """A constant load at rest."""

    load_mv: Annotated[float, Unit("mV"), Doc("constant load, as a voltage at the input")] = 1.32 * 3.0
    encoder_um: Encoder = 0.0
    noise_um: Noise = 0.0


class StepMove(NamedTuple):
    """A bare step from rest."""

    size_um: Annotated[float, Unit("um"), Ge(-1e6), Le(1e6), Doc("size of the step")] = 10.0
    encoder_um: Encoder = 0.0
    noise_um: Noise = 0.0


Move = Cutting | Load | StepMove


def command(params: Move, motion: bool) -> Block:
    """The reference block, in mm: a number, or a :class:`~leadscrew.references.Motion`."""
    if isinstance(params, StepMove):
        distance = 1e-3 * params.size_um
        return quintic(distance=distance, duration=0.0) if motion else step(target=distance)
    amplitude = params.amplitude_mm if isinstance(params, Cutting) else 0.0
    return (eased_sine_motion if motion else eased_sine)(amplitude=amplitude, frequency=BASE_HZ)


def line_changes(frequencies: Sequence[Any], volts: Sequence[Any], phases: Sequence[Any]) -> dict[str, Any]:
    """Parameters of ``five_sines`` by their keys, for as many lines as are given: numbers, or one a run of a batch."""
    columns = zip(five_sines.params._fields, zip(frequencies, volts, phases, strict=True), strict=False)
    return {
        f"{place}.{field}": value for place, line in columns for field, value in zip(Line._fields, line, strict=True)
    }


def load(params: Move) -> Block:
    """What disturbs the axis at the plant's input, in V, but for the lines of the spindle.

    Raises:
        ValueRefused: a column that Table II does not have.
    """
    if isinstance(params, StepMove):
        return five_sines
    if isinstance(params, Load):
        return five_sines(**line_changes((0.0,), (1e-3 * params.load_mv,), (0.5 * math.pi,)))
    if params.column not in (0, *PID_UM):
        raise ValueRefused(f"column = {params.column!r} (scenario): Table II has {sorted(PID_UM)}; 0 is no lines")
    sizes = volts(PID_UM[params.column]) if params.column else (0.0,) * len(LINES_HZ)
    phases = (params.phase3, params.phase5, params.phase7, params.phase9, params.phase11)
    return five_sines(**line_changes(LINES_HZ, sizes, phases))


def spindle(params: Move) -> dict[str, float | int]:
    """Parameters of ``xy_table_cutting`` for the lines of the spindle."""
    if not isinstance(params, Cutting):
        return {}
    return {
        "spindle_hz": params.spindle_rpm / 60.0,
        "spindle_v": 1e-3 * params.runout_mv,
        "teeth": params.teeth,
        "tooth_v": 1e-3 * params.tooth_mv,
    }


CUT_S = 20.0
"""Of a run under cutting; its last 10 s, seven periods of the motion, are judged."""

FITTED_MM = 0.4212
"""Amplitude of the motion whose following error under PID is 3 um."""

FITTED = {
    1000: (4.4582, 1.4098, 4.4563, 3.0743, 6.0035),
    2000: (4.7736, 5.4416, 1.8207, 3.4209, 2.9254),
    3000: (4.2064, 5.8132, 2.3483, 4.6275, 0.8124),
}
"""Phases of the disturbance in L*, rad, under which NPID comes nearest to its column of Table II
(:data:`leadscrew.studies.npid_xytable.laws.FITTED`, moved from the error to the disturbance)."""

SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        *(
            Scenario(
                f"spindle_{rpm}", Cutting(spindle_rpm=rpm, column=rpm),
                f"1 mm at 0.7 Hz at {rpm} 1/min; its five lines are those of Table II under PID", CUT_S,
            )
            for rpm in SPEEDS
        ),
        *(
            Scenario(
                f"measured_{rpm}", Cutting(spindle_rpm=rpm, column=rpm, encoder_um=0.5, noise_um=0.1),
                f"the same at {rpm} 1/min, read by an encoder of 0.5 um with 0.1 um of noise", CUT_S,
            )
            for rpm in SPEEDS
        ),
        *(
            Scenario(
                f"fitted_{rpm}", Cutting(FITTED_MM, rpm, rpm, *FITTED[rpm], runout_mv=0.0, tooth_mv=0.0),
                f"0.42 mm, Table II's lines of {rpm} 1/min, with phases fitted to its NPID column", CUT_S,
            )
            for rpm in SPEEDS
        ),
        Scenario("sine_1mm", Cutting(spindle_rpm=0.0, column=0), "1 mm at 0.7 Hz without cutting", CUT_S),
        Scenario("sine_15mm", Cutting(15.0, 0.0, 0), "15 mm at 0.7 Hz without cutting", CUT_S),
        Scenario(
            "quiet", Cutting(0.0, 0.0, 0, encoder_um=0.5, noise_um=0.1),
            "at rest, under the noise of the encoder alone: what the drive hears", 4.0,
        ),
        Scenario("constant_load", Load(), "at rest under a load of 3.96 mV: 3 um under Table I's PID", 3.0),
        Scenario(
            "sine_1mm_on_dead_zone", Cutting(spindle_rpm=0.0, column=0),
            "1 mm at 0.7 Hz without cutting, by a drive that loses 20 mV of every output", CUT_S,
        ),
        Scenario("step_10um", StepMove(), "a bare step of 10 um", 0.5),
        *(
            Scenario(
                f"sine_{size}mm_on_friction_{level}", Cutting(float(size), 0.0, 0),
                f"{size} mm at 0.7 Hz against friction: {words}", CUT_S,
            )
            for size, level, words in (
                (1, "low", "2.6 mV"), (1, "medium", "20 mV"), (1, "high", "150 mV"), (15, "high", "150 mV"),
            )
        ),
    )
}  # fmt: skip
"""By name; a name that ends in ``_on_MACHINE`` runs on that machine."""


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
        "actuator": axis.actuator,
        "disturbance": load(asked),
        "period": period,
        "substeps": axis.substeps,
        "computation_delay": axis.computation_delay,
        "metrics": metrics_of(scenario),
    }
    loop = Loop(**(given | options))
    return loop.using(changes) if changes else loop
