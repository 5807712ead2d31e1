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
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from leadscrew.kernel import validate
from leadscrew.kernel.parameters import nearest
from leadscrew.operate.capture import Capture
from leadscrew.util.errors import NameUnknown, ValueRefused


class Ring:
    """Keeps the last ``capacity`` rows of ``width`` doubles; every page of it is written at the start."""

    def __init__(self, capacity: int, width: int) -> None:
        self._rows = np.full((capacity, width), np.nan)
        self._end = 0
        self.held = 0

    def clear(self) -> None:
        """Forgets all rows."""
        self.held = 0

    def keep(self, rows: np.ndarray) -> None:
        """Adds rows, shape (n, width); the oldest ones make room."""
        capacity = len(self._rows)
        rows = rows[-capacity:]
        first = min(len(rows), capacity - self._end)
        self._rows[self._end : self._end + first] = rows[:first]
        self._rows[: len(rows) - first] = rows[first:]
        self._end = (self._end + len(rows)) % capacity
        self.held = min(capacity, self.held + len(rows))

    def last(self, n: int, column: int | None = None) -> np.ndarray:
        """A copy of the last ``n`` rows that are held, or of one column of them."""
        start = (self._end - n) % len(self._rows) if n else self._end
        part = self._rows if column is None else self._rows[:, column]
        return np.array(
            part[start : start + n] if start + n <= len(part) else np.concatenate([part[start:], part[: self._end]])
        )


SLOPES, MODES = ("rising", "falling", "either"), ("single", "normal", "auto")

NOISE_ROWS = 2000
"""Rows from which the noise of a signal is estimated."""

NOISES = 5.0
"""Hysteresis in standard deviations of the noise: Gaussian noise passes it once in 3.5 million rows."""

_THIRD = 1.0 / (0.6745 * math.sqrt(20.0))
"""Standard deviation of white noise by the median size of its third differences (weights 1, -3, 3, -1)."""


@dataclass(frozen=True)
class Trigger:
    """When to take a capture.

    ``level`` in the unit of the signal; ``pre``: share of the capture before the trigger, 0 to 1; ``length_s``: of the
    whole capture, s; ``hysteresis``: in the unit of the signal, None for one by its noise.
    """

    signal: str
    level: float
    slope: str = "rising"
    mode: str = "single"
    pre: float = 0.2
    length_s: float = 1.0
    hysteresis: float | None = None


def checked(trigger: Trigger, columns: Sequence[str], period_s: float, capacity: int) -> tuple[int, int, int]:
    """Column of the signal, rows of the capture, and rows of it before the trigger.

    Raises:
        NameUnknown: no such signal.
        ValueRefused: a level or hysteresis that is not finite, a share outside 0 to 1, a length of less than two rows
            or more than the scope keeps, no such slope or mode.
    """
    if trigger.signal not in columns:
        raise NameUnknown(
            f"signal = {trigger.signal!r}: the machine has none{nearest(str(trigger.signal), [*columns])}"
        )
    validate.one_of("slope", trigger.slope, [*SLOPES])
    validate.one_of("mode", trigger.mode, [*MODES])
    if not math.isfinite(validate.number("level", trigger.level, "")):
        raise ValueRefused(f"level = {trigger.level!r}: allowed are finite numbers in the unit of {trigger.signal}")
    if trigger.hysteresis is not None and not 0.0 <= validate.number("hysteresis", trigger.hysteresis, "") < math.inf:
        raise ValueRefused(f"hysteresis = {trigger.hysteresis!r}: allowed range is [0, inf), or none for the noise")
    if not 0.0 <= validate.number("pre", trigger.pre, "") <= 1.0:
        raise ValueRefused(
            f"pre = {trigger.pre!r}: allowed range is [0, 1], the share of the capture before its trigger"
        )
    length_s = validate.number("length_s", trigger.length_s, "s")
    rows = round(length_s / period_s) if abs(length_s) < math.inf else 0
    if not 2 <= rows <= capacity:
        raise ValueRefused(
            f"length_s = {trigger.length_s!r}: allowed range is [{2 * period_s:g}, {capacity * period_s:g}] s, what "
            f"the scope keeps of {len(columns)} signals"
        )
    return list(columns).index(trigger.signal), rows, round(trigger.pre * (rows - 1))


def noise(values: np.ndarray) -> float:
    """Standard deviation of the noise on a signal, in its unit; 0 where there are too few values to tell.

    By the median of third differences, in which motion that is smooth over eight rows cancels.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        third = np.abs(np.diff(values, n=3))
    third = third[np.isfinite(third)]
    return float(np.median(third)) * _THIRD if len(third) >= 8 else 0.0


class Crossing:
    """Finds the row in which a signal reaches a level, having been beyond it by the hysteresis before."""

    def __init__(self, level: float, slope: str) -> None:
        self.width = 0.0
        self._level = float(level)
        self._signs = {"rising": (1.0,), "falling": (-1.0,), "either": (1.0, -1.0)}[slope]
        self._ready = [False] * len(self._signs)

    def restart(self, width: float, last: float) -> None:
        """From a row with the value ``last`` on (NaN: from nothing), with a hysteresis of ``width``."""
        self.width = width
        self._ready = [bool(self._below(np.array([s * last]), s)[0]) for s in self._signs]

    def look(self, values: np.ndarray) -> int | None:
        """The first of the next rows that fires; None where none does."""
        found = [self._one(k, sign * values) for k, sign in enumerate(self._signs)]
        return min((f for f in found if f is not None), default=None)

    def _below(self, values: np.ndarray, sign: float) -> np.ndarray:
        level = sign * self._level
        return np.isfinite(values) & (values < level) & (values <= level - self.width)

    def _one(self, k: int, values: np.ndarray) -> int | None:
        at = np.arange(len(values))
        below = np.maximum.accumulate(np.where(self._below(values, self._signs[k]), at, -1 if self._ready[k] else -3))
        broken = np.maximum.accumulate(np.where(np.isfinite(values), -2, at))
        ready = below > broken
        before = np.concatenate(([self._ready[k]], ready[:-1]))
        hits = np.flatnonzero(before & (values >= self._signs[k] * self._level) & np.isfinite(values))
        self._ready[k] = bool(ready[-1])
        return int(hits[0]) if len(hits) else None


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
        self.period_s = validate.positive("period_s", period_s, "s")
        if not self.columns:
            raise ValueRefused("a scope needs at least one signal")
        wanted = math.ceil(validate.positive("seconds", seconds, "s") / self.period_s * (1.0 - 1e-12))
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
            NameUnknown, ValueRefused: as :func:`leadscrew.operate.scope.checked`.
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
