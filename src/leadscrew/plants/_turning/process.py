"""The feed of a retrofitted lathe and the cutting force that it makes: from a feed voltage to newtons.

The voltage is held over each step of ``dt`` (1 ms), and ``a`` is the rate of the feed:

1. ``theta += n dt / 60``                                                         spindle, revolutions
2. ``dv/dt = a``, ``da/dt = w^2 (clip(gain u, 0, max_feed) - v) - 2 zeta w a``    feed servo, mm/min, exact
3. ``x += integral of v / 60``, ``v >= 0``                                        carriage, mm, exact
4. chip, force and surface: :mod:`leadscrew.plants._turning.chip`, with the depth ``b + runout sin(2 pi theta)``

``u`` acts ``dead_time_s`` late. The depth ``b`` follows its programme through the radial servo,
``lag_s dv_b/dt = gain (programme - b) - v_b``, ``db/dt = v_b``, exact for the programme in the middle of the step; with
``gain = 0`` at once. ``load`` is the relative change of the specific force: 1.0 is a hard spot that doubles it.

What is left of the step is the straight line by which the surface goes between two places: steps of 1 ms differ from
steps of 0.02 ms by less than 0.1 % in overshoot, rise and steady error (``docs/turning.md``).

Refused is a spindle that turns by more than :data:`MOST_OF_A_TURN` a step, for then the surface of one revolution ago
is not there yet.

Source: equation (1) of the paper of the study ``grey_turning`` for the steady force; servo, chip build-up over a
revolution, compliance and runout are a reconstruction (plant F of the study: servo of 40 rad/s, fitted to two
figures). The whole lathe, with its three loops: :obj:`leadscrew.plants.turning_lathe`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._turning.chip import CELLS, CuttingLaw, blank, cut, leave_surface, surface_before
from leadscrew.references._cutting_program import DepthProgram, depth_at
from leadscrew.util.errors import ValueRefused

SENT = 64
"""Steps of the feed voltage that are kept: the dead time is shorter."""

MOST_OF_A_TURN = (CELLS - 1) / CELLS
"""Largest turn of the spindle in one step, revolutions: straight lines between two places of the surface need both."""

BEFORE = 0.999
"""Where in a step a depth that follows at once is read: at its end, before a change that comes then."""

TINY = 1e-30


class FeedServo(NamedTuple):
    """The servo that drives the carriage along the work."""

    gain: Annotated[float, Unit("mm/(min V)"), Gt(0), Doc("feed at 1 V")] = 150.0
    rate: Annotated[float, Unit("rad/s"), Gt(0), Doc("natural frequency")] = 40.0
    damping: Annotated[float, Gt(0), Doc("damping ratio")] = 0.7
    max_feed: Annotated[float, Unit("mm/min"), Gt(0), Doc("largest feed")] = 150.0
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
    travel: Annotated[float, Unit("mm"), Doc("travel of the carriage")] = 0.0
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
    travel: Annotated[float, Unit("mm"), Doc("travel of the carriage")] = 0.0
    turns: Annotated[float, Unit("rev"), Doc("angle of the spindle")] = 0.0


class Hold(NamedTuple):
    """The exact step of ``y'' + 2 zeta w y' + w^2 y = 0`` over ``dt``: what each initial value leaves."""

    y_of_y: float
    y_of_rate: float
    rate_of_y: float
    rate_of_rate: float
    area_of_y: float
    """Of the integral of ``y`` over the step."""
    area_of_rate: float


def hold(rate: float, damping: float, dt: float) -> Hold:
    """The step of a second-order lag with the natural frequency ``rate``, 1/s."""
    m, q = damping * rate * dt, (damping * damping - 1.0) * (rate * dt) ** 2
    root = math.sqrt(abs(q))
    slow, quick = math.exp(root - m) if q > 0.0 else 0.0, math.exp(-root - m) if q > 0.0 else 0.0
    even = 0.5 * (slow + quick) if q > 0.0 else math.exp(-m) * math.cos(root)
    odd = 0.5 * (slow - quick) / root if q > 0.0 else math.exp(-m) * math.sin(root) / root if q < 0.0 else math.exp(-m)
    drag, w2 = 2.0 * damping * rate, rate * rate
    yy, yr, ry, rr = even + m * odd, dt * odd, -w2 * dt * odd, even - m * odd
    return Hold(yy, yr, ry, rr, -(ry + drag * (yy - 1.0)) / w2, -(rr - 1.0 + drag * yr) / w2)


class Moved(NamedTuple):
    """A lag one step later, and the integral of its output over the step."""

    value: float
    rate: float
    area: float


def lag_step(h, asked, value, rate, dt):
    """A second-order lag one step later, its input held."""
    y = value - asked
    next_rate = h.rate_of_y * y + h.rate_of_rate * rate
    return Moved(
        asked + h.y_of_y * y + h.y_of_rate * rate,
        next_rate if abs(next_rate) > TINY else 0.0,
        asked * dt + h.area_of_y * y + h.area_of_rate * rate,
    )


class FeedHold(NamedTuple):
    """The feed servo as its step reads it."""

    gain: float
    max_feed: float
    step: Hold


def feed_hold(servo: FeedServo, dt: float) -> FeedHold:
    """The exact step of a feed servo."""
    return FeedHold(servo.gain, servo.max_feed, hold(servo.rate, servo.damping, dt))


def fed(servo, feed, rate, u, dt):
    """The feed servo one step later; it does not run backwards. The integral is of the feed."""
    moved = lag_step(servo.step, min(max(servo.gain * u, 0.0), servo.max_feed), feed, rate, dt)
    return Moved(max(moved.value, 0.0), moved.rate, max(moved.area, 0.0))


class TurningPlan(NamedTuple):
    """The parameters, and the dead time in steps."""

    law: CuttingLaw
    spindle_rpm: float
    depth: DepthProgram
    servo: FeedHold
    follows: bool
    radial: Hold
    yielding: float
    runout: float
    late: int


def checked_step(servo: FeedServo, rpm: float, speed: str, dt: float, where: str) -> int:
    """The dead time in steps; what a step of ``dt`` cannot follow is refused.

    Args:
        servo: the feed servo.
        rpm: largest spindle speed, 1/min.
        speed: name of the parameter that gives it.
        dt: step, s.
        where: name of the plant.

    Raises:
        ValueRefused: a dead time of 64 steps or more, or more than :data:`MOST_OF_A_TURN` of the spindle a step.
    """
    late = round(servo.dead_time_s / dt)
    if late >= SENT:
        raise ValueRefused(
            f"servo.dead_time_s = {servo.dead_time_s!r} ({where}): less than {SENT} steps, here {SENT * dt:g} s"
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
        ValueRefused: what :func:`checked_step` refuses.
    """
    late = checked_step(params.servo, params.spindle_rpm, "spindle_rpm", dt, "turning")
    gain, lag_s = params.radial
    follows = gain > 0.0
    radial = hold(math.sqrt(gain / lag_s), 0.5 / math.sqrt(gain * lag_s), dt) if follows else hold(1.0, 1.0, dt)
    return TurningPlan(
        params.law, params.spindle_rpm, params.depth, feed_hold(params.servo, dt), follows, radial,
        params.feed_force_ratio / params.stiffness, params.runout, late,
    )  # fmt: skip


def begun(params: TurningParams) -> TurningState:
    """Everything at rest, the tool at the programmed depth."""
    return TurningState(depth=float(depth_at(params.depth, 0.0)), sent=np.zeros(SENT), ring=blank())


def shown(p, s):
    """Force, feed, chip and depth; carriage and spindle."""
    return Turned(s.force, s.feed, s.chip, s.depth, s.travel, s.turns)


@plant(TurningParams, TurningState, output=shown, prepare=planned, initial=begun, unit="N", drive="voltage")
def turning(p, s, u, load, t, dt):
    """Feed servo, chip and cutting force of a lathe at a given spindle speed: state one step later."""
    s.sent[s.at] = u
    late = s.at - p.late
    servo = fed(p.servo, s.feed, s.feed_rate, s.sent[late if late >= 0 else late + SENT], dt)
    turns = s.turns + p.spindle_rpm * dt / 60.0
    travel = s.travel + servo.area / 60.0

    across = lag_step(p.radial, depth_at(p.depth, t + 0.5 * dt), s.depth, s.depth_speed, dt)
    depth = across.value if p.follows else depth_at(p.depth, t + BEFORE * dt)

    before = surface_before(s.ring, turns)
    width = max(depth + p.runout * math.sin(2.0 * math.pi * turns), 0.0)
    width = width if depth > 0.0 else 0.0
    hard = CuttingLaw(p.law.kf * max(1.0 + load, 0.0), p.law.exponent)
    now = cut(hard, width, p.yielding, travel - before)
    surface = max(travel - p.yielding * now.force, before)
    place = leave_surface(s.ring, s.turns, s.surface, turns, surface)
    at = s.at + 1 if s.at + 1 < SENT else 0
    return TurningState(
        now.force, max(s.peak, now.force), now.chip, servo.value, servo.rate, travel, turns, surface, depth,
        across.rate if p.follows else 0.0, place, at, s.sent, s.ring,
    )  # fmt: skip
