"""A guard around any force controller: it reduces the feed, holds it, tries again, and stays put if that does not help.

It looks at the **raw** force and at the load cell itself in each of its periods
(what for: :mod:`~leadscrew.controllers._guard.watching`; what it does: :mod:`~leadscrew.controllers._guard.holding`)

    raw > reduce_n                        the output is reduced, to ``min_share`` of it just below hold_n
    raw > hold_n, or the cell is broken   feed hold: output 0 in the same period
    quiet for calm_s                      restart at a share of the feed before, the inner controller aligned to it
    held once more after ``retries``      the hold stays until ``reset``

**Latency.** The raw force is seen at the next look, so the output is 0 at most one period after the crossing, plus the
loop's delay: 20 ms at a period of 20 ms, 40 ms with one sample of delay. ``clock=Clock(every=20)`` is the fast form,
for a thread of 1 ms: the guard looks in every call, the inner controller runs in each ``every``-th on a force that the
guard filters itself, ``y = keep y + (1 - keep) raw``, as it would at its own period. ``looks`` lets the guard look in
each ``looks``-th call only.

What it cannot do: prevent the peak. The chip of the next revolution lies there already, and the axis takes its time to
stop. It is no substitute for the machine's emergency stop. See ``docs/force_guard.md``.

Outputs are at least 0 and grow with the feed. Command: :class:`~leadscrew.references.CutCommand`,
feedback: :class:`~leadscrew.sensors.CutReading`; a controller on numbers gets their forces. Source: ours, for
the study ``grey_turning``: a threshold on the raw signal, then feed hold.

Bumpless start: that of the inner controller, the guard running with no holds counted.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple, cast

from leadscrew.controllers._guard.answering import Answer
from leadscrew.controllers._guard.holding import FREE, RUNNING, AirCut, Guard, Recovery, decided, sent
from leadscrew.controllers._guard.watching import CellChecks, Levels, Seen, looked
from leadscrew.controllers._guard.wrapped import finite_command, taken_apart, whole
from leadscrew.controllers._wrapping import around
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Le, Lt
from leadscrew.references._cutting_program import CutCommand
from leadscrew.util.errors import ValueRefused, entry_point

HIGH = 1e300
"""A ceiling that is none."""

LEVELS, CELL, RECOVERY, AIR = Levels(), CellChecks(), Recovery(), AirCut()


class Clock(NamedTuple):
    """For a loop that runs faster than the inner controller: who is at work in which call."""

    every: Annotated[int, Ge(1), Le(10000), Doc("the inner controller runs in each every-th call")] = 20
    looks: Annotated[int, Ge(1), Le(10000), Doc("the guard looks in each looks-th; every is a multiple of it")] = 1
    keep: Annotated[float, Ge(0), Lt(1), Doc("coefficient of the filter of the force that the inner one gets")] = 0.8


def checked(levels: Levels, recover: Recovery, clock: Clock | None) -> None:
    """Refuses what cannot work.

    Raises:
        ValueRefused: levels in the wrong order, or a rate that is no whole multiple.
    """
    if not levels.reduce_n < levels.hold_n:
        raise ValueRefused(f"levels.reduce_n = {levels.reduce_n:g} N (force_guard): below hold_n = {levels.hold_n:g} N")
    if not recover.resume_n < levels.hold_n:
        raise ValueRefused(
            f"recover.resume_n = {recover.resume_n:g} N (force_guard): below hold_n = {levels.hold_n:g} N"
        )
    if clock is not None and clock.every % clock.looks:
        raise ValueRefused(
            f"clock.every = {clock.every}, clock.looks = {clock.looks} (force_guard): every must be a multiple of looks"
        )


@entry_point
def force_guard(
    inner: Block,
    levels: Levels = LEVELS,
    cell: CellChecks = CELL,
    recover: Recovery = RECOVERY,
    air: AirCut = AIR,
    clock: Clock | None = None,
    name: str = "",
) -> Block:
    """The force controller ``inner`` under guard; its parameters are those of ``inner`` below ``inner.``.

    ``clock``: for a loop that runs faster than the inner controller.

    Raises:
        BlockError: ``inner`` is no sampled controller with a bumpless start that takes command, feedback and dt.
        ValueRefused: levels in the wrong order; a clock whose ``every`` is no multiple of ``looks``.
    """
    part = taken_apart(inner, "force_guard")
    law, align_law, told, shown = part.law, part.align, part.told, part.shown
    checked(levels, recover, clock)
    fast = clock is not None
    own: list[Any] = [("levels", Levels), ("cell", CellChecks), ("recover", Recovery), ("air", AirCut)]
    own += [("clock", Clock)] if fast else []
    params_type = around("ForceGuardParams", inner.params, *own)
    times: list[Any] = [("filtered", float), ("asked", float), ("turn", int), ("wait", int)]
    parts: list[Any] = [("seen", Seen), ("guard", Guard), ("command", CutCommand)]
    state_type = around("ForceGuardState", inner.state, *parts, *(times if fast else []))

    def prepare(params: Any, dt: float) -> Any:
        checked(params.levels, params.recover, params.clock if fast else None)
        ready = prepared(inner, dt * params.clock.every if fast else dt, params.inner)
        return around("ForceGuardPlan", ready, *own)(ready, *params[1:])

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        level = Answer(feedback.raw, output, feedback.raw, feedback.raw, output, output, 0.0, 0)
        seen = Seen(feedback.force, feedback.raw, feedback.travel, feedback.turns, 0, 0, 0, 0, level)
        begun = align_law(params.inner, told(command), shown(feedback, seen), output)
        return state_type(begun, seen, Guard(0, 0, 0, 0.0, 0.0, 0.0, 0.0, output, FREE), whole(command))

    def below(p, s, command, feedback, ceiling, rapid, last, dt):
        """One period below a ceiling of the output."""
        sound = finite_command(command)
        known = whole(command) if sound else s.command
        running = s.guard.mode == RUNNING
        seen = looked(p.levels, p.cell, p.air.air_n, s.seen, feedback, known.force, sound, s.guard.output, running, dt)
        stepped, asked = law(p.inner, s.inner, told(known), shown(feedback, seen), dt)
        guard = decided(p, s.guard, seen, asked, ceiling, rapid, dt)
        if guard.aligned >= 0.0:
            stepped = align_law(p.inner, told(known), shown(feedback, seen), guard.aligned)
        return state_type(stepped, seen, guard, known), sent(guard, ceiling, rapid), guard.output

    def align_fast(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        level = Answer(feedback.raw, output, feedback.raw, feedback.raw, output, output, 0.0, 0)
        seen = Seen(feedback.force, feedback.raw, feedback.travel, feedback.turns, 0, 0, 0, 0, level)
        begun = align_law(params.inner, told(command), shown(feedback, seen), output)
        guard = Guard(0, 0, 0, 0.0, 0.0, 0.0, 0.0, output, FREE)
        return state_type(begun, seen, guard, whole(command), feedback.force, output, 0, 0)

    def below_fast(p, s, command, feedback, ceiling, rapid, last, dt):
        """One call below a ceiling of the output, most of them without the inner controller."""
        if s.wait > 0:
            waits = state_type(s.inner, s.seen, s.guard, s.command, s.filtered, s.asked, s.turn, s.wait - 1)
            return waits, sent(s.guard, ceiling, rapid), s.guard.output
        sound = finite_command(command)
        known = whole(command) if sound else s.command
        running = s.guard.mode == RUNNING
        since = dt * p.clock.looks
        found = looked(
            p.levels, p.cell, p.air.air_n, s.seen, feedback, known.force, sound, s.guard.output, running, since
        )  # fmt: skip
        filtered = p.clock.keep * s.filtered + (1.0 - p.clock.keep) * found.raw if s.turn == 0 else s.filtered
        seen = Seen(
            filtered, found.raw, found.travel, found.turns, found.same, found.over, found.cause, found.started,
            found.answer,
        )  # fmt: skip
        stepped = s.inner
        asked = s.asked
        if s.turn == 0:
            stepped, asked = law(p.inner, s.inner, told(known), shown(feedback, seen), dt * p.clock.every)
        guard = decided(p, s.guard, seen, asked, ceiling, rapid, since)
        if guard.aligned >= 0.0:
            stepped = align_law(p.inner, told(known), shown(feedback, seen), guard.aligned)
            asked = guard.aligned
        turn = s.turn + p.clock.looks if s.turn + p.clock.looks < p.clock.every else 0
        return (
            state_type(stepped, seen, guard, known, filtered, asked, turn, p.clock.looks - 1),
            sent(guard, ceiling, rapid),
            guard.output,
        )

    stepping = below_fast if fast else below

    def guarded(p, s, command, feedback, dt):
        """The inner controller under guard."""
        after, output, _ = stepping(p, s, command, feedback, HIGH, 0.0, 0.0, dt)
        return after, output

    cast(Any, guarded).takes_cut = True
    cast(Any, guarded).below = stepping
    begin = state_type(inner.state, Seen(), Guard(), CutCommand(), *((0.0, 0.0, 0, 0) if fast else ()))
    given = (levels, cell, recover, air, *((clock,) if fast else ()))
    return make(
        "controller", guarded, params_type(inner.params, *given), begin, prepare=prepare,
        align=align_fast if fast else align, unit=inner.unit, drive=inner.drive, full_scale=inner.full_scale,
        sense=inner.sense, doc=f"{inner.doc} A guard holds the feed where the force is too large or the load "
        "cell is broken.", name=name or f"{inner.name}_guarded",
    )  # fmt: skip
