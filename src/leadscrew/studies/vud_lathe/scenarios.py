"""What the axis is asked to do: the steps of the paper, and the same ways as a machine would command them.

Every scenario starts at rest at 0, the middle of the rail; Table 1's universe of 190 mm each way bounds the target.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.kernel.sheet import Doc, Ge, Gt, Le, Unit
from leadscrew.references.stairs import stairs
from leadscrew.references.step import step
from leadscrew.studies.study import Scenario
from leadscrew.studies.vud_lathe.moves_reference import s_curve_position, trapezoid_position

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
