"""A machine run by hand: a live loop whose parameters are set, which is disturbed and switched, and which remembers.

:class:`Operated` is the machine. Its :class:`Session` says how it was started, what was done to it in which period, and
a checksum of all its signals. The same start and the same events give the same bits, on every engine, however the run
is cut into pieces; a session can therefore be saved, sent, and run again anywhere, and its checksum says whether the
signals are the same.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from leadscrew import names, resolve
from leadscrew.kernel import validate
from leadscrew.kernel.live import Live
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import ParameterSpec
from leadscrew.operate import change, settable, switching
from leadscrew.operate.axes import Axes, Later, split
from leadscrew.operate.change import AT_ONCE, Change, Way
from leadscrew.operate.ghost import Follower, Ghost
from leadscrew.operate.profile import Profile, fitted
from leadscrew.operate.profiles import profile_of
from leadscrew.operate.recorder import Recorder
from leadscrew.operate.switching import Prepared
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.experiment import Experiment

MARK = 16
"""Digits of a digest that an event keeps of the rows before it."""


@dataclass(frozen=True)
class Start:
    """What a machine was when its run began."""

    study: str
    """A study's name, a machine file, or ``path/file.py:name`` of a study or a loop."""
    controller: str | None = None
    scenario: str | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    """Parameters by dotted key, those of the scenario included."""
    seed: int | None = None
    """Of all noise; the study's own unless given."""
    engine: str | None = None
    """The loop's own unless given; every engine gives the same bits."""
    circle: bool = False
    """Two axes on one circle instead of one axis; the columns and keys of the second begin with ``y.``."""
    files: Mapping[str, str] = field(default_factory=dict)
    """SHA-256, by path, of controller and machine files that must be as they were; of others nothing is asked."""

    def experiment(self) -> Experiment:
        """The experiment whose loop is operated."""
        from leadscrew.experiment import Experiment

        return Experiment(
            self.study, self.controller, self.scenario, dict(self.changes), seed=self.seed, files=self.files
        )


@dataclass(frozen=True)
class Event:
    """Something done to the running machine."""

    period: int
    """Periods that were done when it took effect; period ``period`` is the first under it."""
    do: str
    """``set`` or ``switch``."""
    changes: Mapping[str, Any] = field(default_factory=dict)
    """New values by dotted key; of a switch, where the controller's differ from the study's."""
    controller: str = ""
    """Of a switch: the new controller."""
    over: int = 0
    """Periods of a ramp."""
    how: str = ""
    """Of a ``set``: ``ramped`` or ``at once``; of a switch: ``aligned`` or ``not bumpless``."""
    by: str = ""
    """Of a ``set``: integrators of the controller that were rescaled on the way, by their keys, between commas."""
    why: str = ""
    """What did it, where it was no hand: ``undo``, ``redo``, ``disturb NAME``, ``time-out`` and the like."""
    compare: bool = True
    """Whether it is a setting, which can be undone and which a ghost goes on without; a disturbance is none."""
    mark: str = ""
    """The first digits of the checksum of all rows before it: says between which events two runs part."""


@dataclass(frozen=True)
class Rerun:
    """A session run again."""

    signals: dict[str, np.ndarray]
    """The recorded columns; a column that a controller of only a part of the run has is NaN in the others."""
    digest: str
    identical: bool
    difference: str
    """Where it parts from the session, in words; empty where it is identical."""
    operated: Operated
    """The machine where the session ended; it can be operated from there."""


@dataclass(frozen=True)
class Session:
    """A run of an operated machine, complete enough to be made again."""

    start: Start
    events: tuple[Event, ...]
    periods: int
    digest: str
    """SHA-256 of all rows, of all columns, as float64, little-endian, row after row."""
    marks: Mapping[int, str] = field(default_factory=dict)
    """The first digits of the checksum after so many periods: says where two runs part that nothing was done in."""
    written_by: str = field(default="", compare=False)
    """The version of Leadscrew that wrote its file; empty where it comes from none."""

    def run(
        self,
        record: str | Sequence[str] | None = None,
        look: Callable[[Operated, np.ndarray], None] | None = None,
        on_event: Callable[[Event, Change], None] | None = None,
    ) -> Rerun:
        """Runs the session again and compares its checksum.

        Args:
            record: signals to keep, as for ``Loop.run``: the standard ones unless given, ``()`` for none, ``*`` for
                all, the name of a slot for its states. The checksum does not depend on it.
            look: called with the machine and every piece of rows (all columns) on the way.
            on_event: called with every event and what it changed.

        Raises:
            LeadscrewError: the machine cannot be built, an event is refused, or the recording is larger than memory.
        """
        operated = Operated(self.start)
        operated.compare("off")
        recorder = Recorder(record, self.periods)

        def seen(rows: np.ndarray) -> None:
            recorder.feed(operated.columns, rows)
            if look is not None:
                look(operated, rows)

        same: list[int] = []
        odd: list[int] = []
        for event in self.events:
            operated.advance_to(event.period, seen)
            if event.mark:
                (same if operated.digest[:MARK] == event.mark else odd).append(event.period)
            if not operated.diverged:
                made = operated.apply(event)
                if on_event is not None:
                    on_event(event, made)
        operated.advance_to(self.periods, seen)
        again = operated.session()
        for period in self.marks.keys() & again.marks.keys():
            (same if self.marks[period] == again.marks[period] else odd).append(period)
        if operated.digest != self.digest:
            odd.append(self.periods)
        difference = _between(same, odd, operated.period_s) if odd else ""
        return Rerun(recorder.signals(), operated.digest, not difference, difference, operated)


def _between(same: list[int], odd: list[int], period_s: float) -> str:
    """In words, from the periods before which all signals are the same, and those before which they are not."""
    last = min(odd)
    first = max((p for p in same if p < last), default=0)
    return f"the signals differ first between t = {first * period_s:g} s and {last * period_s:g} s"


DEPTH = 200
"""Changes that can be undone at most."""


@dataclass(frozen=True)
class Step:
    """A change, and the one that takes it back; the periods in them say nothing."""

    back: Event
    forth: Event


class History:
    """Changes done, and changes undone."""

    def __init__(self) -> None:
        self.done: list[Step] = []
        self.undone: list[Step] = []

    def add(self, step: Step) -> None:
        """A new change: what was undone before cannot be done again."""
        self.done = [*self.done[-(DEPTH - 1) :], step]
        self.undone = []

    def last(self) -> Step:
        """The change to be undone.

        Raises:
            ValueRefused: there is none.
        """
        if not self.done:
            raise ValueRefused("there is nothing to undo")
        return self.done[-1]

    def next(self) -> Step:
        """The change to be done again.

        Raises:
            ValueRefused: there is none.
        """
        if not self.undone:
            raise ValueRefused("there is nothing to redo")
        return self.undone[-1]

    def taken_back(self) -> None:
        """The last change was undone."""
        self.undone.append(self.done.pop())

    def done_again(self) -> None:
        """The change was done again."""
        self.done.append(self.undone.pop())


CHUNK = 2000
"""Periods in one piece where rows are passed on."""
MARKED = 2**16
"""Periods from one mark of the session to the next, while there are no more than :data:`MARKS`; then twice as many."""
MARKS = 64

Seen = Callable[[np.ndarray], None]
SAFE = ("controller.", "reference.")
"""What returns to its values at the start when the machine is made safe."""

_SHARED = ("start", "profile", "_first_loop", "_experiment_sheet", "_prepared", "_at_start")


class Operated:
    """The running machine of a :class:`Start`, and everything that an operator does to it.

    Every change is an event of the session; two machines with the same start and events give the same bits.

    Args:
        start: study, controller, scenario, changes, seed; two axes on a circle.
        profile: the study's own unless given; a session runs again with the study's own.

    Raises:
        LeadscrewError: the loop cannot be built, or no circle can be made of it.
    """

    def __init__(self, start: Start, profile: Profile | None = None) -> None:
        self.start = start
        own = profile_of(start.study) if profile is None else profile
        self._first_loop = switching.built(start, own, start.controller)
        self._experiment_sheet = start.experiment().settable()
        self.profile = fitted(own, self._first_loop)
        """How the machine is shown and disturbed; only what this loop has."""
        self._prepared: dict[str, Prepared] = {}
        self._at_start = {start.controller or "": settable.at_start(self._first_loop, self._experiment_sheet)}
        self._begin()

    def _begin(self) -> None:
        self._ghost = Follower()
        self._history = History()
        self._events: list[Event] = []
        self._hash = hashlib.sha256()
        self._marks: dict[int, str] = {}
        self._marked = MARKED
        self._files = dict(self._first_loop.origin.get("files", {}))
        axes = switching.beginning(self._first_loop, self.start)
        self._install(axes, axes.values(), self.start.controller or "")
        self._first = self._axes.values()

    def _install(self, axes: Axes, base: list[dict[str, Any]], controller: str) -> None:
        """Takes over a machine with its columns and parameters; ``base``: the controller's values by the study."""
        self.controller = controller
        """Name of the controller that runs now."""
        self._axes = axes
        self.columns = axes.columns
        """``time``, then every signal and state; another list after a switch."""
        self.units = settable.units(axes)
        whole, fixed = settable.sheet(axes), dict(self._at_start[controller])
        if len(axes.lives) > 1:
            fixed |= {f"y.{k}": (whole[f"y.{k}"], why) for k, (_, why) in fixed.items() if f"y.{k}" in whole}
        self.fixed: dict[str, str] = {k: why for k, (_, why) in fixed.items()}
        """Why a parameter cannot change in the run, by its key: it ..."""
        self.at_start: dict[str, ParameterSpec] = {k: e for k, (e, _) in fixed.items()}
        """Data sheets of what cannot change in the run."""
        first = axes.named(base)
        self.sheet: dict[str, ParameterSpec] = {
            k: replace(e, default=first[k]) for k, e in whole.items() if k not in fixed
        }
        """Data sheets of what can be set; defaults: at the start, or the study's after a switch."""
        self._base = base

    def restarted(self) -> Self:
        """The same machine at its start again; nothing is compiled anew."""
        new = object.__new__(type(self))
        new.__dict__.update({k: self.__dict__[k] for k in _SHARED})
        new._begin()
        return new

    # ---- where it stands
    @property
    def loop(self) -> Loop:
        """The loop as it is now, of the first axis."""
        return self._axes.lives[0].loop

    @property
    def live(self) -> Live:
        """The live loop, of the first axis; do not advance or set it."""
        return self._axes.lives[0]

    @property
    def lives(self) -> list[Live]:
        """The live loops of all axes."""
        return self._axes.lives

    @property
    def period(self) -> int:
        """Periods done."""
        return self._axes.period

    @property
    def period_s(self) -> float:
        """The control period."""
        return self._axes.period_s

    @property
    def diverged(self) -> str:
        """Where the loop was lost, in words; empty while it is not."""
        return self._axes.diverged

    @property
    def digest(self) -> str:
        """SHA-256 of all rows so far."""
        return self._hash.hexdigest()

    @property
    def can_undo(self) -> bool:
        """Whether there is a change to undo."""
        return bool(self._history.done)

    @property
    def can_redo(self) -> bool:
        """Whether there is a reverted change to do again."""
        return bool(self._history.undone)

    @property
    def ghost(self) -> Ghost | None:
        """The label of the ghost, while there is one."""
        return self._ghost.shown

    def values(self) -> dict[str, Any]:
        """Every parameter's value by its key, arrays as lists; one on a ramp with the value that it goes to."""
        return {k: v for k, v in self._values().items() if not k.startswith("metrics.")}

    def changed(self) -> dict[str, Any]:
        """What is not as it was at the start; after a switch, of the controller, not as the study has it."""
        return self._differing(self._base, ("",))

    def _values(self) -> dict[str, Any]:
        return settable.plain(self._axes.named(self._axes.values()))

    def _differing(self, base: list[dict[str, Any]], lead: tuple[str, ...]) -> dict[str, Any]:
        """Values that are others than in ``base``, by key."""
        parts = [
            {k: v for k, v in now.items() if k.startswith(lead) and not np.array_equal(v, was.get(k, v))}
            for now, was in zip(self._axes.values(), base, strict=True)
        ]
        return settable.plain(self._axes.joined(parts))

    def _alive(self) -> None:
        if self.diverged:
            raise ValueRefused(f"the loop is lost ({self.diverged}): only a reset is possible now")

    # ---- advancing
    def advance(self, n: int) -> tuple[np.ndarray, np.ndarray | None]:
        """Rows of the next ``n`` periods, all columns, and those of the ghost while there is one.

        What is due on the way is set at its exact period: ten times 100 periods give the same bits as 1000. Where the
        loop is lost there are fewer rows, after that none. The ghost's rows have the machine's columns, NaN where it
        has no such column or is lost itself.
        """
        left = validate.whole("periods", n, 1, 2**31)
        parts = [np.zeros((0, len(self.columns)))]
        while left > 0 and not self.diverged:
            rows = self._axes.piece(min(left, self._marked - self.period % self._marked))
            self._hash.update(rows.astype("<f8", copy=False).tobytes())
            self._mark()
            parts.append(rows)
            left -= len(rows)
            self._axes.due(self._scheduled)
        whole = parts[1] if len(parts) == 2 else np.concatenate(parts)
        return whole, self._ghost.advance(len(whole), self.columns)

    def advance_to(self, period: int, seen: Seen | None = None) -> None:
        """Runs on until ``period`` periods are done; ``seen`` gets the rows piece by piece.

        Raises:
            ValueRefused: they are done already.
        """
        if period < self.period:
            raise ValueRefused(f"period = {period}: {self.period} periods are done already")
        while self.period < period and not self.diverged:
            rows, _ = self.advance(min(CHUNK, period - self.period))
            if seen is not None:
                seen(rows)

    def _scheduled(self, later: Later) -> None:
        """A scheduled change has been made."""
        self._note(Event(self.period, "set", settable.plain(self._axes.joined(later.parts)), how="at once",
                         why=later.why, compare=False))  # fmt: skip

    def _mark(self) -> None:
        if self.period % self._marked == 0:
            self._marks[self.period] = self.digest[:MARK]
        if len(self._marks) > MARKS:
            self._marked *= 2
            self._marks = {k: v for k, v in self._marks.items() if k % self._marked == 0}

    def _note(self, event: Event) -> None:
        self._events.append(replace(event, mark=self.digest[:MARK]))

    def session(self) -> Session:
        """All that was done so far, with a checksum of all signals."""
        start = replace(
            self.start,
            study=names.absolute(self.start.study),
            controller=None if self.start.controller is None else names.absolute(self.start.controller),
            files=self._files,
        )
        return Session(start, tuple(self._events), self.period, self.digest, dict(self._marks))

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
    from leadscrew.figures.table import as_typed

    shown = [f"{k} = {as_typed(v) if isinstance(v, float | int) else v}" for k, v in list(old.items())[:3]]
    return ", ".join(shown) + (f" and {len(old) - 3} more" if len(old) > 3 else "")
