"""Experiments with friction models: the steady curve, the force along an imposed path, break-away and stick-slip.

A friction is the parameters of a model of :mod:`leadscrew.friction`. Forces are those that the friction puts against a
positive motion. In the experiments with a mass, break-away and stick-slip, a plant is a mass under one
of these models, such as ``mass_lugre``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.friction import dahl, lugre, maxwell_slip
from leadscrew.friction.asymmetric import TwoSidedLuGre, one_way_lugre
from leadscrew.friction.static_map import TwoSided, sliding_friction
from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Ge, Unit
from leadscrew.plants._backlash_two_mass import backlash_two_mass
from leadscrew.references._ramp import ramp
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.run import Run


def friction_velocity(f: Any, speeds: Any) -> np.ndarray:
    """Friction in steady sliding at each speed; 0 at rest, where a static map has a jump."""
    speeds = np.asarray(speeds, dtype=float)
    return np.array([_steady(f, float(v)) for v in speeds.ravel()]).reshape(speeds.shape)


def _steady(f: Any, v: float) -> float:
    if isinstance(f, TwoSided | TwoSidedLuGre):
        return float(sliding_friction(f, v))
    if isinstance(f, dahl.Dahl):
        return float(np.sign(v) * f.coulomb + f.viscous * v)
    return float(np.sign(v) * lugre.level(f, v) + f.viscous * v)


def friction_along(f: Any, positions: Any, dt: float) -> np.ndarray:
    """Friction at each sample of an imposed path, from rest without force.

    The speed is constant between samples; a sample has the speed with which it was reached.

    Raises:
        ValueRefused: a static map, which has no friction before sliding; elements that make no sense; no path or time.
    """
    positions = np.asarray(positions, dtype=float)
    if positions.ndim != 1 or positions.size == 0 or not np.isfinite(positions).all():
        raise ValueRefused(f"positions of shape {positions.shape}: a path is one row of finite numbers, at least one")
    positive("dt", dt)
    speeds = np.diff(positions) / dt
    if isinstance(f, dahl.Dahl):
        forces = _along_dahl(f, speeds, dt)
    elif isinstance(f, maxwell_slip.MaxwellSlip | maxwell_slip.MaxwellSlipScrew):
        forces = _along_elements(maxwell_slip.checked(f), speeds, dt)
    elif hasattr(f, "stiffness"):
        forces = _along_lugre(f, speeds, dt)
    else:
        raise ValueRefused(
            f"{type(f).__name__} has no friction before sliding; a path needs Dahl, LuGre or MaxwellSlip"
        )
    return np.array([0.0, *forces])


def _along_dahl(f: Any, speeds: np.ndarray, dt: float) -> list[float]:
    force, out = 0.0, []
    for v in speeds.tolist():
        force = dahl.force_after(f, v * dt, force)
        out.append(force + f.viscous * v)
    return out


def _along_lugre(f: Any, speeds: np.ndarray, dt: float) -> list[float]:
    z, out = 0.0, []
    for v in speeds.tolist():
        now = one_way_lugre(f, v) if isinstance(f, TwoSidedLuGre) else f
        z = lugre.bristle_after(now, v, z, dt)
        out.append(lugre.friction(now, v, z, lugre.bristle_rate(now, v, z)))
    return out


def _along_elements(
    f: maxwell_slip.MaxwellSlip | maxwell_slip.MaxwellSlipScrew, speeds: np.ndarray, dt: float
) -> list[float]:
    e, out = maxwell_slip.unloaded(f), []
    share_of_damping = f.damping / maxwell_slip.total_stiffness(f)
    for v in speeds.tolist():
        e = maxwell_slip.move_elements(f, e, v, dt)
        damping = share_of_damping * maxwell_slip.stuck_stiffness(f, e) + f.viscous
        out.append(maxwell_slip.elements_force(e) + damping * v)
    return out


def path_through(points: Sequence[float], step: float) -> np.ndarray:
    """Positions from point to point in equal steps of about ``step``; each point is met exactly."""
    parts = [np.asarray(points[:1], dtype=float)]
    for a, b in pairwise(points):
        n = max(1, round(abs(b - a) / step))
        parts.append(a + (b - a) * np.arange(1, n + 1) / n)
    return np.concatenate(parts)


def positive(name: str, *values: float) -> None:
    """Refuses values that are not positive and finite."""
    for value in values:
        if not 0.0 < value < np.inf:
            raise ValueRefused(f"{name} = {value!r}: a positive finite number is needed")


TIGHT: dict[str, Any] = {"method": "rodas", "rtol": 1e-8, "atol": 1e-12}
"""For plants that the loop integrates."""
OWN_STEPS = 20
"""Steps of a period for plants that bring their own."""


def _moving(plant: Block, *params: str) -> None:
    """Refuses a plant without a speed, or without these parameters."""
    if not hasattr(plant.state, "speed") or not all(hasattr(plant.params, name) for name in params):
        raise ValueRefused(f"{plant.name} is not one mass with a speed; take a plant such as mass_lugre")


class PushParams(NamedTuple):
    """A push that makes the mass slide, a rest, and a force that rises."""

    push: Annotated[float, Unit("N")] = 0.0
    push_time: Annotated[float, Unit("s"), Ge(0)] = 0.0
    rest: Annotated[float, Unit("s"), Ge(0)] = 0.0
    rate: Annotated[float, Unit("N/s")] = 1.0


@reference(PushParams())
def _push_rest_rise(p, t):
    """The force of the break-away experiments."""
    return p.push if t < p.push_time else p.rate * max(t - p.push_time - p.rest, 0.0)


@controller()
def _through(command):
    """What is asked for."""
    return command


def _method(plant: Block, tolerances: dict[str, Any]) -> dict[str, Any]:
    return {"substeps": OWN_STEPS} if "dt" in plant.signals else tolerances


def _peak(plant: Block, push: Block, seconds: float, period: float, after: float) -> float:
    loop = Loop(reference=push, controller=_through, plant=plant, period=period, metrics={}, **_method(plant, TIGHT))
    run = loop.run(seconds, record=("output", "plant.speed")).check()
    friction = run["output"][:-1] - plant.params.mass * np.diff(run["plant.speed"]) / period
    return float(friction[run.time[:-1] >= after].max())


def break_away(plant: Block, rates: Sequence[float], highest: float = 1.6) -> np.ndarray:
    """Largest friction while the force on a mass at rest rises at each rate, N/s, up to ``highest``, N.

    Friction is the mean over a period (1/8000 of the rise): force minus mass times acceleration.

    Raises:
        ValueRefused: a rate or a force that is not positive; a plant that is not one mass.
    """
    _moving(plant, "mass")
    positive("highest", highest)
    positive("rate", *rates)
    return np.array([_peak(plant, _push_rest_rise(rate=r), highest / r, highest / r / 8000, 0.0) for r in rates])


def force_at_speed(plant: Block, rates: Sequence[float], faster_than: float, highest: float) -> np.ndarray:
    """Force, rising at each rate from rest up to ``highest``, when the speed first reaches ``faster_than``; else NaN.

    Of the ball-screw stage a torque, for a speed in rad/s. A plant that the loop integrates gets a force that truly
    rises, 1/100,000 of ``highest`` between samples: held for a period instead it shakes the bristles loose (the stage
    at 0.05 N m/s and 10 ms lets go at 9.22 N m in place of 9.28). One that brings its own step gets 1/8000.

    Raises:
        ValueRefused: a number that is not positive; a plant without a speed.
    """
    _moving(plant)
    for name, values in (("rate", rates), ("highest", [highest]), ("faster_than", [faster_than])):
        positive(name, *values)
    own, found = "dt" in plant.signals, []
    for rate in rates:
        parts: dict[str, Any] = {
            "reference": _push_rest_rise(rate=rate), "controller": _through, "plant": plant, "metrics": {},
        }  # fmt: skip
        if own:
            loop = Loop(period=highest / rate / 8000, substeps=OWN_STEPS, **parts)
        else:
            loop = Loop(period=None, sample=1e-5 * highest / rate, rtol=1e-8, atol=1e-12, **parts)
        run = loop.run(highest / rate, record=("output", "plant.speed")).check()
        over = np.flatnonzero(run["plant.speed"] >= faster_than)
        found.append(float(run["output"][over[0]]) if over.size else np.nan)
    return np.array(found)


def break_away_after_rest(plant: Block, rests: Sequence[float], rate: float = 5.0, highest: float = 1.8) -> np.ndarray:
    """Largest friction in a rise of ``rate``, N/s, after the mass has slid, stopped, and rested under no force.

    The push of ``highest`` lasts 0.1 s; the rests, in s, count from its end, so the first part of each is the stop.

    Raises:
        ValueRefused: a number that is not positive; a plant that is not one mass.
    """
    _moving(plant, "mass")
    positive("rest", *rests)
    positive("rate", rate)
    positive("highest", highest)
    found = []
    for rest in rests:
        push = _push_rest_rise(push=highest, push_time=0.1, rest=rest, rate=rate)
        found.append(_peak(plant, push, 0.1 + rest + highest / rate, 2e-4, 0.1 + rest))
    return np.array(found)


class SpringParams(NamedTuple):
    """A spring between the puller, whose place is the command, and the mass."""

    stiffness: Annotated[float, Unit("N/m"), Ge(0)] = 2.0


@controller(SpringParams())
def _spring(p, command, feedback):
    """The spring's force on the mass."""
    return p.stiffness * (command - feedback)


def stick_slip(
    plant: Block, stiffness: float = 2.0, speed: float = 0.1, seconds: float = 25.0, sample: float = 1e-3
) -> Run:
    """A mass pulled by a spring whose other end moves at a constant speed: command, actual and speed against time.

    A plant that brings its own step gets the spring's force held for a ``sample``; others are solved as one continuous
    system.

    Raises:
        ValueRefused: a stiffness, speed or time that is not positive; a plant that is not one mass.
    """
    for name, value in (("stiffness", stiffness), ("speed", speed), ("seconds", seconds), ("sample", sample)):
        positive(name, value)
    _moving(plant)
    parts: dict[str, Any] = {
        "reference": ramp(rate=speed, duration=seconds + 1.0),
        "controller": _spring(stiffness=stiffness),
        "plant": plant,
        "metrics": {},
    }
    if "dt" in plant.signals:
        loop = Loop(period=sample, substeps=OWN_STEPS, **parts)
    else:
        loop = Loop(period=None, sample=sample, rtol=1e-8, atol=1e-12, **parts)
    return loop.run(seconds, record=("command", "actual", "output", "plant.speed")).check()


def slip_times(run: Run, faster_than: float) -> np.ndarray:
    """When the mass of a stick-slip run starts to move faster than this, between samples by a straight line."""
    t, v = run.time, run["plant.speed"]
    i = np.flatnonzero((v[:-1] < faster_than) & (v[1:] >= faster_than))
    return t[i] + (faster_than - v[i]) / (v[i + 1] - v[i]) * (t[i + 1] - t[i])


# ---- a screw that moves as it is told, and the table behind its play
HEAVY = 1e12
"""A motor of this mass, kg, moves as it is told: the screw's place is imposed."""


class SineForceParams(NamedTuple):
    """The force that moves a mass by ``radius sin(rate t)``."""

    mass: Annotated[float, Unit("kg")] = HEAVY
    radius: Annotated[float, Unit("m")] = 1e-3
    rate: Annotated[float, Unit("rad/s")] = 2.0 * math.pi


@reference(SineForceParams())
def _sine_force(p, t):
    """Mass times acceleration."""
    return -p.mass * p.radius * p.rate * p.rate * math.sin(p.rate * t)


def imposed_loop(radius: float, rate: float, restitution: float, sample: float = 5e-5, **changes: float) -> Loop:
    """The loop of :func:`imposed_reversal`; ``changes`` are parameters of the plant."""
    two = backlash_two_mass(motor_mass=HEAVY, motor_viscous=0.0, restitution=restitution, **changes)
    guide, joint = two.params.guide, two.params.joint
    pressed = (guide.coulomb + guide.viscous * radius * rate) / joint.forward_stiffness
    plant = two.starting(
        motor_speed=radius * rate,
        table_speed=radius * rate,
        table=-joint.forward_gap - pressed,
        bristle=guide.coulomb / guide.stiffness,
    )
    return Loop(
        reference=_sine_force(radius=radius, rate=rate), controller=_through, plant=plant, period=None, sample=sample,
        rtol=1e-6, atol=1e-12, metrics={},
    )  # fmt: skip


def imposed_reversal(radius: float, rate: float, restitution: float, sample: float = 5e-5) -> Run:
    """Three quarters of a turn of ``radius sin(rate t)`` of the screw, in m and rad/s, and the table behind its play.

    Starts on the forward flank, pressed by the guide's friction; turns at ``t = pi / (2 rate)``.
    """
    loop = imposed_loop(radius, rate, restitution, sample)
    return loop.run(0.75 * 2.0 * math.pi / rate, record=("plant",)).check()
