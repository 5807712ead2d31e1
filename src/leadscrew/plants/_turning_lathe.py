"""The whole retrofitted lathe: spindle, carriage and cross slide, coupled by the cut.

Three voltages go in, held over each step of ``dt`` (1 ms). The drives are stepped by their exact solutions; the torque
that acts on the spindle is the mean of the step's. In this order:

1. ``theta``, with the mean speed of the step          spindle, revolutions
2. feed servo and carriage ``x``                       as :mod:`leadscrew.plants._turning.process`
3. cross slide: depth ``b``                            :mod:`leadscrew.plants._turning.radial`
4. stock and hardness at ``x``                         :mod:`leadscrew.plants._turning.workpiece`
5. chip, force, surface one revolution ago             :mod:`leadscrew.plants._turning.chip`
6. ``T = F D / 2000``, and the speed that it leaves    :mod:`leadscrew.plants._turning.spindle`

What couples the loops: the torque slows the spindle down; a slower spindle makes a thicker chip at the same feed, so
the force rises; and the force is in proportion to the depth. Nothing acts back on the depth: tool and work give way
along the feed only.

Accounts, for what constant force is for: ``removed = sum b h pi D n dt / 60``, mm^3, exact over an entry too;
``peak`` force; ``over_s``, time with a force above ``limit``. ``load``: relative change of the specific force, besides
that of the workpiece.

Source: sections 1 and 2 of the paper of the study ``grey_turning``; its numbers are ours.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._turning.chip import CuttingLaw, blank, cut, leave_surface, surface_before
from leadscrew.plants._turning.process import SENT, FeedHold, FeedServo, checked_step, fed, feed_hold
from leadscrew.plants._turning.radial import Cross, CrossHold, CrossServo, cross_hold, moved_across
from leadscrew.plants._turning.spindle import (
    Spindle,
    SpindleHold,
    SpindleMotor,
    cutting_torque,
    spindle_hold,
    turned_on,
)
from leadscrew.plants._turning.workpiece import Workpiece, checked, stock_at


class LatheStart(NamedTuple):
    """Where the lathe stands at the start."""

    rpm: Annotated[float, Unit("1/min"), Ge(0), Doc("spindle speed")] = 1200.0
    depth: Annotated[float, Unit("mm"), Doc("depth of the tool below the nominal surface")] = 1.0


class TurningLatheParams(NamedTuple):
    """Material, work and machine."""

    law: CuttingLaw = CuttingLaw()
    work: Workpiece = Workpiece()
    spindle: SpindleMotor = SpindleMotor()
    servo: FeedServo = FeedServo()
    cross: CrossServo = CrossServo()
    start: LatheStart = LatheStart()
    stiffness: Annotated[float, Unit("N/mm"), Gt(0), Doc("of tool and work along the feed")] = 20000.0
    feed_force_ratio: Annotated[
        float, Gt(0), Doc("force along the feed over the main force; 1: plant F, 0.5: usual")
    ] = 1.0
    runout: Annotated[float, Unit("mm"), Ge(0), Doc("amplitude of the depth's change over a revolution")] = 0.01
    limit: Annotated[float, Unit("N"), Gt(0), Doc("force above which time is counted")] = 1e9


class TurningLatheState(NamedTuple):
    """Drives, surface, cut and accounts."""

    force: Annotated[float, Unit("N"), Doc("main cutting force")] = 0.0
    chip: Annotated[float, Unit("mm"), Doc("chip thickness")] = 0.0
    width: Annotated[float, Unit("mm"), Doc("depth of cut in the stock, with runout")] = 0.0
    spindle: Spindle = Spindle()
    cross: Cross = Cross()
    feed: Annotated[float, Unit("mm/min"), Doc("speed of the carriage")] = 0.0
    feed_rate: Annotated[float, Unit("mm/(min s)"), Doc("its rate of change")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("travel of the carriage")] = 0.0
    turns: Annotated[float, Doc("revolutions of the spindle")] = 0.0
    surface: Annotated[float, Unit("mm"), Doc("surface that the edge leaves")] = 0.0
    peak: Annotated[float, Unit("N"), Doc("largest force so far")] = 0.0
    over_s: Annotated[float, Unit("s"), Doc("time with a force above the limit")] = 0.0
    removed: Annotated[float, Unit("mm^3"), Doc("volume removed")] = 0.0
    place: Annotated[int, Doc("last place of the surface that is cut, 256 a revolution")] = 0
    at: Annotated[int, Doc("place of the next feed voltage")] = 0
    sent: Annotated[np.ndarray, Doc("feed voltages of the last steps")] = np.zeros(SENT)
    ring: Annotated[np.ndarray, Doc("surface of the last revolution, by angle")] = blank()


class LatheTurned(NamedTuple):
    """What happens at the edge, and at the three drives."""

    force: float = 0.0
    """Main cutting force, N."""
    rpm: float = 0.0
    """Spindle speed, 1/min."""
    depth: float = 0.0
    """Depth of the tool below the nominal surface, mm."""
    feed: float = 0.0
    """Speed of the carriage, mm/min."""
    chip: float = 0.0
    """Chip thickness, mm."""
    travel: float = 0.0
    """Way of the carriage, mm."""
    turns: float = 0.0
    """Revolutions of the spindle."""
    torque: float = 0.0
    """Cutting torque at the spindle, N m."""
    power: float = 0.0
    """Cutting power, W."""


class TurningLathePlan(NamedTuple):
    """The parameters as the step reads them."""

    law: CuttingLaw
    work: Workpiece
    spindle: SpindleHold
    servo: FeedHold
    cross: CrossHold
    yielding: float
    runout: float
    limit: float
    late: int


def planned(params: TurningLatheParams, dt: float) -> TurningLathePlan:
    """The drives' steps of ``dt``, the bar, and the dead time of the feed in steps.

    Raises:
        ValueRefused: a dead time of 64 steps or more, a step that feed servo or spindle do not bear (see
            :func:`leadscrew.plants._turning.process.checked_step`), or a workpiece that is none.
    """
    fast, started = params.spindle.max_speed, params.start.rpm
    fastest, name = (fast, "spindle.max_speed") if fast >= started else (started, "start.rpm")
    late = checked_step(params.servo, fastest, name, dt, "turning_lathe")
    return TurningLathePlan(
        params.law, checked(params.work), spindle_hold(params.spindle, dt), feed_hold(params.servo, dt),
        cross_hold(params.cross, dt), params.feed_force_ratio / params.stiffness, params.runout, params.limit, late,
    )  # fmt: skip


def begun(params: TurningLatheParams) -> TurningLatheState:
    """The spindle at its speed, everything else at rest."""
    start = params.start
    return TurningLatheState(
        spindle=Spindle(float(start.rpm), float(start.rpm)), cross=Cross(float(start.depth), 0.0),
        sent=np.zeros(SENT), ring=blank(),
    )  # fmt: skip


def shown(p, s):
    """Force, speed and depth; feed, chip, carriage and spindle; torque and power."""
    torque = cutting_torque(s.force, p.work.diameter)
    return LatheTurned(
        s.force, s.spindle.rpm, s.cross.depth, s.feed, s.chip, s.travel, s.turns, torque,
        torque * s.spindle.rpm * math.pi / 30.0,
    )  # fmt: skip


@plant(TurningLatheParams, TurningLatheState, output=shown, prepare=planned, initial=begun, unit="N")
def turning_lathe(p, s, u, load, dt):
    """Spindle, carriage, cross slide and cutting force of a lathe under three voltages: state one step later."""
    s.sent[s.at] = u.feed_v
    late = s.at - p.late
    servo = fed(p.servo, s.feed, s.feed_rate, s.sent[late if late >= 0 else late + SENT], dt)
    torque = cutting_torque(s.force, p.work.diameter)
    foreseen = turned_on(p.spindle, s.spindle, u.spindle_v, torque)
    turns = s.turns + 0.5 * (s.spindle.rpm + foreseen.rpm) * dt / 60.0
    travel = s.travel + servo.area / 60.0
    cross = moved_across(p.cross, s.cross, u.radial_v)

    stock = stock_at(p.work, travel)
    depth = (cross.depth + stock.extra) * stock.there
    width = max(depth + p.runout * math.sin(2.0 * math.pi * turns), 0.0) if depth > 0.0 else 0.0
    before = surface_before(s.ring, turns)
    hard = CuttingLaw(p.law.kf * max(1.0 + load + stock.harder, 0.0), p.law.exponent)
    now = cut(hard, width, p.yielding, travel - before)
    surface = max(travel - p.yielding * now.force, before)
    place = leave_surface(s.ring, s.turns, s.surface, turns, surface)

    mean = 0.5 * (torque + cutting_torque(now.force, p.work.diameter))
    spindle = turned_on(p.spindle, s.spindle, u.spindle_v, mean)
    area = 0.5 * (s.width * s.chip * s.spindle.rpm + width * now.chip * spindle.rpm)
    rate = area * math.pi * p.work.diameter / 60.0
    return TurningLatheState(
        now.force, now.chip, width, spindle, cross, servo.value, servo.rate, travel, turns, surface,
        max(s.peak, now.force), s.over_s + (dt if now.force > p.limit else 0.0), s.removed + rate * dt, place,
        s.at + 1 if s.at + 1 < SENT else 0, s.sent, s.ring,
    )  # fmt: skip
