"""The axes that the study's loops run on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

from leadscrew.controllers.sliding.continuous import seen_in_mm
from leadscrew.friction.lugre import steady_bristle
from leadscrew.kernel.block import Block
from leadscrew.plants.ballscrew_gms import ballscrew_gms, sliding_at
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD, ballscrew_stage


def bent(plant: Block, speed: float) -> Block:
    """A plant with LuGre friction in steady sliding at ``speed``, rad/s."""
    return plant.starting(speed=speed, bristle=steady_bristle(plant.params.friction, speed))


TIGHT: Mapping[str, Any] = MappingProxyType({"method": "rodas", "rtol": 1e-6, "atol": 1e-12})
"""Position to a thousandth of a nanometre, but where the stage sticks and slips."""


class Machine(NamedTuple):
    """An axis: what moves, and how it is at the start of a run that begins in motion."""

    doc: str
    plant: Block
    start: Callable[[Block, float], Block] = bent
    """``(plant, speed in rad/s) -> plant``."""
    options: Mapping[str, Any] = TIGHT
    """How it is integrated."""
    actuator: Block | None = None
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
"""By name; a scenario that ends in ``_on_NAME`` runs on that one, every other on ``nominal``."""


def machine_of(scenario: str) -> str:
    """The name of the machine that a scenario runs on."""
    return next((name for name in MACHINES if scenario.endswith(f"_on_{name}")), "nominal")
