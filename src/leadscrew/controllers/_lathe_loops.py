"""The three loops of a retrofitted lathe in one controller: spindle speed, force by the feed, depth of cut.

    spindle_v = spindle(n_ref, n),    feed_v = feed(F_ref, F),    radial_v = radial(b_ref, b)

Each is a controller on numbers with a state of its own; they meet in the cut alone. ``feed`` may also be one that takes
the whole cut (:class:`~leadscrew.references.CutCommand` and
:class:`~leadscrew.sensors.CutReading`): depth feed-forward, gain normalisation, a guard. Parameters and
states are those of the three below ``spindle.``, ``feed.`` and ``radial.``.

**Fixed removal rate**, ``removal.rate = Q`` mm^3/s above 0: the speed to hold is no longer the programmed one, but the
one at which depth, feed and cutting speed multiply to ``Q``, as far as ``lowest`` .. ``highest`` allow:

    q = pi D b v / 60              removal rate measured: depth b and the stock that the control knows, carriage at v
    q_f += beta (q - q_f),   beta = 1 - exp(-dt / smooth_s)
    n_ref = n_ref (1 + g dt (clip(Q / q_f, 1/2, 2) - 1)),   g = removal.gain        only while F > F_ref / 2

At a constant force ``q`` is in proportion to ``n``: the force loop raises the feed with the speed, the chip stays.

Source: section 4 of the paper of the study ``grey_turning``, loops i = 1, 2, 3, there of fuzzy controllers
(:mod:`leadscrew.controllers._grey_fuzzy`). The fixed removal rate is the idea of its reference [13]; the law is ours.

Bumpless start: each loop of its own, where all three can.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, cast

from leadscrew.kernel.block import Block, make
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._turning.workpiece import Workpiece, checked, stock_at
from leadscrew.references._cutting_program import CutCommand
from leadscrew.references._lathe_program import LatheDrive
from leadscrew.sensors._load_cell import CutReading
from leadscrew.util.errors import BlockError, ValueRefused, entry_point


class RemovalRate(NamedTuple):
    """Spindle speed for a fixed removal rate; off by default."""

    rate: Annotated[float, Unit("mm^3/s"), Ge(0), Doc("removal rate to hold, Q; 0: hold the programmed speed")] = 0.0
    gain: Annotated[float, Unit("1/s"), Gt(0), Doc("how fast the speed follows, g")] = 1.0
    smooth_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the measured rate: one revolution and more")] = 0.1
    lowest: Annotated[float, Unit("1/min"), Gt(0), Doc("least speed")] = 300.0
    highest: Annotated[float, Unit("1/min"), Gt(0), Doc("largest speed")] = 1500.0
    work: Annotated[Workpiece, Doc("the raw part, as the control knows it: diameter and stock")] = Workpiece()


PROGRAMMED_SPEED = RemovalRate()
"""No fixed removal rate."""


class RemovalPlan(NamedTuple):
    """What the step needs."""

    rate: float
    gain: float
    beta: float
    lowest: float
    highest: float
    work: Workpiece


class RemovalState(NamedTuple):
    """What the regulation of the removal rate remembers."""

    rpm: Annotated[float, Unit("1/min"), Doc("speed that it asks for; 0 before the first cut")] = 0.0
    rate: Annotated[float, Unit("mm^3/s"), Doc("removal rate, smoothed")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("carriage at the last sample")] = 0.0


def plan_removal(params: RemovalRate, dt: float) -> RemovalPlan:
    """The smoothing of one period.

    Raises:
        ValueRefused: the least speed is not below the largest.
    """
    if params.lowest >= params.highest:
        raise ValueRefused(
            f"removal.lowest = {params.lowest!r} (lathe_loops): must lie below removal.highest = {params.highest!r}"
        )
    beta = -math.expm1(-dt / params.smooth_s)
    return RemovalPlan(params.rate, params.gain, beta, params.lowest, params.highest, checked(params.work))


def regulated(p, s, command, feedback, dt):
    """The speed for a fixed removal rate, and what is measured of it."""
    cutting = feedback.force > 0.5 * command.force and command.force > 0.0
    depth = max(feedback.depth + stock_at(p.work, feedback.travel).extra, 0.0)
    now = math.pi * p.work.diameter * depth * (feedback.travel - s.travel) / dt
    smooth = s.rate + p.beta * (now - s.rate)
    rate = smooth if cutting else 0.0
    before = s.rpm if s.rpm > 0.0 else command.rpm
    ratio = min(max(p.rate / max(rate, 1e-9), 0.5), 2.0)
    asked = before * (1.0 + p.gain * dt * (ratio - 1.0)) if cutting else before
    return RemovalState(min(max(asked, p.lowest), p.highest), rate, feedback.travel)


def law_of(block: Block, place: str) -> Callable[..., Any]:
    """The step of one loop, taking ``(p, s, command, feedback, dt)``.

    Raises:
        BlockError: it is not a sampled controller with parameters and state that takes command and feedback.
    """
    step: Any = block.step
    if block.kind != "controller" or block.continuous or block.params is None or block.state is None:
        raise BlockError(f"lathe_loops({place} = {block.name}): needs a sampled controller with parameters and state")
    if block.signals not in (("command", "feedback", "dt"), ("command", "feedback")):
        raise BlockError(f"lathe_loops({place} = {block.name}): needs one that takes command, feedback and dt")
    if "dt" in block.signals:
        return cast(Callable[..., Any], step)

    def without_period(p, s, command, feedback, dt):
        """The step of a controller that does not ask for the period."""
        return step(p, s, command, feedback)

    return without_period


def whole_cut(command):
    """What a controller of the cut is told."""
    return CutCommand(command.force, command.depth, command.next_depth, command.change_in_s)


def cut_seen(feedback):
    """What a controller of the cut sees."""
    return CutReading(feedback.force, feedback.raw, feedback.travel, feedback.turns)


def force_told(command):
    """What a controller of the force on numbers is told."""
    return command.force


def force_seen(feedback):
    """What a controller of the force on numbers sees."""
    return feedback.force


@entry_point
def lathe_loops(
    spindle: Block,
    feed: Block,
    radial: Block,
    removal: RemovalRate = PROGRAMMED_SPEED,
    name: str = "",
    bumpless: bool = True,
) -> Block:
    """The three loops of a lathe as one controller of three voltages.

    Takes :class:`~leadscrew.references._lathe_program.LatheCommand` and
    :class:`~leadscrew.sensors._lathe_sensors.LatheReading`, gives
    :class:`~leadscrew.references._lathe_program.LatheDrive`. ``bumpless``: whether it can take over from another one;
    an exported controller of several outputs cannot, so give ``False`` to export it.

    Raises:
        BlockError: one of the three is not a sampled controller with parameters and state, or takes other signals.
    """
    turn, push, plunge = law_of(spindle, "spindle"), law_of(feed, "feed"), law_of(radial, "radial")
    told, seen = (whole_cut, cut_seen) if getattr(feed.step, "takes_cut", False) else (force_told, force_seen)
    three = (("spindle", spindle), ("feed", feed), ("radial", radial))
    fields: list[Any] = [(key, type(block.params)) for key, block in three]
    params_type = cast(Any, NamedTuple("LatheLoopsParams", [*fields, ("removal", RemovalRate)]))
    remembered: list[Any] = [(key, type(block.state)) for key, block in three]
    state_type = cast(Any, NamedTuple("LatheLoopsState", [*remembered, ("removal", RemovalState)]))
    aligns: list[Any] = [block.align for _, block in three]
    turn_align, push_align, plunge_align = aligns

    def prepare(params: Any, dt: float) -> Any:
        ready = [
            getattr(params, key) if block.prepare is None else block.prepare(getattr(params, key), dt)
            for key, block in three
        ]
        kinds: list[Any] = [(key, type(plan)) for (key, _), plan in zip(three, ready, strict=True)]
        plan_type = cast(Any, NamedTuple("LatheLoopsPlan", [*kinds, ("removal", RemovalPlan)]))
        return plan_type(*ready, plan_removal(params.removal, dt))

    def initial(params: Any) -> Any:
        begun = [block.state if block.initial is None else block.initial(getattr(params, key)) for key, block in three]
        return state_type(*begun, RemovalState())

    def align(params, command, feedback, output):
        """The state from which the next outputs are these: each loop of its own, the speed as it is commanded."""
        return state_type(
            turn_align(params.spindle, command.rpm, feedback.rpm, output.spindle_v),
            push_align(params.feed, told(command), seen(feedback), output.feed_v),
            plunge_align(params.radial, command.depth, feedback.depth, output.radial_v),
            RemovalState(command.rpm, 0.0, feedback.travel),
        )

    def loops(p, s, command, feedback, dt):
        """Speed, force and depth, each in its own loop."""
        removal = regulated(p.removal, s.removal, command, feedback, dt)
        rpm = removal.rpm if p.removal.rate > 0.0 else command.rpm
        turned, spindle_v = turn(p.spindle, s.spindle, rpm, feedback.rpm, dt)
        pushed, feed_v = push(p.feed, s.feed, told(command), seen(feedback), dt)
        moved, radial_v = plunge(p.radial, s.radial, command.depth, feedback.depth, dt)
        return state_type(turned, pushed, moved, removal), LatheDrive(spindle_v, feed_v, radial_v)

    return make(
        "controller", loops, params_type(spindle.params, feed.params, radial.params, removal),
        state_type(spindle.state, feed.state, radial.state, RemovalState()), prepare=prepare,
        initial=initial if any(block.initial is not None for _, block in three) else None,
        align=align if bumpless and all(a is not None for a in aligns) else None, name=name or "lathe_loops", unit="V",
        drive="voltage", doc=f"Three loops of a lathe: {spindle.name} on the spindle, {feed.name} on the feed, "
        f"{radial.name} on the depth.",
    )  # fmt: skip
