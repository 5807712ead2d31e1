"""A small machine to operate: a slide on a spring under a sine, on the Python engine, so that nothing is compiled."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.controllers._pid import pid
from leadscrew.kernel.block import Block, controller, plant
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.references._sine import sine
from leadscrew.study_data import Scenario, Study


class GainParams(NamedTuple):
    """A gain, and a limit in whole volts."""

    kp: Annotated[float, Unit("V/mm"), Ge(0), Le(1000), Doc("volt per millimetre")] = 2.0
    steps: Annotated[int, Ge(1), Le(100), Doc("whole volts at most")] = 10


@controller(GainParams(), unit="V")
def gain(p, command, feedback):
    """Without state, without align."""
    return max(-float(p.steps), min(float(p.steps), p.kp * (command - feedback)))


class MeanParams(NamedTuple):
    """A gain on the mean of the last errors."""

    kp: Annotated[float, Unit("V/mm"), Ge(0), Le(1000)] = 2.0
    taps: Annotated[int, Ge(1), Le(64), Doc("how many errors")] = 4


class MeanPlan(NamedTuple):
    """The gain, and one weight for each error."""

    kp: float
    weights: np.ndarray


class MeanState(NamedTuple):
    """The last error."""

    last: float = 0.0


def planned(p: MeanParams, dt: float) -> MeanPlan:
    """Equal weights."""
    return MeanPlan(p.kp, np.full(p.taps, 1.0 / p.taps))


@controller(MeanParams(), MeanState(), prepare=planned, unit="V")
def mean(p, s, command, feedback):
    """Half of this error, half of the last."""
    error = command - feedback
    return MeanState(error), p.kp * 0.5 * (error + s.last) + 0.0 * p.weights[0]


class SlideParams(NamedTuple):
    """A lag and a gain."""

    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("time constant")] = 0.05
    gain: Annotated[float, Unit("mm/(V s)"), Ge(-1e9), Doc("speed per volt")] = 20.0


class SlideState(NamedTuple):
    """Position and speed."""

    position: Annotated[float, Unit("mm")] = 0.0
    speed: Annotated[float, Unit("mm/s")] = 0.0


@plant(SlideParams(), SlideState(), output="position", unit="mm")
def slide(p, s, u):
    """A motor with a screw."""
    return SlideState(s.speed, (p.gain * u - s.speed) / p.lag_s)


class Way(NamedTuple):
    """A sine."""

    amplitude_mm: Annotated[float, Unit("mm"), Ge(0), Doc("half of peak to peak")] = 1.0


def build(block: Block, scenario: Scenario) -> Loop:
    """The loop, at 1 kHz."""
    period = 2e-3 if block.name == "slow" else 1e-3
    return Loop(
        reference=sine(amplitude=scenario.params.amplitude_mm, frequency=2.0),
        controller=block,
        plant=slide,
        period=period,
        bound=1e6,
        engine="python",
        name="bench",
    )


volts = replace(pid, unit="V")
"""The PID in front of a drive that takes volts."""


def _slow() -> Block:
    return replace(gain, name="slow")


STUDY = Study(
    name="bench",
    title="A slide",
    paper="Nobody: Nothing (2000).",
    controllers={"pid": volts(kp=3.0, ki=20.0, kd=0.01), "stiff": volts(kp=4.0, ki=5.0, kd=0.0), "gain": gain,
                 "mean": mean, "slow": _slow()},
    scenarios={"way": Scenario("way", Way(), "two turns a second", 2.0)},
    build=build,
    folder=Path(__file__).parent,
)  # fmt: skip
NAME = f"{Path(__file__)}:STUDY"
