"""What the force guard does with what it sees: reduce, hold, try again, and in the end stay put.

What it sends, by mode::

    running   u = min(asked, ceiling)                the inner controller's output; a ceiling has feed_override alone
              u = min(u, air_v)                      while raw < air_n: no cut, or a dead load cell
              u = min(u, last output)                while the load cell shows the same number for the third time,
                                                     or the force has yet to answer the last rise
              output = u share(raw)                  share: 1 up to reduce_n, then a line to ``min_share`` at hold_n
    holding   output = output at the trip, down to 0 within ramp_s (0: at once)
              to running when there is no cause and raw and filtered force are below resume_n for calm_s
    tripped   as holding, until ``reset`` is 1: then holding

A cause holds the feed in the same look. The restart is at ``restart`` times the output before the trip. Each hold
counts; ``forget_s`` of running forget them; the hold after ``retries`` restarts trips. The inner controller does not
run on what it cannot change: while the feed is held, or its output is cut down to the ceiling, to ``air_v``, or frozen,
it is aligned to the output that is sent. On a rapid (feed_override) it waits at its last output, ``air_v`` at most, and
a cause holds the axes all the same.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from leadscrew.controllers._guard.answering import awaited
from leadscrew.controllers._guard.watching import NONE, SLACK_S
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

RUNNING, HOLDING, TRIPPED = range(3)
"""Modes of the guard."""

FREE = -1.0
"""Instead of an output to go on from: the inner controller goes on from its own."""

SAME = 2
"""Equal readings in a row from which the feed does not rise."""


class Recovery(NamedTuple):
    """How the feed stops, and when and how it comes back."""

    ramp_s: Annotated[float, Unit("s"), Ge(0), Doc("time in which the feed goes to 0; 0: at once")] = 0.0
    resume_n: Annotated[float, Unit("N"), Gt(0), Doc("raw and filtered force must be below it")] = 120.0
    calm_s: Annotated[float, Unit("s"), Ge(0), Doc("for so long, without a cause, before the restart")] = 0.1
    restart: Annotated[float, Ge(0), Le(1), Doc("share of the output before the trip that it restarts with")] = 0.3
    retries: Annotated[int, Ge(0), Le(1000), Doc("restarts before a hold stays until reset")] = 3
    forget_s: Annotated[float, Unit("s"), Ge(0), Doc("of running after which earlier holds do not count")] = 2.0
    reset: Annotated[Literal["off", "on"] | int, Doc("on ends a hold that stays; set it back to off")] = 0


class AirCut(NamedTuple):
    """The feed without a cut: what the tool meets the work with, and all that a dead load cell can cause."""

    air_n: Annotated[float, Unit("N"), Ge(0), Doc("raw force below which there is no cut")] = 10.0
    air_v: Annotated[float, Gt(0), Doc("largest output then, in the unit of the output")] = 0.3


class Guard(NamedTuple):
    """Where the guard stands."""

    mode: Annotated[int, Doc("0 running, 1 holding, 2 tripped until reset")] = 0
    cause: Annotated[int, Doc("cause of the last hold, see leadscrew.controllers._guard.watching")] = 0
    holds: Annotated[int, Doc("holds that are not forgotten")] = 0
    calm_s: Annotated[float, Unit("s"), Doc("how long all has been well, while holding")] = 0.0
    good_s: Annotated[float, Unit("s"), Doc("how long it has been running, up to forget_s")] = 0.0
    fade: Annotated[float, Doc("share of the output at the trip that is left")] = 0.0
    tripped_at: Annotated[float, Doc("output before the trip")] = 0.0
    output: Annotated[float, Doc("output sent")] = 0.0
    aligned: Annotated[float, Doc("output that the inner controller is to go on from; below 0: from its own")] = FREE


def share(levels, raw):
    """What is left of the feed at a raw force."""
    line = 1.0 - (1.0 - levels.min_share) * (raw - levels.reduce_n) / (levels.hold_n - levels.reduce_n)
    return min(max(line, levels.min_share), 1.0)


def decided(p, s, seen, asked, ceiling, rapid, dt):
    """The next :class:`Guard` for what was seen and what the inner controller asks for."""
    r = p.recover
    trips = s.mode == RUNNING and seen.cause != NONE
    well = seen.cause == NONE and seen.raw < r.resume_n and seen.force < r.resume_n
    calm = s.calm_s + dt if well and s.mode == HOLDING else 0.0
    resumes = s.mode == HOLDING and well and calm >= r.calm_s - SLACK_S
    freed = s.mode == TRIPPED and r.reset == 1
    old = s.mode == RUNNING and s.good_s >= r.forget_s - SLACK_S
    holds = (0 if freed or old else s.holds) + (1 if trips else 0)
    later = TRIPPED if holds > r.retries else HOLDING
    mode = later if trips else HOLDING if freed else RUNNING if resumes else s.mode
    runs = mode == RUNNING

    frozen = (p.cell.still_s > 0.0 and seen.same >= SAME) or awaited(p.cell, seen.answer)
    below = min(asked, ceiling)
    unfrozen = min(below, s.output) if frozen else below
    limited = min(unfrozen, p.air.air_v) if seen.raw < p.air.air_n else unfrozen
    waiting = min(s.output, p.air.air_v)
    tripped_at = s.output if trips else s.tripped_at
    last = 1.0 if trips else s.fade
    fade = max(last - dt / r.ramp_s, 0.0) if r.ramp_s > 0.0 else 0.0
    running = waiting if rapid > 0.5 else limited * share(p.levels, seen.raw)
    onward = waiting if rapid > 0.5 else limited if limited < asked else FREE
    return Guard(
        mode, seen.cause if trips else s.cause, holds, 0.0 if runs else calm,
        min(s.good_s + dt, r.forget_s) if runs and s.mode == RUNNING else 0.0, 0.0 if runs else fade, tripped_at,
        running if runs else tripped_at * fade, onward if runs else r.restart * tripped_at,
    )  # fmt: skip


def sent(guard, ceiling, rapid):
    """What goes to the machine: the guard's output, or on a rapid that nothing holds the ceiling."""
    return ceiling if rapid > 0.5 and guard.mode == RUNNING else guard.output
