"""A machine run by hand: a live loop whose parameters are set, which is disturbed and switched, and which remembers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from leadscrew import names, resolve
from leadscrew.kernel.errors import ValueRefused
from leadscrew.operate import change, settable, switching
from leadscrew.operate.axes import Later, split
from leadscrew.operate.change import AT_ONCE, Change, Way
from leadscrew.operate.history import Step
from leadscrew.operate.running import Running
from leadscrew.operate.session import Event
from leadscrew.operate.switching import Prepared

SAFE = ("controller.", "reference.")
"""What returns to its values at the start when the machine is made safe."""


class Operated(Running):
    """The running machine of a start, and everything that an operator does to it.

    Every change is an event of the session; two machines with the same start and events give the same bits.
    """

    # ---- changes
    def set(self, changes: Mapping[str, Any], *, why: str = "", compare: bool = True) -> Change:
        """Changes parameters from the next period on, all or none, without a jump of the controller's output.

        Args:
            changes: new values by dotted key; of two axes those of both, or of one behind ``x.`` or ``y.``.
            why: what does it, where it is no hand.
            compare: it is a setting, which can be undone; false for what happens to the machine. The ghost goes on
                under the controller's values before a setting; all else reaches the ghost too.

        Values that the machine has already are no change: nothing is done then.

        Raises:
            NameUnknown, ValueRefused: nothing is changed then.
        """
        parts = self._axes.split(self._checked(changes))
        if self._has(parts):
            same = change.output(self._axes)
            return Change(self.period, {}, {}, "at once", same, same)
        way = change.decide(self._axes, parts) if compare else AT_ONCE
        return self._set(parts, way, why, compare, remember=compare)

    def _checked(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        self._alive()
        return settable.checked(changes, self.sheet, self.fixed)

    def _has(self, parts: list[dict[str, Any]]) -> bool:
        """Whether the machine has these values and keeps them: then nothing is done, and the ghost stays."""
        now = self._axes.values()
        coming = {k for later in self._axes.pending for part in later.parts for k in part}
        return all(
            k not in coming and np.array_equal(v, was[k])
            for part, was in zip(parts, now, strict=True)
            for k, v in part.items()
        )

    def _set(self, parts: list[dict[str, Any]], way: Way, why: str, compare: bool, remember: bool) -> Change:
        axes = self._axes
        new = settable.plain(axes.joined(parts))
        was, back = (
            [{k: now[k] for k in part} for part, now in zip(parts, axes.values(ended), strict=True)]
            for ended in (False, True)  # an undo goes to what a disturbance would have left, not to what it held
        )
        old = settable.plain(axes.joined(was))
        before = change.output(axes)
        setting = [change.own(part) for part in was] if compare else []
        ghost = axes.fork() if any(setting) and self._ghost.wanted() else None
        change.make(axes, parts, way)
        if ghost is not None:
            self._ghost.place(ghost, _label(settable.plain(axes.joined(setting))))
        self._ghost.also([change.others(part) for part in parts] if compare else parts)
        event = Event(self.period, "set", new, over=way.over, how=way.how, by=way.by, why=why, compare=compare)
        self._note(event)
        if remember:
            self._history.add(Step(replace(event, changes=settable.plain(axes.joined(back))), event))
        return Change(self.period, old, new, way.how, before, change.output(axes))

    def schedule(self, period: int, changes: Mapping[str, Any], why: str = "scheduled") -> None:
        """Sets parameters at once as soon as ``period`` periods are done; a later change of the same one cancels it.

        Raises:
            NameUnknown, ValueRefused: as ``set``; the period is over.
        """
        parts = self._axes.split(self._checked(changes))
        if period < self.period:
            raise ValueRefused(f"period = {period}: {self.period} periods are done already")
        if period == self.period:
            self._set(parts, AT_ONCE, why, compare=False, remember=False)
            return
        self._axes.moved(parts)
        later = Later(period, tuple(parts), why or "scheduled")
        self._axes.later(later)
        self._ghost.later(later)

    def disturb(self, name: str, fields: Mapping[str, float] | None = None) -> Change:
        """A disturbance of the profile, now and, where it ends by itself, later; it reaches the ghost too.

        Raises:
            NameUnknown, ValueRefused: no such disturbance or field, or a value out of its bounds.
        """
        self._alive()
        found = self.profile.disturbance(name)
        # Of values that are disturbed already, those to which they will return: a second push is no double one.
        values = settable.plain(self._axes.named(self._axes.values(ended=True)))
        acts = found.changes(fields or {}, self.period * self.period_s, values)
        now: dict[str, Any] = {}
        for delay, changes in acts:
            self._axes.moved(self._axes.split(self._checked(changes)))
            if round(delay / self.period_s) <= 0:
                now |= changes
        made = Change(self.period, {}, {}, "at once", None, None)
        if now:
            made = self.set(now, why=f"disturb {name}", compare=False)
        for delay, changes in acts:
            periods = round(delay / self.period_s)
            if periods > 0:
                self.schedule(self.period + periods, changes, f"disturb {name}")
        return made

    # ---- another controller
    def prepare(self, controller: str) -> Prepared:
        """A controller compiled and ready to take over; may run in another thread.

        Raises:
            NameUnknown: no such controller.
            ValueRefused: it is made for another machine: sensor, period, reference.
        """
        if self.start.controller is None:
            raise ValueRefused(f"{self.start.study} is a loop of its own and has no other controllers")
        found = self._prepared.get(controller)
        if found is None:
            first = controller == self.start.controller
            loop = self._first_loop if first else switching.built(self.start, self.profile, controller)
            found = Prepared(controller, loop)
        why = switching.refusal(found.loop, self._first_loop)
        if why:
            raise ValueRefused(f"{controller} cannot take over in the run: {why}; start a new run with it")
        found.loop.program.entry("single", self.start.engine or found.loop.engine)
        if controller not in self._at_start:
            self._at_start[controller] = settable.at_start(found.loop, self._experiment_sheet)
        self._prepared[controller] = found
        return found

    def switch(self, controller: str | Prepared, *, why: str = "") -> Change:
        """Another controller from the next period on; columns, sheet and units are those of the new loop afterwards.

        Its state is aligned so that the output does not jump, where it can be; ``how`` of the change says so.

        Raises:
            NameUnknown, ValueRefused: as ``prepare``.
        """
        self._alive()
        prepared = self.prepare(controller) if isinstance(controller, str) else controller
        return self._switch(prepared, {}, why, remember=True)

    def _switch(self, prepared: Prepared, changes: Mapping[str, Any], why: str, remember: bool) -> Change:
        self._alive()
        axes, old, own = self._axes, self._setting(), prepared.loop.parameters
        before = change.output(axes)
        new = switching.switched(axes, prepared, split(changes, own, len(axes.lives)))
        if self._ghost.wanted():
            self._ghost.place(axes, f"controller {self.controller}")
        base = [
            {**{k: v for k, v in b.items() if k in now}, **_of_controller(own)}
            for b, now in zip(self._base, new.values(), strict=True)
        ]
        self._install(new, base, prepared.controller)
        self._files |= resolve.digests(prepared.controller, self.start.study)
        how = "aligned" if all(live.bumpless for live in new.lives) else "not bumpless"
        named = names.absolute(prepared.controller)
        event = Event(self.period, "switch", dict(changes), named, how=how, why=why)
        self._note(event)
        if remember:
            back = {k: v for k, v in old.items() if k != "controller"}
            self._history.add(Step(Event(0, "switch", back, old["controller"]), event))
        return Change(self.period, old, self._setting(), how, before, change.output(new))

    def _setting(self) -> dict[str, Any]:
        """The controller's name and where its values differ from the study's."""
        return {"controller": self.controller} | self._differing(self._base, ("controller.",))

    # ---- back
    def undo(self) -> Change:
        """Takes back the last change; as bumpless as it was made.

        Raises:
            ValueRefused: there is none.
        """
        made = self._again(self._history.last().back, "undo")
        self._history.taken_back()
        return made

    def redo(self) -> Change:
        """Makes the last undone change again.

        Raises:
            ValueRefused: there is none.
        """
        made = self._again(self._history.next().forth, "redo")
        self._history.done_again()
        return made

    def _again(self, event: Event, why: str) -> Change:
        if event.do == "switch":
            return self._switch(self.prepare(event.controller), event.changes, why, remember=False)
        parts = self._axes.split(self._checked(event.changes))
        return self._set(parts, change.decide(self._axes, parts), why, compare=True, remember=False)

    def safe(self, why: str) -> Change:
        """The controller and the command as at the start, everything else as it is."""
        self._alive()
        made = Change(self.period, {}, {}, "at once", None, None)
        if self.controller != (self.start.controller or ""):
            made = self._switch(self.prepare(self.start.controller or ""), {}, why, remember=True)
        odd = [
            {
                k: first[k]
                for k, v in now.items()
                if k.startswith(SAFE) and k in first and not np.array_equal(v, first[k])
            }
            for now, first in zip(self._axes.values(), self._first, strict=True)
        ]
        if not any(odd):
            return made
        also = self.set(self._axes.joined(odd), why=why)
        before = made.before if made.new else also.before
        return Change(also.period, {**made.old, **also.old}, {**made.new, **also.new}, also.how, before, also.after)

    def apply(self, event: Event) -> Change:
        """Makes an event of a session, in the way that it was made then.

        Raises:
            ValueRefused: the machine is not at its period.
            NameUnknown, ValueRefused: as ``set`` and ``switch``.
        """
        if event.period != self.period:
            raise ValueRefused(f"the event belongs to period {event.period}; {self.period} periods are done")
        if event.do == "switch":
            return self._switch(self.prepare(event.controller), event.changes, event.why, remember=True)
        parts = self._axes.split(self._checked(event.changes))
        way = Way(event.how, event.over, event.by)
        return self._set(parts, way, event.why, event.compare, remember=event.compare)

    def compare(self, mode: str) -> None:
        """What the ghost shows: ``previous``, ``pinned`` or ``off``."""
        self._ghost.choose(mode)


def _of_controller(values: Mapping[str, Any]) -> dict[str, Any]:
    return {k: v for k, v in values.items() if k.startswith("controller.")}


def _label(old: Mapping[str, Any]) -> str:
    """The setting before a change, in words."""
    from leadscrew.report.tables import number

    shown = [f"{k} = {number(v) if isinstance(v, float | int) else v}" for k, v in list(old.items())[:3]]
    return ", ".join(shown) + (f" and {len(old) - 3} more" if len(old) > 3 else "")


__all__ = ["Operated"]
