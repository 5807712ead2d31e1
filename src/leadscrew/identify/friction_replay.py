"""A piece of a log played back: the logged torque on a model of the stage that follows the logged position.

    T_model = T_logged + kp (y_log - y_model)

``kp`` is a thousandth of the bristles' stiffness and keeps the model beside the log where the axis slides: there an
error of the torque would be integrated twice. ``y_log`` must be smooth: the steps of a reading would shake the
bristles, and bristles near their limit creep when shaken. Nothing is asked of the controller that made the log.

Coarse integration may step over the limit of bristles that barely hold, to a slip that is none: ``rtol`` 1e-4 does not,
1e-3 does.
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
from leadscrew.plants._ballscrew_stage import INERTIA, BallscrewStageState, stage_jacobian, stage_level

BANDWIDTH = 300.0
"""rad/s, ``sqrt(kp / J)``; a fifth of the sampling rate at most."""


class Logged(NamedTuple):
    """One sample."""

    torque: float = 0.0
    angle: float = 0.0


class PieceParams(NamedTuple):
    """The log, and which piece of it."""

    first: Annotated[float, Doc("sample that the piece starts at")] = 0.0
    length: Annotated[float, Doc("samples of the piece; the last is held from then on")] = 1.0
    torque: Annotated[NDArray[np.float64], Unit("N m"), Doc("held from each sample to the next")] = np.zeros(1)
    angle: Annotated[NDArray[np.float64], Unit("rad"), Doc("at each sample, smooth")] = np.zeros(1)


def piece_step(p, t, dt):
    """The sample at ``t``."""
    row = int(p.first + min(math.floor(t / dt + 0.5), p.length - 1.0))
    return Logged(p.torque[row], p.angle[row])


class FollowParams(NamedTuple):
    """How the model is kept beside the log."""

    kp: Annotated[float, Unit("N m/rad"), Doc("torque per error")] = 33.0


class FollowState(NamedTuple):
    """The error."""

    e: Annotated[float, Unit("rad"), Doc("logged minus modelled angle")] = 0.0


@controller(FollowParams(), FollowState(), unit="N m")
def follow(p, s, command, feedback, dt):
    """The logged torque, plus what keeps the model beside the log."""
    e = command.angle - feedback
    return FollowState(e), command.torque + p.kp * e


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
        controller=follow(kp=inertia * pace * pace),
        plant=replayed_stage(inertia=inertia),
        period=period,
        metrics={},
        method="rodas",
        rtol=1e-4,
        atol=1e-8,
        name="replay of a log",
    )
