"""A session in figures: the error under each setting, and the run's lines thinned out for a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from leadscrew.operate.profile import Profile


@dataclass
class Stretch:
    """The run between two changes."""

    first: int
    """Its first period."""
    events: list[int]
    """Numbers, from 1 on, of the changes that it begins with; none for the start."""
    rows: int = 0
    squares: np.ndarray = field(default_factory=lambda: np.zeros(0))
    largest: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def rms(self) -> np.ndarray:
        """Of each error."""
        return np.sqrt(self.squares / max(1, self.rows))

    def add(self, errors: np.ndarray) -> None:
        """Further rows of the errors, in their order of time."""
        if not self.rows:
            self.squares, self.largest = np.zeros(errors.shape[1]), np.zeros(errors.shape[1])
        self.rows += len(errors)
        self.squares = self.squares + np.square(errors).sum(axis=0)
        self.largest = np.maximum(self.largest, np.abs(errors).max(axis=0, initial=0.0))


@dataclass(frozen=True)
class Judged:
    """An error that the report gives figures of."""

    column: str
    label: str
    factor: float
    unit: str


def judged(profile: Profile, columns: list[str], units: dict[str, str]) -> list[Judged]:
    """The true errors in the units in which the profile shows them, else in those of the loop."""
    shown = {t.signal: t for plot in profile.plots for t in plot.traces}
    found = []
    for column in columns:
        own = column.removeprefix("y.")
        if own == "true_error" or own.startswith("true_error."):
            trace = shown.get(own) or shown.get(own.replace("true_error", "error", 1))
            axis = "Y: " if column != own else ""
            label = f"{axis}{own.replace('_', ' ')}"
            found.append(
                Judged(column, label, trace.factor, trace.unit) if trace else Judged(column, label, 1.0, units[column])
            )
    return found


class Envelope:
    """The smallest and the largest value of each column in every bucket of periods: what a plot can show."""

    def __init__(self, columns: list[str], periods: int, period_s: float, buckets: int = 1500) -> None:
        self.columns = columns
        self.size = max(1, math.ceil(periods / buckets))
        self.period_s = period_s
        self._left = np.zeros((0, len(columns)))
        self._low: list[np.ndarray] = []
        self._high: list[np.ndarray] = []

    def feed(self, columns: list[str], rows: np.ndarray) -> None:
        """Further rows; a column that they do not have is NaN."""
        at = {c: i for i, c in enumerate(columns)}
        wanted = np.full((len(rows), len(self.columns)), np.nan)
        for i, c in enumerate(self.columns):
            if c in at:
                wanted[:, i] = rows[:, at[c]]
        whole = np.concatenate([self._left, wanted])
        n = len(whole) // self.size
        self._keep(whole[: n * self.size].reshape(n, self.size, len(self.columns)))
        self._left = whole[n * self.size :]

    def _keep(self, buckets: np.ndarray) -> None:
        if buckets.size:
            self._low.append(buckets.min(axis=1))
            self._high.append(buckets.max(axis=1))

    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Times, and the columns at them: two values a bucket unless it is one period."""
        if len(self._left):
            self._keep(self._left[None])
            self._left = self._left[:0]
        if not self._low:
            return np.zeros(0), np.zeros((0, len(self.columns)))
        low, high = np.concatenate(self._low), np.concatenate(self._high)
        t = np.arange(len(low)) * self.size * self.period_s
        if self.size == 1:
            return t, low
        return np.repeat(t, 2), np.stack([low, high], axis=1).reshape(2 * len(low), -1)


__all__ = ["Envelope", "Judged", "Stretch", "judged"]
