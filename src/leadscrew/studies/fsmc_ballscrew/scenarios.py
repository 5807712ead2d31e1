"""What the stage is asked to do: the paper's step and sines, and what a machine would command."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import Block
from leadscrew.kernel.sheet import Doc, Ge, Gt, Le, Unit
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.references.filtered_step import filtered_step
from leadscrew.references.friction_test import ROWS, friction_test
from leadscrew.references.quintic import quintic
from leadscrew.references.ramp import ramp_motion
from leadscrew.references.sine import sine_motion
from leadscrew.studies.study import Scenario

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


Move = StepMove | FilteredStep | SineMove | Creep | FrictionTest


def command(params: Move) -> Block:
    """The reference block of a scenario's parameters, in mm."""
    if isinstance(params, StepMove):
        return quintic(distance=params.distance_mm, duration=params.duration_s)
    if isinstance(params, FilteredStep):
        return filtered_step(distance=params.distance_mm, rate=params.rate_1_s)
    if isinstance(params, SineMove):
        return sine_motion(amplitude=params.amplitude_mm, frequency=params.rate_rad_s / (2.0 * math.pi))
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
        Scenario("friction_test", FrictionTest(), "the move for an identification of friction, 7.5 s", 7.5),
        Scenario("creep", Creep(), "a constant feed of 1 um/s from rest, below the Stribeck speed of 1.6 um/s", 4.0),
    )
}
"""By name. Steps and feeds start at rest, sines in motion."""

SINES = ("sine_slow", "sine_wide", "sine_fast")
"""The paper's three."""
