"""What the axis is asked to do, on which machine, and the loop of both.

Every scenario starts at rest at 0, the middle of the rail; Table 1's universe of 190 mm each way bounds the target. A
controller of the original servo reads the encoder (Figure 1), every other the grating (Figure 2).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from leadscrew.actuators._dead_zone import dead_zone
from leadscrew.actuators._offset import offset
from leadscrew.actuators._pwm import pwm
from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.metrics import chatter, overshoot, rms_error, settling_time, steady_state_error
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._lathe_screw import lathe_screw
from leadscrew.plants._lathe_servo import lathe_servo
from leadscrew.plants._lathe_servo_limited import lathe_servo_limited
from leadscrew.references._s_curve import SCurveParams, plan_s_curve, s_curve
from leadscrew.references._stairs import stairs
from leadscrew.references._step import step
from leadscrew.references._trapezoid import TrapezoidParams, plan_trapezoid, trapezoid
from leadscrew.sensors._counts import encoder_count, grating_count, screw_encoder
from leadscrew.sensors.grating._ruler import grating_ruler
from leadscrew.study_data import Scenario

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

PERIOD_S = 0.001
"""Sample period of the controller (section IV.b, end)."""

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


class Machine(NamedTuple):
    """An axis: what moves, what the grating and the encoder show of it, and what stands before the motor."""

    doc: str
    plant: Block
    grating: Block = grating_count
    encoder: Block = encoder_count
    actuator: Block | None = None


MACHINES: dict[str, Machine] = {
    "linear": Machine("the chain (2) to (4) with the slide rebuilt from Table 1, ideal sensors", lathe_servo),
    "limited": Machine(
        "the same with a motor that has 7.5 A and 258.7 mm/s at most, and a PWM amplifier of 1,000 counts",
        lathe_servo_limited,
        actuator=pwm,
    ),
    "screw": Machine(
        "the same behind a ball screw with lead error, cyclic error, play and warmth; both sensors with their errors",
        lathe_screw(lead_error=2e-5, cyclic_error_mm=0.002, backlash_mm=0.003, warming_K=1.0),
        grating_ruler(interpolation_1_mm=0.1e-3, interpolation_2_mm=0.05e-3, noise_mm=50e-6),
        screw_encoder,
    ),
    "dead_zone": Machine("the same with a duty that does nothing below a threshold", lathe_servo, actuator=dead_zone),
    "drift": Machine("the same with a constant duty added: an axis that drifts", lathe_servo, actuator=offset),
}
"""By name; a scenario that ends in ``_on_NAME`` runs on that one, every other on ``linear``.

The screw's errors are inside what a screw of ISO 3408 grade 3 may have, the ruler's are usual ones; both are ours.
"""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "linear")


@reference(TrapezoidParams(), prepare=plan_trapezoid, unit="mm")
def trapezoid_position(p, t):
    """The position of :func:`leadscrew.references.trapezoid`."""
    motion = trapezoid(p, t)
    return motion.position


@reference(SCurveParams(), prepare=plan_s_curve, unit="mm")
def s_curve_position(p, t):
    """The position of :func:`leadscrew.references.s_curve`."""
    motion = s_curve(p, t)
    return motion.position


Target = Annotated[float, Unit("mm"), Ge(-190), Le(190), Doc("where to go from 0")]
Speed = Annotated[float, Unit("mm/s"), Gt(0), Doc("limit of the commanded speed")]
Acceleration = Annotated[float, Unit("mm/s^2"), Gt(0), Doc("limit of the commanded acceleration")]
Jerk = Annotated[float, Unit("mm/s^3"), Gt(0), Doc("limit of the commanded jerk")]


class StepMove(NamedTuple):
    """A step of the command at time 0."""

    target_mm: Target = -50.0


class TrapezoidMove(NamedTuple):
    """A move with limited speed and acceleration; the limits are ours, below what 289 mm/s and the lags allow."""

    target_mm: Target = -50.0
    max_velocity_mm_s: Speed = 240.0
    max_acceleration_mm_s2: Acceleration = 2000.0


class SCurveMove(NamedTuple):
    """A move with limited speed, acceleration and jerk; the limits are ours."""

    target_mm: Target = -50.0
    max_velocity_mm_s: Speed = 240.0
    max_acceleration_mm_s2: Acceleration = 2000.0
    max_jerk_mm_s3: Jerk = 40000.0


class Sequence(NamedTuple):
    """Steps of the command one after the other, some of them back."""

    positions_mm: Annotated[np.ndarray, Unit("mm"), Ge(-190), Le(190), Doc("targets in turn")] = np.array(
        [-50.0, -170.0, -160.0, -170.0, 60.0, 0.0]
    )
    dwell_s: Annotated[float, Unit("s"), Gt(0), Doc("time from one step to the next")] = 3.0


def command(params: StepMove | TrapezoidMove | SCurveMove | Sequence) -> Block:
    """The reference block of a scenario's parameters."""
    if isinstance(params, Sequence):
        return stairs(positions=params.positions_mm, dwell=params.dwell_s)
    if isinstance(params, StepMove):
        return step(initial=0.0, target=params.target_mm, time=0.0)
    limits = {
        "distance": params.target_mm,
        "max_velocity": params.max_velocity_mm_s,
        "max_acceleration": params.max_acceleration_mm_s2,
    }
    if isinstance(params, SCurveMove):
        return s_curve_position(max_jerk=params.max_jerk_mm_s3, **limits)
    return trapezoid_position(**limits)


def last_step_s(params: StepMove | TrapezoidMove | SCurveMove | Sequence) -> float:
    """When the command of a scenario steps for the last time."""
    return params.dwell_s * (len(params.positions_mm) - 1) if isinstance(params, Sequence) else 0.0


def _step(name: str, target: float, doc: str) -> Scenario:
    return Scenario(name, StepMove(target), doc, duration_s=4.0)


def _on(machine: str, what: str) -> list[Scenario]:
    """Both steps of Figure 11 on another axis."""
    return [
        _step(f"step_m{way}_on_{machine}", -float(way), f"a step to -{way} mm on the axis {machine!r}: {what}")
        for way in (50, 170)
    ]


SCENARIOS: dict[str, Scenario] = {
    found.name: found
    for found in (
        _step("fig11a_step_m50", -50.0, "Figure 11 (a): a step to -50 mm; also the move r=-50 of Table 1"),
        _step("fig11b_step_m170", -170.0, "Figure 11 (b): a step to -170 mm"),
        _step("step_m190", -190.0, "the move r=-190 of Table 1"),
        _step("step_p50", 50.0, "the move r=50 of Table 1"),
        _step("step_p190", 190.0, "the move r=190 of Table 1"),
        Scenario("trapezoid_m50", TrapezoidMove(-50.0), "to -50 mm with limited speed and acceleration", 4.0),
        Scenario("trapezoid_m170", TrapezoidMove(-170.0), "to -170 mm with limited speed and acceleration", 4.0),
        Scenario("s_curve_m50", SCurveMove(-50.0), "to -50 mm with limited speed, acceleration and jerk", 4.0),
        Scenario("s_curve_m170", SCurveMove(-170.0), "to -170 mm with limited speed, acceleration and jerk", 4.0),
        Scenario("sequence", Sequence(), "a positioning sequence with reversals, each target for 3 s", 18.0),
        Scenario("sequence_on_screw", Sequence(), "the same behind the ball screw and its play", 18.0),
        *_on("limited", "7.5 A, 258.7 mm/s, PWM counts"),
        *_on("screw", "lead error, cyclic error, play, warmth; sensors with their errors"),
        *_on("dead_zone", "small duties do nothing"),
        *_on("drift", "a constant duty is added"),
    )
}


class Step(NamedTuple):
    """A step of Figure 11."""

    scenario: str
    way_mm: float
    near_s: float
    """When both curves are said to have nearly arrived."""

    def __str__(self) -> str:
        return f"−{self.way_mm:g} mm"


STEPS = {"m50": Step("fig11a_step_m50", 50.0, 1.0), "m170": Step("fig11b_step_m170", 170.0, 1.25)}
"""The steps of Figure 11, by what claims call them."""
TABLE_1_STEPS = {"r=-190": "step_m190", "r=-50": "fig11a_step_m50", "r=50": "step_p50", "r=190": "step_p190"}
PRINTED_SECONDS = 32.0
"""How long the printed law needs to arrive at -170 mm, and two seconds more."""


def build(controller: Block, scenario: Scenario, machine: str | None = None, sensor: str | None = None) -> Loop:
    """The loop of a controller in a scenario, on the scenario's machine and the sensor that the controller had.

    ``machine`` (of :data:`MACHINES`) and ``sensor`` (``grating`` or ``encoder``)
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
