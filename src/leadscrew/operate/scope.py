"""An oscilloscope on the rows of a running machine: a ring of full-rate history, a trigger, and what it caught.

A rising trigger fires at the row in which the signal reaches the level, having been below it in the row before
(falling: above; either: both). The first crossing after ``arm`` counts. In ``normal`` and ``auto`` the scope arms again
when a capture is complete, and then the signal must first go beyond the level by the hysteresis, so that noise around
the level fires once. Unless given, the hysteresis is five times the noise of the signal in the last rows. A value that
is not finite never fires, nor does the row behind it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import numpy as np

from leadscrew.kernel import door
from leadscrew.kernel.errors import ValueRefused
from leadscrew.operate.capture import Capture
from leadscrew.operate.scope_ring import Ring
from leadscrew.operate.scope_trigger import NOISE_ROWS, NOISES, Crossing, Trigger, checked, noise

RING_BYTES = 32_000_000
"""Most memory of the ring."""

AUTO_S = 0.5
"""Simulated seconds without a trigger after which ``auto`` fires; the length of the capture where that is longer."""


class Scope:
    """Keeps the last rows of a machine and takes captures of them.

    Rows of periods that do not follow each other are never in one capture: a gap drops what was being taken, and the
    scope waits again. What is taken is the same however the rows are cut into calls of :meth:`feed`. A capture has
    fewer rows before its trigger where the rows that came before it are too few.
    """

    def __init__(
        self, columns: Sequence[str], units: Mapping[str, str], period_s: float, seconds: float = 20.0
    ) -> None:
        self.columns = tuple(columns)
        self.units = dict(units)
        self.period_s = door.positive("period_s", period_s, "s")
        if not self.columns:
            raise ValueRefused("a scope needs at least one signal")
        wanted = math.ceil(door.positive("seconds", seconds, "s") / self.period_s * (1.0 - 1e-12))
        self.capacity = max(2, min(RING_BYTES // (8 * len(self.columns)), wanted))
        self.message = ""
        self._ring = Ring(self.capacity, len(self.columns))
        self._next: int | None = None
        self._phase = "idle"
        self._trigger: Trigger | None = None
        self._column = self._length = self._pre = 0
        self._crossing = Crossing(0.0, "rising")
        self._waited = self._before = self._left = 0
        self._how, self._again, self._at_once = "", False, False
        self._newest: Capture | None = None
        self._count = self._serial = 0

    def arm(self, trigger: Trigger) -> None:
        """Waits for a trigger from the next row on; the rows that are held already may come before it.

        Raises:
            NameUnknown, ValueRefused: as :func:`leadscrew.operate.scope_trigger.checked`.
        """
        self._set(trigger)
        self._count, self.message, self._at_once = 0, "", False
        self._wait(trigger.hysteresis or 0.0)

    def disarm(self) -> None:
        """Waits for nothing, and drops what is being taken."""
        self._phase, self._at_once = "idle", False

    def force(self) -> None:
        """Takes a capture around the last row, of the trigger that was armed last or, before any, of one second."""
        if self._phase == "taking":
            return
        if self._trigger is None:
            self._set(Trigger(self.columns[0], 0.0, pre=0.5, length_s=min(1.0, self.capacity * self.period_s)))
        assert self._trigger is not None
        again = self._phase == "armed" and self._trigger.mode != "single"
        if self._ring.held:
            self._fire("forced", again, self._next or 0)
        else:
            self._phase, self._at_once, self._again = "armed", True, again

    def feed(self, first_period: int, rows: np.ndarray) -> None:
        """Takes in rows, shape (n, columns), of the periods from ``first_period`` on.

        Raises:
            ValueRefused: rows of another shape.
        """
        rows = np.asarray(rows, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != len(self.columns):
            raise ValueRefused(f"rows of shape {rows.shape}: expected (n, {len(self.columns)})")
        if len(rows) and self._next is not None and first_period != self._next:
            self._gap()
        done = 0
        while done < len(rows):
            done += self._some(rows[done:], first_period + done)

    def taken(self, about: Mapping[str, Any] | None = None) -> Capture | None:
        """The newest capture, once, with what it is about added; None where there is none."""
        newest, self._newest = self._newest, None
        if newest is not None and about:
            return Capture(**{**newest.__dict__, "about": {**newest.about, **about}})
        return newest

    def state(self) -> dict[str, Any]:
        """What the scope does, as JSON can hold it.

        ``phase``: idle, armed, taking, done; ``share`` of the capture that is there; ``held_s`` of ``most_s`` kept;
        ``count`` of captures since it was armed.
        """
        whole = self._before + 1 + self._post()
        return {
            "phase": self._phase,
            "trigger": None if self._trigger is None else asdict(self._trigger),
            "share": 1.0 - self._left / whole if self._phase == "taking" else float(self._phase == "done"),
            "held_s": self._ring.held * self.period_s,
            "most_s": self.capacity * self.period_s,
            "count": self._count,
            "hysteresis": self._crossing.width,
            "message": self.message,
        }

    def _set(self, trigger: Trigger) -> None:
        self._column, self._length, self._pre = checked(trigger, self.columns, self.period_s, self.capacity)
        self._trigger, self._crossing = trigger, Crossing(trigger.level, trigger.slope)

    def _some(self, rows: np.ndarray, first: int) -> int:
        """Takes in rows up to the next thing that happens; gives how many."""
        if self._phase == "armed":
            return self._watch(rows, first)
        n = min(self._left, len(rows)) if self._phase == "taking" else len(rows)
        self._keep(rows[:n], first)
        if self._phase == "taking":
            self._left -= n
            if self._left == 0:
                self._complete(first + n)
        return n

    def _watch(self, rows: np.ndarray, first: int) -> int:
        assert self._trigger is not None
        if self._at_once:
            self._keep(rows[:1], first)
            self._at_once = False
            self._fire("forced", self._again, first + 1)
            return 1
        auto = self._trigger.mode == "auto"
        patience = max(self._length, math.ceil(AUTO_S / self.period_s)) if auto else self._waited + len(rows)
        n = min(len(rows), patience - self._waited)
        hit = self._crossing.look(rows[:n, self._column])
        n = n if hit is None else hit + 1
        self._keep(rows[:n], first)
        self._waited += n
        if hit is not None or (auto and self._waited == patience):
            self._fire("auto" if hit is None else "level", self._trigger.mode != "single", first + n)
        return n

    def _keep(self, rows: np.ndarray, first: int) -> None:
        self._ring.keep(rows)
        self._next = first + len(rows)

    def _gap(self) -> None:
        self._ring.clear()
        if self._phase == "taking":
            self.message = "the periods jumped: what was being taken is dropped"
            if self._how == "forced" and not self._again:
                self._phase = "idle"
                return
        if self._phase in ("taking", "armed"):
            self._phase, self._waited = "armed", 0
            self._crossing.restart(self._crossing.width, math.nan)

    def _wait(self, width: float) -> None:
        self._phase, self._waited, self._left = "armed", 0, 0
        last = float(self._ring.last(1, self._column)[0]) if self._ring.held else math.nan
        self._crossing.restart(width, last)

    def _post(self) -> int:
        return max(0, self._length - 1 - self._pre)

    def _fire(self, how: str, again: bool, following: int) -> None:
        """The last row that is held is the trigger; ``following``: the number of the period after it."""
        self._how, self._again, self._phase = how, again, "taking"
        self._before, self._left = min(self._pre, self._ring.held - 1), self._post()
        if self._left == 0:
            self._complete(following)

    def _complete(self, following: int) -> None:
        trigger = self._trigger
        assert trigger is not None
        rows = self._ring.last(self._before + 1 + self._post())
        self._count += 1
        self._serial += 1
        when = datetime.now(UTC).isoformat("T", "seconds")
        self._newest = Capture(
            f"capture {self._serial}", self.columns, self.units, self.period_s, following - len(rows), self._before,
            rows, {"trigger": {**asdict(trigger), "fired": self._how}, "when": when},
        )  # fmt: skip
        self._phase = "done"
        if self._again:
            seen = self._ring.last(min(self._ring.held, NOISE_ROWS), self._column)
            self._wait(NOISES * noise(seen) if trigger.hysteresis is None else trigger.hysteresis)


__all__ = ["Scope", "Trigger"]
