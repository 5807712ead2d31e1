"""When a scope fires: a signal that crosses a level between two successive rows, with a hysteresis against noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadscrew.kernel import door
from leadscrew.kernel.errors import NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest

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
    door.one_of("slope", trigger.slope, [*SLOPES])
    door.one_of("mode", trigger.mode, [*MODES])
    if not math.isfinite(door.number("level", trigger.level, "")):
        raise ValueRefused(f"level = {trigger.level!r}: allowed are finite numbers in the unit of {trigger.signal}")
    if trigger.hysteresis is not None and not 0.0 <= door.number("hysteresis", trigger.hysteresis, "") < math.inf:
        raise ValueRefused(f"hysteresis = {trigger.hysteresis!r}: allowed range is [0, inf), or none for the noise")
    if not 0.0 <= door.number("pre", trigger.pre, "") <= 1.0:
        raise ValueRefused(
            f"pre = {trigger.pre!r}: allowed range is [0, 1], the share of the capture before its trigger"
        )
    length_s = door.number("length_s", trigger.length_s, "s")
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
