"""A session: how a machine was started, what was done to it in which period, and a checksum of all its signals.

The same start and the same events give the same bits, on every engine, however the run is cut into pieces; a session
can therefore be saved, sent, and run again anywhere, and its checksum says whether the signals are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.experiment import Experiment
    from leadscrew.operate.change import Change
    from leadscrew.operate.operated import Operated

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
        told: Callable[[Event, Change], None] | None = None,
    ) -> Rerun:
        """Runs the session again and compares its checksum.

        Args:
            record: signals to keep, as for ``Loop.run``: the standard ones unless given, ``()`` for none, ``*`` for
                all, the name of a slot for its states. The checksum does not depend on it.
            look: called with the machine and every piece of rows (all columns) on the way.
            told: called with every event and what it changed.

        Raises:
            LeadscrewError: the machine cannot be built, an event is refused, or the recording is larger than memory.
        """
        from leadscrew.operate.operated import Operated
        from leadscrew.operate.recorder import Recorder

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
                if told is not None:
                    told(event, made)
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


__all__ = ["MARK", "Event", "Rerun", "Session", "Start"]
