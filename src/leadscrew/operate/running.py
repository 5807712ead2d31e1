"""The running machine under everything that an operator does: where it stands, its rows, what is remembered."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Self

import numpy as np

from leadscrew import names
from leadscrew.kernel import door
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.live import Live
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.sheet import Entry
from leadscrew.operate import settable, switching
from leadscrew.operate.axes import Axes, Later
from leadscrew.operate.ghost import Follower, Ghost
from leadscrew.operate.history import History
from leadscrew.operate.profile import Profile, fitted, profile_of
from leadscrew.operate.session import MARK, Event, Session, Start
from leadscrew.operate.switching import Prepared

CHUNK = 2000
"""Periods in one piece where rows are passed on."""
MARKED = 2**16
"""Periods from one mark of the session to the next, while there are no more than :data:`MARKS`; then twice as many."""
MARKS = 64

Seen = Callable[[np.ndarray], None]
_SHARED = ("start", "profile", "_first_loop", "_experiment_sheet", "_prepared", "_at_start")


class Running:
    """The running machine of a :class:`Start`.

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
        self.at_start: dict[str, Entry] = {k: e for k, (e, _) in fixed.items()}
        """Data sheets of what cannot change in the run."""
        first = axes.named(base)
        self.sheet: dict[str, Entry] = {k: replace(e, default=first[k]) for k, e in whole.items() if k not in fixed}
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
        """Whether there is an undone change to do again."""
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
        left = door.whole("periods", n, 1, 2**31)
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


__all__ = ["Running"]
