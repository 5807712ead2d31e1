"""A loop with noise, for tests of many runs: a gain on an integrator, read through noise; some gains diverge."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import Block, controller, plant
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import max_error, overshoot, rms_error, settling_time
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._step import step
from leadscrew.sensors._counts import noisy_ruler
from leadscrew.study_data import Scenario, Study


class GainParams(NamedTuple):
    """A gain, and a number of stages."""

    kp: Annotated[float, Unit("V/mm"), Ge(0), Doc("volt per millimetre")] = 4.0
    stages: Annotated[int, Ge(1), Doc("how often the gain counts")] = 1
    on: Annotated[bool, Doc("a switch")] = True


@controller(GainParams(), unit="V")
def gain(p, command, feedback):
    """Volt against the error."""
    return p.kp * p.stages * (command - feedback)


class SlideParams(NamedTuple):
    """How slow it is."""

    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("time constant")] = 0.05


class SlideState(NamedTuple):
    """Position."""

    x: float = 0.0


@plant(SlideParams(), SlideState(), output="x", unit="mm")
def slide(p, s, u):
    """An integrator."""
    return SlideState(u / p.lag_s)


class StepMove(NamedTuple):
    """A step."""

    target_mm: Annotated[float, Unit("mm"), Ge(-10), Doc("where to go")] = 1.0


SCENARIOS = {
    s.name: s
    for s in (Scenario("small", StepMove(), "one millimetre", 0.1), Scenario("large", StepMove(5.0), "five", 0.2))
}


def build(block: Block, scenario: Scenario) -> Loop:
    """The loop; a period of 1 ms."""
    return Loop(
        reference=step(target=scenario.params.target_mm),
        controller=block,
        plant=slide,
        sensor=noisy_ruler(noise_mm=0.01),
        metrics={
            "rms_error": rms_error,
            "max_error": max_error,
            "overshoot": overshoot,
            "settling": settling_time(percent=0.0, band=0.1),
        },
        bound=1e3,
    )


STUDY = Study(
    name="noisy",
    title="A noisy loop",
    paper="Nobody (2000).",
    controllers={"p": gain, "p_half": gain(kp=10.0)},
    scenarios=SCENARIOS,
    build=build,
    folder=Path(__file__).parent,
)
LOOP = build(gain, SCENARIOS["small"])
FILE = Path(__file__)
NAME = f"{FILE}:STUDY"
DIVERGING = ("plant.lag_s=0.00001:0.00002",)
"""With a period of 1 ms the integration of so short a lag explodes."""
