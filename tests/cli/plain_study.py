"""A tiny study, as a user would keep it in a file of his own: a speed under proportional control."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import Block, controller, plant
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import max_error, rms_error
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._step import step
from leadscrew.study_data import Scenario, Study


class GainParams(NamedTuple):
    """Gain of the controller, and one parameter of every type."""

    kp: Annotated[float, Unit("V/mm"), Ge(0), Doc("volt per millimetre [of error]")] = 2.0
    stages: Annotated[int, Ge(1), Doc("a whole number")] = 1
    inverted: Annotated[bool, Doc("a switch")] = False
    table: Annotated[np.ndarray, Doc("three numbers")] = np.array([1.0, 2.0, 3.0])


@controller(GainParams(), unit="V")
def gain(p, command, feedback):
    """Volt against the error."""
    sign = -1.0 if p.inverted else 1.0
    return sign * p.kp * p.table[0] * (command - feedback)


class HalfParams(NamedTuple):
    """Gain."""

    kp: Annotated[float, Unit("V/mm"), Ge(0)] = 1.0


@controller(HalfParams(), unit="V")
def half(p, command, feedback):
    """Half of that."""
    return 0.5 * p.kp * (command - feedback)


class SlideParams(NamedTuple):
    """A lag."""

    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("time constant")] = 0.05


class SlideState(NamedTuple):
    """Position."""

    x: float = 0.0


@plant(SlideParams(), SlideState(), output="x", unit="mm")
def slide(p, s, u):
    """A first-order lag."""
    return SlideState((u - s.x) / p.lag_s)


class StepMove(NamedTuple):
    """A step."""

    target_mm: Annotated[float, Unit("mm"), Ge(-10), Doc("where to go")] = 1.0


SCENARIOS = {s.name: s for s in (Scenario("small", StepMove(), "one millimetre", 0.2),)}


def build(block: Block, scenario: Scenario) -> Loop:
    """The loop, on the Python engine: nothing to compile."""
    return Loop(
        reference=step(target=scenario.params.target_mm),
        controller=block,
        plant=slide,
        metrics={"rms_error": rms_error, "max_error": max_error},
        bound=1e6,
        engine="python",
    )


STUDY = Study(
    name="plain",
    title="A plain <study>",
    paper="Nobody: Nothing (2000).",
    controllers={"p": gain, "p_half": gain(kp=1.0), "paper.half": half},
    scenarios=SCENARIOS,
    build=build,
    folder=Path(__file__).parent,
)


LOOP = build(gain, SCENARIOS["small"])
NUMBER = 3


def make() -> Loop:
    """A loop from a function."""
    return build(half, SCENARIOS["small"])


def broken() -> Loop:
    """A function with a fault."""
    return {}["nothing"]
