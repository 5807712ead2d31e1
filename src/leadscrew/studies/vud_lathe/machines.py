"""The axes on which the study's controllers are tried: the rebuilt chain, and the same with one thing more each."""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.actuators.dead_zone import dead_zone
from leadscrew.actuators.offset import offset
from leadscrew.actuators.pwm import pwm
from leadscrew.kernel.block import Block
from leadscrew.plants.lathe_screw import lathe_screw
from leadscrew.plants.lathe_servo import lathe_servo
from leadscrew.plants.lathe_servo_limited import lathe_servo_limited
from leadscrew.sensors.encoder_count import encoder_count
from leadscrew.sensors.grating.ruler import grating_ruler
from leadscrew.sensors.grating_count import grating_count
from leadscrew.sensors.screw_encoder import screw_encoder


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
