"""The feed of a retrofitted lathe and the cutting force that it makes: from a feed voltage to newtons.

In this order in each step of ``dt`` (1 ms or less), semi-implicit Euler:

1. ``theta += n dt / 60``                                                         spindle, revolutions
2. ``a += (w^2 (clip(gain u, 0, most) - v) - 2 zeta w a) dt``, ``v = max(v + a dt, 0)``      feed servo, mm/min
3. ``x += v dt / 60``                                                             carriage, mm
4. chip, force and surface: :mod:`leadscrew.plants.turning.chip`, with the depth ``b + runout sin(2 pi theta)``

``u`` acts ``dead_time_s`` late. The depth ``b`` follows its programme through the radial servo,
``lag_s dv_b/dt = gain (programme - b) - v_b``, ``db/dt = v_b``; with ``gain = 0`` at once. ``load`` is the relative
change of the specific force: 1.0 is a hard spot that doubles it.

Refused are steps with which this order of calculation says nothing: a servo that swings up by the step alone
(:func:`servo_limit`), and a spindle that turns by more than :data:`MOST_OF_A_TURN` a step, for then the surface of one
revolution ago is not there yet.

Source: equation (1) of the paper of the study ``grey_turning`` for the steady force; servo, chip build-up over a
revolution, compliance and runout are a reconstruction (plant F of the study: servo of 40 rad/s, fitted to two
figures). The whole lathe, with its three loops: :mod:`leadscrew.plants.turning_lathe`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.sheet import Doc, Ge, Gt, Unit
from leadscrew.plants.turning.chip import CELLS, CuttingLaw, blank, cut, leave_surface, surface_before
from leadscrew.references.cutting_program import DepthProgram, depth_at

SENT = 64
"""Steps of the feed voltage that are kept: the dead time is shorter."""

MOST_OF_A_TURN = (CELLS - 1) / CELLS
"""Largest turn of the spindle in one step, revolutions: straight lines between two places of the surface need both."""

TINY = 1e-30


class FeedServo(NamedTuple):
    """The servo that drives the carriage along the work."""

    gain: Annotated[float, Unit("mm/(min V)"), Gt(0), Doc("feed at 1 V")] = 150.0
    rate: Annotated[float, Unit("rad/s"), Gt(0), Doc("natural frequency")] = 40.0
    damping: Annotated[float, Gt(0), Doc("damping ratio")] = 0.7
    most: Annotated[float, Unit("mm/min"), Gt(0), Doc("largest feed")] = 150.0
    dead_time_s: Annotated[float, Unit("s"), Ge(0), Doc("from the voltage to the servo, less than 64 steps")] = 0.0


class RadialServo(NamedTuple):
    """How the depth of cut follows its programme."""

    gain: Annotated[float, Unit("1/s"), Ge(0), Doc("speed per error; 0: the depth changes at once")] = 0.0
    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of its speed")] = 0.017


class TurningParams(NamedTuple):
    """Material, machine and depth of cut."""

    law: CuttingLaw = CuttingLaw()
    spindle_rpm: Annotated[float, Unit("1/min"), Gt(0), Doc("spindle speed")] = 1200.0
    depth: DepthProgram = DepthProgram()
    servo: FeedServo = FeedServo()
    radial: RadialServo = RadialServo()
    stiffness: Annotated[float, Unit("N/mm"), Gt(0), Doc("of tool and work along the feed")] = 20000.0
    feed_force_ratio: Annotated[
        float, Gt(0), Doc("force along the feed over the main force; 1: plant F, 0.5: usual")
    ] = 1.0
    runout: Annotated[float, Unit("mm"), Ge(0), Doc("amplitude of the depth's change over a revolution")] = 0.01


class TurningState(NamedTuple):
    """Drives, surface and cut."""

    force: Annotated[float, Unit("N"), Doc("main cutting force")] = 0.0
    peak: Annotated[float, Unit("N"), Doc("largest force so far")] = 0.0
    chip: Annotated[float, Unit("mm"), Doc("chip thickness")] = 0.0
    feed: Annotated[float, Unit("mm/min"), Doc("speed of the carriage")] = 0.0
    feed_rate: Annotated[float, Unit("mm/(min s)"), Doc("its rate of change")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("way of the carriage")] = 0.0
    turns: Annotated[float, Unit("rev"), Doc("angle of the spindle")] = 0.0
    surface: Annotated[float, Unit("mm"), Doc("surface that the edge leaves")] = 0.0
    depth: Annotated[float, Unit("mm"), Doc("depth of cut, without runout")] = 1.0
    depth_speed: Annotated[float, Unit("mm/s"), Doc("its speed")] = 0.0
    place: Annotated[int, Doc("last place of the surface that is cut, 256 a revolution")] = 0
    at: Annotated[int, Doc("place of the next voltage")] = 0
    sent: Annotated[np.ndarray, Doc("voltages of the last steps")] = np.zeros(SENT)
    ring: Annotated[np.ndarray, Doc("surface of the last revolution, by angle")] = blank()


class Turned(NamedTuple):
    """What happens at the edge."""

    force: Annotated[float, Unit("N"), Doc("main cutting force")] = 0.0
    feed: Annotated[float, Unit("mm/min"), Doc("speed of the carriage")] = 0.0
    chip: Annotated[float, Unit("mm"), Doc("chip thickness")] = 0.0
    depth: Annotated[float, Unit("mm"), Doc("depth of cut without runout")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("way of the carriage")] = 0.0
    turns: Annotated[float, Unit("rev"), Doc("angle of the spindle")] = 0.0


class TurningPlan(NamedTuple):
    """The parameters, and the dead time in steps."""

    law: CuttingLaw
    spindle_rpm: float
    depth: DepthProgram
    servo: FeedServo
    radial: RadialServo
    yielding: float
    runout: float
    late: int


def servo_limit(damping: float) -> float:
    """Below which ``rate dt`` the servo's step is stable: ``2 (sqrt(1 + zeta^2) - zeta)``.

    Semi-implicit Euler has the characteristic polynomial ``z^2 - (2 - 2 zeta x - x^2) z + 1 - 2 zeta x`` with
    ``x = rate dt``; its roots lie inside the unit circle while ``x^2 + 4 zeta x < 4`` (Jury's criterion at ``z = -1``;
    the other conditions follow from it).
    """
    return 2.0 / (math.hypot(1.0, damping) + damping)


def checked_step(servo: FeedServo, rpm: float, speed: str, dt: float, where: str) -> int:
    """The dead time in steps; what a step of ``dt`` cannot follow is refused.

    Args:
        servo: the feed servo.
        rpm: largest spindle speed, 1/min.
        speed: name of the parameter that gives it.
        dt: step, s.
        where: name of the plant.

    Raises:
        ValueRefused: a dead time of 64 steps or more, a servo that is unstable with this step, or more than
            :data:`MOST_OF_A_TURN` of the spindle a step.
    """
    late = round(servo.dead_time_s / dt)
    if late >= SENT:
        raise ValueRefused(
            f"servo.dead_time_s = {servo.dead_time_s!r} ({where}): less than {SENT} steps, here {SENT * dt:g} s"
        )
    most = servo_limit(servo.damping) / dt
    if servo.rate >= most:
        raise ValueRefused(
            f"servo.rate = {servo.rate!r} rad/s ({where}): less than {most:.6g} rad/s at a damping of "
            f"{servo.damping:g} and steps of {dt:g} s, for beyond it the step itself is unstable; take more substeps"
        )
    fastest = 60.0 * MOST_OF_A_TURN / dt
    if rpm > fastest:
        raise ValueRefused(
            f"{speed} = {rpm!r} 1/min ({where}): at most {fastest:.6g} 1/min with steps of {dt:g} s, for a step must "
            "be less than a revolution; take more substeps"
        )
    return late


def planned(params: TurningParams, dt: float) -> TurningPlan:
    """The parameters as the step reads them.

    Raises:
        ValueRefused: what :func:`checked_step` refuses, or a radial servo that is unstable with this step.
    """
    late = checked_step(params.servo, params.spindle_rpm, "spindle_rpm", dt, "turning")
    least = 0.25 * dt * (2.0 + params.radial.gain * dt)
    if params.radial.gain > 0.0 and params.radial.lag_s <= least:
        raise ValueRefused(
            f"radial.lag_s = {params.radial.lag_s!r} s (turning): more than {least:.6g} s at a gain of "
            f"{params.radial.gain:g} 1/s and steps of {dt:g} s, for below it the step itself is unstable; take more "
            "substeps"
        )
    return TurningPlan(
        params.law, params.spindle_rpm, params.depth, params.servo, params.radial,
        params.feed_force_ratio / params.stiffness, params.runout, late,
    )  # fmt: skip


def begun(params: TurningParams) -> TurningState:
    """Everything at rest, the tool at the programmed depth."""
    return TurningState(depth=float(depth_at(params.depth, 0.0)), sent=np.zeros(SENT), ring=blank())


class Servo(NamedTuple):
    """Feed and its rate."""

    feed: float
    rate: float


def servo_step(servo, feed, rate, u, dt):
    """The feed servo one step later."""
    asked = min(max(servo.gain * u, 0.0), servo.most)
    next_rate = rate + dt * (servo.rate * servo.rate * (asked - feed) - 2.0 * servo.damping * servo.rate * rate)
    kept = next_rate if abs(next_rate) > TINY else 0.0
    return Servo(max(feed + dt * kept, 0.0), kept)


def shown(p, s):
    """Force, feed, chip and depth; carriage and spindle."""
    return Turned(s.force, s.feed, s.chip, s.depth, s.travel, s.turns)


@plant(TurningParams(), TurningState(), output=shown, prepare=planned, initial=begun, unit="N")
def turning(p, s, u, load, t, dt):
    """Feed servo, chip and cutting force of a lathe at a given spindle speed: state one step later."""
    s.sent[s.at] = u
    late = s.at - p.late
    servo = servo_step(p.servo, s.feed, s.feed_rate, s.sent[late if late >= 0 else late + SENT], dt)
    turns = s.turns + p.spindle_rpm * dt / 60.0
    travel = s.travel + servo.feed * dt / 60.0

    asked = depth_at(p.depth, t)
    speed = s.depth_speed + dt * (p.radial.gain * (asked - s.depth) - s.depth_speed) / p.radial.lag_s
    moved = speed if abs(speed) > TINY else 0.0
    follows = p.radial.gain > 0.0
    depth = s.depth + dt * moved if follows else asked

    before = surface_before(s.ring, turns)
    width = max(depth + p.runout * math.sin(2.0 * math.pi * turns), 0.0)
    width = width if depth > 0.0 else 0.0
    hard = CuttingLaw(p.law.kf * max(1.0 + load, 0.0), p.law.exponent)
    now = cut(hard, width, p.yielding, travel - before)
    surface = max(travel - p.yielding * now.force, before)
    place = leave_surface(s.ring, s.turns, s.surface, turns, surface)
    at = s.at + 1 if s.at + 1 < SENT else 0
    return TurningState(
        now.force, max(s.peak, now.force), now.chip, servo.feed, servo.rate, travel, turns, surface, depth,
        moved if follows else 0.0, place, at, s.sent, s.ring,
    )  # fmt: skip
