"""Sliding mode on the ball-screw stage with LuGre friction: the table goes to and fro by 2 mm, once a second, at 4 kHz.

Run it, and export its controller:

    leadscrew simulate examples/ballscrew_smc.py:loop --duration 2
    leadscrew export examples/ballscrew_smc.py:loop --duration 2 --target c99 --out smc_c99
"""

import math
from dataclasses import replace

from leadscrew import Loop
from leadscrew.controllers import csmc, smc
from leadscrew.kernel.metrics import max_error, rms_error
from leadscrew.plants import TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references import sine_motion
from leadscrew.sensors import ruler

PERIOD = 0.25e-3
"""4 kHz, s: the boundary layer of the blocks is made for it; the printed one would need 80 kHz and more."""

STAGE = replace(ballscrew_stage(travel_per_rad=TRAVEL_MM_PER_RAD), unit="mm")
"""The stage, seen by a linear scale at the table instead of by the angle of its screw."""


def on_the_stage(controller):
    """The loop of a sliding-mode controller: from rest, in mm, with a scale of 0.1 um."""
    return Loop(
        reference=sine_motion(amplitude=1.0, frequency=1.0, phase=-0.5 * math.pi, offset=1.0),
        controller=controller(travel_per_rad=TRAVEL_MM_PER_RAD),
        plant=STAGE,
        sensor=ruler(resolution_mm=1e-4),
        period=PERIOD,
        method="rodas",
        metrics={"rms_error": rms_error, "max_error": max_error},
    )


def loop():
    """The loop of the conventional law."""
    return on_the_stage(smc)


def complementary():
    """The loop of the complementary law."""
    return on_the_stage(csmc)
