"""Loops of the ball-screw stage on the paper's three sines, sampled and in continuous time."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from leadscrew.controllers._sliding.stage import View, layer_slope, switching_gain
from leadscrew.friction.lugre import LuGre, bristle_rate, friction, steady_bristle
from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references._sine import sine_motion
from leadscrew.sensors._counts import ruler

UM = 1e3 * TRAVEL_MM_PER_RAD
"""Micrometres of the table per radian."""

SINES = {"slow": (0.01, 1.0), "wide": (5.0, 1.0), "fast": (1.0, 2.0 * math.pi)}
"""Amplitude in mm and rate in rad/s of the paper's three commands: 0.01 sin t, 5 sin t, sin 2 pi t."""


def command(name):
    amplitude, rate = SINES[name]
    return sine_motion(amplitude=amplitude / TRAVEL_MM_PER_RAD, frequency=rate / (2.0 * math.pi))


def start_speed(name):
    amplitude, rate = SINES[name]
    return amplitude / TRAVEL_MM_PER_RAD * rate


def stage_loop(block, name="fast", period=2.5e-4, encoder_mm=0.0, plant=ballscrew_stage, **more):
    """A sampled loop that starts in steady sliding, on the command."""
    v = start_speed(name)
    return Loop(
        reference=command(name),
        controller=block,
        plant=plant.starting(speed=v, bristle=steady_bristle(LuGre(), v)),
        sensor=ruler(resolution_mm=encoder_mm / TRAVEL_MM_PER_RAD) if encoder_mm else None,
        period=period,
        metrics={},
        **({"method": "rodas", "rtol": 1e-6, "atol": 1e-12} | more),
    )


def errors_um(run, after=0.5):
    """Largest and root-mean-square true error in the last part of a run."""
    e = UM * run["true_error"][int(after * len(run["true_error"])) :]
    return np.abs(e).max(), math.sqrt(np.mean(e * e))


class Measured(NamedTuple):
    angle: float = 0.0
    speed: float = 0.0


class IdealState(NamedTuple):
    xi: float = 0.0
    bristle: float = 0.0


def both(s):
    """Angle and speed."""
    return Measured(s.angle, s.speed)


def continuous_loop(law, params, name, sample):
    """The same law without sampling: ideal speed, bristles driven by the commanded speed, all bristles at rest."""

    @controller(params, IdealState(), continuous=True)
    def ideal(p, s, command, feedback):
        """Derivatives of xi and the bristles, and the torque."""
        e = feedback.angle - command.position
        rate = bristle_rate(p.hat, command.velocity, s.bristle)
        held = friction(p.hat, command.velocity, s.bristle, rate)
        gain = switching_gain(p, feedback.speed)
        now = View(
            feedback.angle, feedback.speed, e, feedback.speed - command.velocity, s.xi, command.acceleration, held,
            0.0, gain, layer_slope(p, gain),
        )  # fmt: skip
        return IdealState(e, rate), held + p.inertia * law(p, now)

    plant = replace(ballscrew_stage.starting(speed=start_speed(name)), output=both, jacobian=None)
    return Loop(
        reference=command(name), controller=ideal, plant=plant, period=None, sample=sample, metrics={}, rtol=1e-8,
        atol=1e-13,
    )  # fmt: skip
