"""A piece of a log played back: the logged torque on a model of the stage that follows the logged position.

    T_model = T_logged + kp (y_logged - y_model) + kd (its change) / dt

With the right parameters the model needs no help: ``y_logged - y_model`` is the encoder's rounding. While bristles
hold, ``kp`` is a thousandth of their stiffness and the piece is as good as open loop; while it slides, where an error
of the torque would be integrated twice, ``kp`` keeps the model beside the log. Nothing is asked of the controller that
made the log.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.friction.lugre import LuGre, friction, steady_bristle
from leadscrew.kernel.block import controller, plant, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.sheet import Doc, Gt, Unit
from leadscrew.plants.ballscrew_stage import INERTIA, BallscrewStageState, stage_jacobian, stage_level

BANDWIDTH = 900.0
"""rad/s of the help, ``sqrt(kp / J)``; a fifth of the sampling rate at most."""


class Logged(NamedTuple):
    """One sample."""

    torque: float = 0.0
    angle: float = 0.0


class PieceParams(NamedTuple):
    """The log, and which piece of it."""

    first: Annotated[float, Doc("sample that the piece starts at")] = 0.0
    length: Annotated[float, Doc("samples of the piece; the last is held from then on")] = 1.0
    torque: Annotated[NDArray[np.float64], Unit("N m"), Doc("held from each sample to the next")] = np.zeros(1)
    angle: Annotated[NDArray[np.float64], Unit("rad"), Doc("measured at each sample")] = np.zeros(1)


def piece_step(p, t, dt):
    """The sample at ``t``."""
    row = int(p.first + min(math.floor(t / dt + 0.5), p.length - 1.0))
    return Logged(p.torque[row], p.angle[row])


class FollowParams(NamedTuple):
    """How the model is kept beside the log."""

    kp: Annotated[float, Unit("N m/rad"), Doc("torque per error")] = 300.0
    kd: Annotated[float, Unit("N m s/rad"), Doc("torque per rate of the error")] = 0.5


class FollowState(NamedTuple):
    """What was seen."""

    e: Annotated[float, Unit("rad"), Doc("logged minus modelled angle")] = 0.0
    started: float = 0.0


@controller(FollowParams(), FollowState(), unit="N m")
def follow(p, s, command, feedback, dt):
    """The logged torque, and a little help."""
    e = command.angle - feedback
    rate = s.started * (e - s.e) / dt
    return FollowState(e, 1.0), command.torque + p.kp * e + p.kd * rate


class ReplayParams(NamedTuple):
    """The stage, and how it moves when the piece starts."""

    inertia: Annotated[float, Unit("kg m^2"), Gt(0)] = INERTIA
    start_torque: Annotated[float, Unit("N m"), Doc("what the bristles hold, where it starts at rest")] = 0.0
    start_speed: Annotated[float, Unit("rad/s"), Doc("0: at rest")] = 0.0
    start_angle: Annotated[float, Unit("rad")] = 0.0
    friction: LuGre = LuGre()


def replay_start(p):
    """At rest the bristles hold the torque; in motion they slide steadily."""
    held = p.start_torque / p.friction.stiffness
    bristle = steady_bristle(p.friction, p.start_speed) if p.start_speed != 0.0 else held
    return BallscrewStageState(p.start_angle, p.start_speed, bristle)


@plant(ReplayParams(), BallscrewStageState(), initial=replay_start, output="angle", jacobian=stage_jacobian, stiff=True)
def replayed_stage(p, s, u, load):
    """The ball-screw stage with a start of its own."""
    f = p.friction
    rate = s.speed - abs(s.speed) * s.bristle * f.stiffness / stage_level(f, s.speed)
    torque = u + load - friction(f, s.speed, s.bristle, rate)
    return BallscrewStageState(s.speed, torque / p.inertia, rate)


def replay_loop(torque: np.ndarray, angle: np.ndarray, period: float, inertia: float) -> Loop:
    """The loop that plays pieces back; its error is ``controller.e``."""
    pace = min(BANDWIDTH, 0.2 / period)
    log = PieceParams(torque=np.ascontiguousarray(torque), angle=np.ascontiguousarray(angle))
    return Loop(
        reference=reference(log, name="piece")(piece_step),
        controller=follow(kp=inertia * pace * pace, kd=1.5 * inertia * pace),
        plant=replayed_stage(inertia=inertia),
        period=period,
        metrics={},
        method="rodas",
        rtol=1e-3,
        atol=1e-8,
        name="replay of a log",
    )
