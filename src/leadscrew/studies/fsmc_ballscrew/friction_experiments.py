"""The unit mass of Canudas de Wit et al. (1995) under a rising force: what equations (1) to (3) say of break-away, rest
and hysteresis. Forces and positions are N and m.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from leadscrew.friction.lugre import LuGre, bristle_after, bristle_rate, friction
from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.studies.lab import Lab, measure

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run

UNIT_MASS = LuGre(coulomb=1.0, static=1.5)
"""Canudas de Wit et al. (1995), Table I: the friction of the stage with forces of 1 and 1.5 N."""


class PushParams(NamedTuple):
    """A push, a rest, and then a rise from 0."""

    push: Annotated[float, Doc("at first")] = 0.0
    push_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    rest: Annotated[float, Unit("s"), Ge(0), Doc("at 0 after the push")] = 0.0
    rate: Annotated[float, Unit("1/s")] = 0.0


@reference(PushParams())
def push(p, t):
    """Push, rest, rise."""
    return p.push if t < p.push_time else p.rate * max(t - p.push_time - p.rest, 0.0)


class Distance(NamedTuple):
    """Integral of position less command: it takes part in the choice of the integrator's steps, in nothing else."""

    integral: float = 0.0


@controller(state=Distance(), continuous=True)
def handed_on(s, command, feedback):
    """The force that is asked for."""
    return Distance(feedback.position - command), command


def motion(p, s):
    """Position and speed."""
    return Motion(s.angle, s.speed, 0.0)


MASS = replace(ballscrew_stage, output=motion, jacobian=None)(
    inertia=1.0, **{f"friction.{k}": v for k, v in UNIT_MASS._asdict().items()}
)
"""The unit mass: the equations of the stage with 1 kg, N and m."""


def pushed(lab: Lab, seconds: float, sample: float, **profile: float) -> Run:
    """The unit mass under a force."""
    from leadscrew.kernel.loop import Loop

    loop = Loop(
        reference=push(**profile), controller=handed_on, plant=MASS, period=None, sample=sample, rtol=1e-8,
        atol=1e-12, metrics={},
    )  # fmt: skip
    loop.adopt_program(lab.once(("program", loop.compiled_from()), lambda: loop))
    return loop.run(seconds, record=("plant", "output")).check()


def friction_of(run: Run) -> np.ndarray:
    """Friction of the unit mass at each sample."""
    states = zip(run["plant.speed"].tolist(), run["plant.bristle"].tolist(), strict=True)
    return np.array([friction(UNIT_MASS, v, z, bristle_rate(UNIT_MASS, v, z)) for v, z in states])


@measure
def peak_friction(lab: Lab, rate: float, highest: float = 1.6) -> float:
    """Largest friction of the unit mass while the force rises at this rate, N/s."""
    run = pushed(lab, highest / rate, highest / rate / 4000, rate=rate)
    return float(friction_of(run).max())


@measure
def peak_after_rest(lab: Lab, rest: float, rate: float = 5.0, highest: float = 1.8) -> float:
    """The same after a push of 0.1 s and a rest."""
    run = pushed(lab, 0.1 + rest + highest / rate, 4e-4, push=highest, push_time=0.1, rest=rest, rate=rate)
    return float(friction_of(run)[run.time >= 0.1 + rest].max())


def loop_area(w: float) -> float:
    """Area of the loop of friction against speed, N m/s, over the second swing of ``1e-3 (1.5 + cos w t)`` m/s.

    From rest without force; the bristles move by the exact solution at the speed in the middle of each part of a swing.
    """
    samples = 4000 if w < 5.0 else 1000
    h, z, speeds, forces = 2.0 * math.pi / w / samples, 0.0, [], []
    for k in range(2 * samples):
        z = bristle_after(UNIT_MASS, 1e-3 * (1.5 + math.cos(w * (k + 0.5) * h)), z, h)
        v = 1e-3 * (1.5 + math.cos(w * (k + 1) * h))
        speeds.append(v)
        forces.append(friction(UNIT_MASS, v, z, bristle_rate(UNIT_MASS, v, z)))
    return float(np.trapezoid(forces[samples - 1 :], speeds[samples - 1 :]))
