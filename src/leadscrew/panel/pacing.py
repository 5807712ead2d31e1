"""How many periods are due: simulated time kept to wall time, and never a spiral where the computer is too slow."""

from __future__ import annotations

import math

SLOWEST, FASTEST = 0.001, 20.0
"""Simulated seconds to a second, at the least and at the most."""
FIRST = 64
"""Periods that the first tick may have."""
LENIENT_S = 0.25
"""Wall time that may be made up for after a hitch; more is dropped."""
SAID_S = 1.0
"""How long after time was dropped the machine is still said to be behind."""


class Pacer:
    """Due periods at each tick.

    A tick may compute for about ``budget_s``: how many periods that are is learnt from ``spent``, doubled while there
    is room and cut as soon as there is none. Periods that do not fit wait; once more than ``LENIENT_S`` of wall time
    waits, the rest is dropped and ``behind`` says so.
    """

    def __init__(self, period_s: float, budget_s: float = 0.012) -> None:
        self.period_s, self.budget_s = period_s, budget_s
        self.speed = 1.0
        self._last: float | None = None
        self._owed = 0.0
        self._most = FIRST
        self._dropped_at = -math.inf

    def pause(self) -> None:
        """Wall time from here on is not made up for."""
        self._last, self._owed = None, 0.0

    def due(self, now: float) -> int:
        """Periods to compute in the tick at ``now`` (monotonic s)."""
        passed = 0.0 if self._last is None else max(0.0, now - self._last)
        self._last = now
        self._owed += passed * self.speed / self.period_s
        most = max(2.0, LENIENT_S * self.speed / self.period_s)
        if self._owed > most:
            self._owed = most
            self._dropped_at = now
        periods = min(int(self._owed + 1e-9), self._most)
        self._owed = max(0.0, self._owed - periods)
        return periods

    def spent(self, periods: int, wall_s: float) -> None:
        """What the last tick's periods cost."""
        if wall_s > self.budget_s:
            self._most = max(1, int(periods * self.budget_s / wall_s))
        elif periods >= self._most and wall_s < 0.5 * self.budget_s:
            self._most = min(2 * self._most, 10_000_000)

    def behind(self, now: float) -> bool:
        """Whether time was dropped just now."""
        return now - self._dropped_at < SAID_S


__all__ = ["FASTEST", "SLOWEST", "Pacer"]
