"""The stage, what it is asked to do, and the loop of a controller in a scenario.

Commands are in mm of the table. Steps and feeds start at rest; a sine is entered in motion, at the middle of its travel
in steady sliding, because the paper shows no start. A sampled controller reads a scale of 10 nm every 0.25 ms; a
controller in continuous time sees position and speed exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from leadscrew.controllers._sliding.continuous import in_motion, seen_in_mm
from leadscrew.friction.lugre import steady_bristle
from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import chatter, max_error, max_output, overshoot, rms_error, settling_time
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._ballscrew_axial import ballscrew_axial
from leadscrew.plants._ballscrew_gms import ballscrew_gms, sliding_at
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.plants._ballscrew_stage_fixed import ballscrew_stage_fixed
from leadscrew.references._filtered_step import filtered_step
from leadscrew.references._friction_test import ROWS, friction_test
from leadscrew.references._quintic import quintic
from leadscrew.references._ramp import ramp_motion
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._counts import ruler
from leadscrew.study_data import Scenario
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PERIOD_S = 2.5e-4
"""Control period of the sampled controllers: 4 kHz."""
ENCODER_NM = 10.0
"""Resolution of the table's scale."""
SAMPLE_S = 2e-4
"""Interval between recorded samples of a loop in continuous time."""
TIGHT: Mapping[str, Any] = MappingProxyType({"method": "rodas", "rtol": 1e-6, "atol": 1e-12})
"""Position to a thousandth of a nanometre, except where the stage sticks and slips."""

Travel = Annotated[float, Unit("mm"), Ge(-500), Le(500), Doc("length of the move")]


class StepMove(NamedTuple):
    """A step from rest, smooth unless its duration is 0."""

    distance_mm: Travel = 1.0
    duration_s: Annotated[float, Unit("s"), Ge(0), Le(60), Doc("time of the move; 0 for a bare step")] = 0.0


class FilteredStep(NamedTuple):
    """A step behind a critically damped filter of the second order."""

    distance_mm: Travel = 1.0
    rate_1_s: Annotated[float, Unit("1/s"), Gt(0), Le(1e5), Doc("both poles of the filter")] = 150.0


class SineMove(NamedTuple):
    """A sine that the run enters in motion: at the middle of the travel, at full speed, in steady sliding."""

    amplitude_mm: Annotated[float, Unit("mm"), Gt(0), Le(500), Doc("half of peak to peak")] = 1.0
    rate_rad_s: Annotated[float, Unit("rad/s"), Gt(0), Le(1e4), Doc("angular frequency")] = 2.0 * math.pi


class Creep(NamedTuple):
    """A constant feed from rest."""

    feed_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Le(1e3), Doc("commanded speed")] = 1e-3
    travel_mm: Annotated[float, Unit("mm"), Gt(0), Le(500), Doc("where it ends")] = 500.0


class FrictionTest(NamedTuple):
    """The move from which ``leadscrew identify friction`` reads the friction, under ``ours.pd_test``."""

    size: Annotated[float, Gt(0), Le(100), Doc("times the amplitudes of the standard rows")] = 1.0


class RestSine(NamedTuple):
    """A sine from rest, at the lower end of its travel: what controllers are tuned and compared on."""

    amplitude_mm: Annotated[float, Unit("mm"), Gt(0), Le(500), Doc("half of peak to peak")] = 1.0
    rate_rad_s: Annotated[float, Unit("rad/s"), Gt(0), Le(1e4), Doc("angular frequency")] = 2.0 * math.pi
    delay: Annotated[bool, Doc("one sample of computation delay")] = False
    axial_mode: Annotated[bool, Doc("screw and table as two inertias, 201 and 266 Hz")] = False
    fixed_cost: Annotated[bool, Doc("integrate the rigid stage at a fixed cost, a sixth of RODAS's")] = True


Move = StepMove | FilteredStep | SineMove | RestSine | Creep | FrictionTest


def command(params: Move) -> Block:
    """The reference block of a scenario's parameters, in mm."""
    if isinstance(params, StepMove):
        return quintic(distance=params.distance_mm, duration=params.duration_s)
    if isinstance(params, FilteredStep):
        return filtered_step(distance=params.distance_mm, rate=params.rate_1_s)
    if isinstance(params, SineMove):
        return sine_motion(amplitude=params.amplitude_mm, frequency=params.rate_rad_s / (2.0 * math.pi))
    if isinstance(params, RestSine):
        size, frequency = params.amplitude_mm, params.rate_rad_s / (2.0 * math.pi)
        return sine_motion(amplitude=size, frequency=frequency, phase=-0.5 * math.pi, offset=size)
    if isinstance(params, FrictionTest):
        return friction_test([(params.size * a, f, n) for a, f, n in ROWS])
    return ramp_motion(rate=params.feed_mm_s, duration=params.travel_mm / params.feed_mm_s)


def start_speed(params: Move) -> float:
    """Speed at the start, in rad/s of the screw; 0 from rest."""
    if isinstance(params, SineMove):
        return params.amplitude_mm * params.rate_rad_s / TRAVEL_MM_PER_RAD
    return 0.0


_BARE = (
    "a bare step of 1 mm, as Figure 11 asks for; its derivatives do not exist at the jump and are commanded as 0, "
    "though the paper's laws need y_r'': expect a blow of 76 to 170 N m and an overshoot, or take step_quintic"
)

SLOW_S = 4.0 * math.pi
"""Two periods of the slow sines."""

SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        Scenario("step_raw", StepMove(), _BARE, 0.6),
        Scenario("step_quintic", StepMove(duration_s=0.05), "1 mm in 50 ms by a polynomial of the fifth degree", 0.6),
        Scenario("step_filtered", FilteredStep(), "1 mm behind a critically damped filter of 150 1/s", 0.6),
        Scenario("sine_slow", SineMove(0.01, 1.0), "0.01 sin t mm, Figure 12: at creeping speed", SLOW_S),
        Scenario("sine_wide", SineMove(5.0, 1.0), "5 sin t mm, Figure 13", SLOW_S),
        Scenario("sine_fast", SineMove(1.0, 2.0 * math.pi), "sin 2 pi t mm, Figure 14", 4.0),
        Scenario(
            "presliding",
            SineMove(5e-5, 2.0 * math.pi),
            "50 nm to and fro: less than the 99 nm that Coulomb friction bends the bristles by",
            4.0,
        ),
        Scenario("rest_slow", RestSine(0.01, 1.0), "0.01 sin t mm from rest: a reversal after 3.1 s", 3.6),
        Scenario("rest_wide", RestSine(5.0, 1.0), "5 sin t mm from rest: a reversal after 3.1 s", 3.6),
        Scenario("rest_fast", RestSine(), "sin 2 pi t mm from rest: reversals after 0.5 and 1 s", 1.2),
        Scenario("friction_test", FrictionTest(), "the move for an identification of friction, 7.5 s", 7.5),
        Scenario("creep", Creep(), "a constant feed of 1 um/s from rest, below the Stribeck speed of 1.6 um/s", 4.0),
    )
}
"""By name. Steps and feeds start at rest, sines in motion."""


class Shown(NamedTuple):
    """A motion of Figures 11 to 14, and how it is written."""

    scenario: str
    words: str

    def __str__(self) -> str:
        return self.words


SINES = {
    s: Shown(s, words)
    for s, words in {"sine_slow": "0.01 sin t mm", "sine_wide": "5 sin t mm", "sine_fast": "sin 2πt mm"}.items()
}
"""Figures 12, 13 and 14."""
STEPS = {s: Shown(s, words) for s, words in {"step_raw": "a step of 1 mm", "step_quintic": "1 mm in 50 ms"}.items()}
"""Figure 11 as printed, and with derivatives that exist."""


def sine_of(scenario: str) -> SineMove:
    """The sine of a scenario."""
    params = SCENARIOS[scenario].params
    assert isinstance(params, SineMove)
    return params


# ---- the stage
def sliding(plant: Block, speed: float) -> Block:
    """A plant with LuGre friction in steady sliding at ``speed``, rad/s."""
    return plant.starting(speed=speed, bristle=steady_bristle(plant.params.friction, speed))


class Machine(NamedTuple):
    """An axis, and how it is at the start of a run that begins in motion."""

    doc: str
    plant: Block
    start: Callable[[Block, float], Block] = sliding
    """``(plant, speed in rad/s) -> plant``."""
    options: Mapping[str, Any] = TIGHT
    """How it is integrated."""
    ideal: Block | None = None
    """What controllers without sampling see; None: there is no such loop."""


MACHINES: dict[str, Machine] = {
    "nominal": Machine(
        "the paper's stage: 3.70e-4 kg m^2 and LuGre friction by Table 2",
        replace(ballscrew_stage(travel_per_rad=TRAVEL_MM_PER_RAD), unit="mm"),
        ideal=seen_in_mm(ballscrew_stage),
    ),
    "gms": Machine(
        "the same under generalised Maxwell slip, six elements: another truth than the controllers believe",
        replace(ballscrew_gms(travel_per_rad=TRAVEL_MM_PER_RAD), unit="mm"),
        start=sliding_at,
    ),
}
"""By name; every scenario runs on ``nominal`` unless ``build`` gets another one."""


AXIAL = Machine(
    "screw and table as two inertias", replace(ballscrew_axial(travel_per_rad=TRAVEL_MM_PER_RAD), unit="mm"),
    options={"method": "rodas", "rtol": 1e-3, "atol": 1e-6},
)  # fmt: skip
FIXED_COST = Machine(
    "the paper's stage at a fixed cost", replace(ballscrew_stage_fixed(travel_per_rad=TRAVEL_MM_PER_RAD), unit="mm"),
    options={"substeps": 2},
)  # fmt: skip


def from_rest(params: RestSine, axis: Machine, period: float) -> tuple[Machine, dict[str, Any]]:
    """The axis of a sine from rest, and options of its loop; it diverges where it leaves the track by 0.1 mm."""
    if params.axial_mode:
        axis = AXIAL
    elif params.fixed_cost and axis is MACHINES["nominal"]:
        axis = FIXED_COST
    delay = period if params.delay else 0.0
    return axis, {"computation_delay": delay, "bound": 2.0 * params.amplitude_mm + 0.1}


def metrics_of(scenario: Scenario) -> dict[str, Block]:
    """What a run is judged by, in seconds and mm of the true position; of sines and feeds the second half counts."""
    if isinstance(scenario.params, StepMove | FilteredStep):
        return {
            "settling_1um": settling_time(percent=0.0, band=0.001),
            "overshoot": overshoot,
            "max_torque": max_output,
        }
    if isinstance(scenario.params, RestSine):
        late = 0.4 * scenario.duration_s
        return {"max_error": max_error(from_time=late), "chatter": chatter(from_time=late), "max_torque": max_output}
    late = 0.5 * scenario.duration_s
    return {"max_error": max_error(from_time=late), "rms_error": rms_error(from_time=late), "max_torque": max_output}


def build(
    controller: Block,
    scenario: Scenario,
    machine: str = "nominal",
    period: float = PERIOD_S,
    encoder_nm: float = ENCODER_NM,
    changes: Mapping[str, Any] | None = None,
    sample: float = SAMPLE_S,
    speed: float | None = None,
    **options: Any,
) -> Loop:
    """The loop of a controller in a scenario, without computation delay: a delay line cannot start in motion.

    ``changes``: parameters by dotted key; ``speed``: of the screw at the start, rad/s, in place of the scenario's;
    ``options``: of the loop (``rtol``, ``atol``, ``substeps``, ``method``, ``metrics``). With ``encoder_nm`` 0 a
    sampled controller sees the true position.
    """
    from leadscrew.kernel.loop import Loop

    axis = MACHINES[machine]
    common: dict[str, Any] = {"reference": command(scenario.params), "metrics": metrics_of(scenario)}
    if controller.continuous:
        if axis.ideal is None:
            raise ValueRefused(f"{controller.name} is without sampling; on {axis.doc} only sampled controllers run")
        more: dict[str, Any] = {"period": None, "sample": sample, "rtol": 1e-6, "atol": 1e-11} | options
        loop = Loop(controller=controller, plant=axis.ideal, **(common | more))
    else:
        if isinstance(scenario.params, RestSine):
            axis, more = from_rest(scenario.params, axis, period)
            common |= more
        sensor = ruler(resolution_mm=1e-6 * encoder_nm) if encoder_nm > 0.0 else None
        more = {"period": period} | dict(axis.options) | options
        loop = Loop(controller=controller, plant=axis.plant, sensor=sensor, **(common | more))
    loop = loop.using(changes) if changes else loop
    speed = start_speed(scenario.params) if speed is None else speed
    if speed != 0.0:
        plant, law = loop.blocks["plant"], loop.blocks["controller"]
        assert plant is not None and law is not None
        loop.blocks["plant"] = axis.start(plant, speed)
        if law.continuous:
            loop.blocks["controller"] = in_motion(law, speed)
    return loop
