"""What the axis is asked to do: the steps of the paper, and the same ways as a machine would command them.

Every scenario starts at rest at 0, the middle of the rail; Table 1's universe of 190 mm each way bounds the target.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import Block
from leadscrew.kernel.sheet import Doc, Ge, Gt, Le, Unit
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


def command(params: StepMove | TrapezoidMove | SCurveMove) -> Block:
    """The reference block of a scenario's parameters."""
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


def _step(name: str, target: float, doc: str) -> Scenario:
    return Scenario(name, StepMove(target), doc, duration_s=4.0)


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
    )
}
