"""Experiments with the friction of the study: masses that are pushed, pulled and controlled in continuous time.

One loop serves them all, so that one compiled program does: a force that rises, falls and rests, and a controller that
hands it on, pulls through a spring, or is the PID of Canudas de Wit et al. (1995). Forces and positions are N and m for
the unit mass, N m and rad for the stage.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.analysis.friction import friction_along
from leadscrew.friction.lugre import LuGre, bristle_after, bristle_rate, friction
from leadscrew.kernel.block import Block, controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.sheet import Doc, Ge, Gt, Unit
from leadscrew.plants.ballscrew_gms import ballscrew_gms
from leadscrew.plants.ballscrew_stage import ballscrew_stage
from leadscrew.references.motion import Motion

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run
    from leadscrew.studies.fsmc_ballscrew.runs import Loops

UNIT_MASS = LuGre(coulomb=1.0, static=1.5)
"""Canudas de Wit et al. (1995), Table I: what the stage has, but for the forces of 1 and 1.5 N."""
SLIDES = 0.02
"""Speed at which the stage counts as broken away, rad/s; the digest's."""


class ProfileParams(NamedTuple):
    """A push, a rest, and then a zigzag from ``initial``."""

    push: Annotated[float, Doc("at first")] = 0.0
    push_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    rest: Annotated[float, Unit("s"), Ge(0), Doc("at 0 after the push")] = 0.0
    initial: float = 0.0
    rate: Annotated[float, Unit("1/s")] = 0.0
    turn: Annotated[float, Unit("s"), Gt(0), Doc("when the zigzag first turns; then every second of it")] = 1e9


@reference(ProfileParams())
def profile(p, t):
    """Push, rest, zigzag."""
    since = max(t - p.push_time - p.rest, 0.0)
    turns = math.floor((since / p.turn + 1.0) * 0.5)
    left = since - 2.0 * p.turn * turns
    way = 1.0 if turns - 2.0 * math.floor(0.5 * turns) == 0.0 else -1.0
    return p.push if t < p.push_time else p.initial + p.rate * way * left


class PullParams(NamedTuple):
    """``output = direct command - kv v - kp (x - command) - ki integral``."""

    direct: float = 1.0
    kv: float = 0.0
    kp: float = 0.0
    ki: float = 0.0


class PullState(NamedTuple):
    """Integral of ``x - command``."""

    integral: float = 0.0


@controller(PullParams(), PullState(), continuous=True)
def pull(p, s, command, feedback):
    """Hands on, spring, or PID."""
    error = feedback.position - command
    return PullState(error), p.direct * command - p.kv * feedback.velocity - p.kp * error - p.ki * s.integral


def motion(p, s):
    """Place and speed."""
    return Motion(s.angle, s.speed, 0.0)


STAGE = replace(ballscrew_stage, output=motion, jacobian=None)
"""The stage, showing place and speed."""
MASS = STAGE(inertia=1.0, **{f"friction.{k}": v for k, v in UNIT_MASS._asdict().items()})
"""The unit mass: the same equations with 1 kg, N and m."""


def experiment(loops: Loops, block: Block, seconds: float, sample: float, **parameters: float) -> Run:
    """A run with ``reference`` and ``controller`` parameters by name; place, speed, bristles, force."""
    mine = {k: v for k, v in parameters.items() if k in ProfileParams._fields}
    law = {k: v for k, v in parameters.items() if k in PullParams._fields}
    loop = Loop(reference=profile(**mine), controller=pull(**law), plant=block, period=None, sample=sample, rtol=1e-8,
                atol=1e-12, metrics={})  # fmt: skip
    return loop.run(seconds, record=("plant", "output")).check()


def friction_of(run: Run, f: LuGre) -> np.ndarray:
    """Friction at each sample."""
    return np.array([
        friction(f, v, z, bristle_rate(f, v, z))
        for v, z in zip(run["plant.speed"].tolist(), run["plant.bristle"].tolist(), strict=True)
    ])  # fmt: skip


def crossing(x: np.ndarray, y: np.ndarray, level: float) -> float:
    """``x`` where ``y`` first reaches ``level``, between samples by a straight line through the logarithm of ``y``."""
    i = int(np.argmax(y >= level))
    part = math.log(level / y[i - 1]) / math.log(y[i] / y[i - 1])
    return float(x[i - 1] + part * (x[i] - x[i - 1]))


def peak_friction(loops: Loops, rate: float, highest: float = 1.6) -> float:
    """Largest friction of the unit mass while the force rises at this rate, N/s."""
    run = experiment(loops, MASS, highest / rate, highest / rate / 4000, rate=rate)
    return float(friction_of(run, UNIT_MASS).max())


def peak_after_rest(loops: Loops, rest: float, rate: float = 5.0, highest: float = 1.8) -> float:
    """The same after a push of 0.1 s and a rest."""
    run = experiment(loops, MASS, 0.1 + rest + highest / rate, 4e-4, push=highest, push_time=0.1, rest=rest, rate=rate)
    late = run.time >= 0.1 + rest
    found = friction_of(run, UNIT_MASS)[late]
    return float(found.max())


def break_away_torque(loops: Loops, rate: float, highest: float = 9.36) -> float:
    """Torque, rising at this rate, N m/s, when the stage reaches :data:`SLIDES`; NaN if it does not."""
    run = experiment(loops, STAGE, highest / rate, 1e-4 * highest / rate, rate=rate)
    speed = run["plant.speed"]
    return crossing(run["output"], speed, SLIDES) if speed.max() >= SLIDES else math.nan


class GmsPush(NamedTuple):
    """A torque that rises."""

    rate: Annotated[float, Unit("N m/s")] = 1.0


@reference(GmsPush())
def rising(p, t):
    """The torque."""
    return p.rate * t


@controller()
def handed_on(command):
    """What is asked for."""
    return command


def gms_rise(loops: Loops, rate: float, highest: float, samples: int = 1000, step: float = 1e-6) -> Run:
    """The Maxwell-slip stage under a torque that rises: angle, speed, torque."""
    loop = Loop(reference=rising(rate=rate), controller=handed_on, plant=ballscrew_gms(longest_step=step),
                period=highest / rate / samples, metrics={})  # fmt: skip
    return loop.run(highest / rate, record=("plant.angle", "plant.speed", "output")).check()


class HeldSine(NamedTuple):
    """Torque of the digest's open-loop vector."""

    amplitude: Annotated[float, Unit("N m")] = 11.0
    frequency: Annotated[float, Unit("Hz")] = 2.5


@reference(HeldSine())
def held_sine(p, t):
    """``A sin(2 pi f t)``."""
    return p.amplitude * math.sin(2.0 * math.pi * p.frequency * t)


def held_torque_angle(loops: Loops, seconds: float) -> Run:
    """The stage under the held sine, from rest: 1 ms a hold."""
    loop = Loop(reference=held_sine, controller=handed_on, plant=ballscrew_stage, period=1e-3, method="rodas",
                rtol=1e-9, atol=1e-14, metrics={})  # fmt: skip
    return loop.run(seconds, record=("plant",)).check()


def first_loading(f: Any, x: np.ndarray) -> np.ndarray:
    """Force of a Maxwell-slip model at the deflections of a first slow loading: ``sum min(k_i x, alpha_i F_S)``."""
    return np.minimum(np.outer(x, f.stiffness), np.asarray(f.share) * f.static).sum(axis=1)


def swinging_speed(w: float, f: LuGre = UNIT_MASS, samples: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Speed and friction over the second swing of ``1e-3 (1.5 + cos w t)`` m/s, from rest without force.

    Bristles move by the exact solution at the speed in the middle of each of ``samples`` parts of a swing.
    """
    h = 2.0 * math.pi / w / samples
    z, speeds, forces = 0.0, [], []
    for k in range(2 * samples):
        z = bristle_after(f, 1e-3 * (1.5 + math.cos(w * (k + 0.5) * h)), z, h)
        v = 1e-3 * (1.5 + math.cos(w * (k + 1) * h))
        speeds.append(v)
        forces.append(friction(f, v, z, bristle_rate(f, v, z)))
    return np.array(speeds[samples - 1 :]), np.array(forces[samples - 1 :])


def loop_area(w: float) -> float:
    """Area of the loop of friction against speed, N m/s."""
    speeds, forces = swinging_speed(w, samples=4000 if w < 5.0 else 1000)
    return float(np.trapezoid(forces, speeds))


def bends(f: Any, path: np.ndarray) -> np.ndarray:
    """Friction along a path of the stage, rad, so slow that damping and viscosity do not matter."""
    return friction_along(f, path, 1e3)
