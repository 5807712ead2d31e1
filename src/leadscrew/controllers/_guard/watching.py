"""What the force guard looks at: is the force too large, and can the load cell be believed?

Each look takes one :class:`~leadscrew.sensors.CutReading` and gives a cause, the first that holds of::

    2  not finite         a number of the reading or of the command is NaN or infinite
    3  out of range       abs(raw) >= range_n: the amplifier is at the end of its range, or sends an error code
    4  jump               abs(raw - last raw) > jump_n + rate_n_s dt: no cut changes its force so fast
    5  stuck              raw has been the same number for still_s, at still_above_n or more
    6  unanswered         the output has risen and the force has not: leadscrew.controllers._guard.answering
    7  below zero         the mean of raw is below -below_n: a wrong tare or polarity, no cut pulls
    1  too large          raw > hold_n, confirm times in a row
    0  none

A jump says nothing about the reading itself, so the next one is compared with it: after one look of cause 4 a new level
counts as true. Where a number is not finite, the last finite ones stand in its place: no state ever sees a NaN.

``still_s`` works because a load cell's amplifier shows noise in its last digit. Where it does not (a noise-free
simulation, a coarse converter, a filter in the amplifier) give 0: no such check; 6 remains. ``still_above_n`` must be
above one count of the cell, so that it may rest in air. No check finds a wrong scale, or a reading that is off by less
than a jump and does not fall below zero; see ``docs/force_guard.md``.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._guard.answering import Answer, answered
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

NONE, TOO_LARGE, NOT_FINITE, OUT_OF_RANGE, JUMP, STUCK, UNANSWERED, BELOW_ZERO = range(8)
"""Causes of a hold."""

CAUSES = {
    NONE: "none", TOO_LARGE: "force above hold_n", NOT_FINITE: "a number is not finite", OUT_OF_RANGE: "range end",
    JUMP: "jump", STUCK: "stuck", UNANSWERED: "force does not answer the feed", BELOW_ZERO: "force below zero",
}  # fmt: skip
"""In words."""

SLACK_S = 1e-9
"""Rounding of sums of periods."""


class Levels(NamedTuple):
    """Raw force at which the feed is reduced, and at which it is held."""

    reduce_n: Annotated[float, Unit("N"), Ge(0), Doc("above it the feed is reduced")] = 165.0
    hold_n: Annotated[float, Unit("N"), Gt(0), Doc("above it the feed is held")] = 180.0
    min_share: Annotated[float, Ge(0), Le(1), Doc("share of the feed that is left just below hold_n")] = 0.3
    confirm: Annotated[int, Ge(1), Le(100), Doc("readings above hold_n in a row that hold the feed")] = 1


class CellChecks(NamedTuple):
    """When the load cell is not believed."""

    range_n: Annotated[float, Unit("N"), Gt(0), Doc("end of its range")] = 1000.0
    jump_n: Annotated[float, Unit("N"), Ge(0), Doc("change between two readings that noise alone may make")] = 60.0
    rate_n_s: Annotated[float, Unit("N/s"), Ge(0), Doc("largest rate of a true force")] = 15000.0
    still_s: Annotated[float, Unit("s"), Ge(0), Doc("as long it may show one number; 0: as long as it likes")] = 0.1
    still_above_n: Annotated[float, Unit("N"), Ge(0), Doc("readings below this may stay constant: air")] = 10.0
    rise: Annotated[float, Ge(0), Le(10), Doc("rise of the output that the force must answer; 0: no such check")] = 0.3
    rise_most: Annotated[float, Ge(0), Le(10), Doc("the same, whatever the error's sign was meanwhile")] = 1.0
    answer: Annotated[float, Gt(0), Le(1), Doc("relative change of the force that is an answer")] = 0.04
    answer_s: Annotated[float, Unit("s"), Gt(0), Doc("time for it: feed servo, a revolution, margin")] = 0.4
    below_n: Annotated[float, Unit("N"), Gt(0), Doc("mean force below zero that no cut has")] = 30.0


class Seen(NamedTuple):
    """What the last look found: finite numbers only."""

    force: Annotated[float, Unit("N"), Doc("filtered force, the last finite one")] = 0.0
    raw: Annotated[float, Unit("N"), Doc("raw force, the last finite one")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("travel of the carriage, the last finite one")] = 0.0
    turns: Annotated[float, Doc("turns of the spindle, the last finite ones")] = 0.0
    same: Annotated[int, Doc("readings in a row that were equal to the one before")] = 0
    over: Annotated[int, Doc("readings in a row above hold_n")] = 0
    cause: Annotated[int, Doc("see the table of leadscrew.controllers._guard.watching")] = 0
    started: Annotated[int, Doc("whether there is a reading to compare with")] = 0
    answer: Answer = Answer()


def looked(levels, checks, air_n, s, reading, command, told, output, running, dt):
    """The next :class:`Seen`.

    ``command``: the last finite force; ``told``: whether this command is finite; ``output``, ``running``: of the guard
    at the last look, ``dt`` ago.
    """
    finite = (
        told
        and math.isfinite(reading.force)
        and math.isfinite(reading.raw)
        and math.isfinite(reading.travel)
        and math.isfinite(reading.turns)
    )
    raw = reading.raw if finite else s.raw
    compared = finite and s.started > 0
    jumped = compared and abs(raw - s.raw) > checks.jump_n + checks.rate_n_s * dt
    still = compared and raw == s.raw and abs(raw) >= checks.still_above_n
    same = min(s.same + 1, 1000000) if still else 0
    stuck = checks.still_s > 0.0 and same * dt >= checks.still_s - SLACK_S
    over = min(s.over + 1, 1000000) if raw > levels.hold_n else 0
    answer = answered(checks, air_n, s.answer, command, raw, output, running, dt)
    cause = (
        NOT_FINITE
        if not finite
        else OUT_OF_RANGE
        if abs(raw) >= checks.range_n
        else JUMP
        if jumped
        else STUCK
        if stuck
        else UNANSWERED
        if answer.doubted > 0
        else BELOW_ZERO
        if answer.force < -checks.below_n
        else TOO_LARGE
        if over >= levels.confirm
        else NONE
    )
    return Seen(
        reading.force if finite else s.force, raw, reading.travel if finite else s.travel,
        reading.turns if finite else s.turns, same, over, cause, 1, answer,
    )  # fmt: skip
