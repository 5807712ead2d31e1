"""The axes on which the study's controllers are tried: the rebuilt chain, and the same with one thing more each."""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.kernel.block import Block
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.sensors.encoder_count import encoder_count
from leadscrew.sensors.grating_count import grating_count


class Machine(NamedTuple):
    """An axis: what moves, what the grating and the encoder show of it, and what stands before the motor."""

    doc: str
    plant: Block
    grating: Block = grating_count
    encoder: Block = encoder_count
    actuator: Block | None = None


MACHINES: dict[str, Machine] = {
    "linear": Machine("the chain (2) to (4) with the slide rebuilt from Table 1, ideal sensors", lathe_servo),
}
"""By name; a scenario that ends in ``_NAME`` runs on that one, every other on ``linear``."""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "linear")
