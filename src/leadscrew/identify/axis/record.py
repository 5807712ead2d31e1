"""The log of an axis as the linear stage takes it: arrays, the sampling period, and how noisy the position is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel.errors import DataError

if TYPE_CHECKING:
    from leadscrew.identify.axis.filters import Samples

LEAST = 300
"""Samples that a fit needs at least."""


@dataclass(frozen=True)
class Record:
    """Evenly sampled position and force in SI units; the force is held from each sample to the next."""

    period: float
    """s."""
    position: np.ndarray
    """m or rad, shape (n,)."""
    force: np.ndarray
    """N or N m, or the drive's own unit, shape (n,)."""
    count: float
    """Smallest change of the position: the encoder's step."""
    noise: float
    """Of the position, root mean square, rounding to counts included."""
    start: float = 0.0
    """Time of the first sample, s."""
    hidden: np.ndarray | None = None
    """Samples that take no part in a regression, boolean, shape (n,); None: all take part."""

    @cached_property
    def samples(self) -> Samples:
        """Differences and signs of the speed, see :func:`leadscrew.identify.axis.filters.samples`."""
        from leadscrew.identify.axis.filters import samples

        return samples(self)

    def part(self, first: int, last: int) -> Record:
        """Samples ``first`` to ``last`` (left out)."""
        return replace(
            self,
            position=self.position[first:last],
            force=self.force[first:last],
            start=self.start + first * self.period,
            hidden=None if self.hidden is None else self.hidden[first:last],
        )

    def without(self, hidden: np.ndarray) -> Record:
        """The same record with samples hidden from a regression; differences and signs stay those of all."""
        found = replace(self, hidden=hidden)
        found.__dict__["samples"] = self.samples
        return found


def record_of(log: Any, force_per_drive: float = 1.0) -> Record:
    """The record of an :class:`~leadscrew.logs.arrays.AxisLog`; its drive times ``force_per_drive`` is the force.

    Raises:
        DataError: fewer than :data:`LEAST` samples, or a position that stands still.
    """
    return record(log.period, log.position, np.asarray(log.drive) * force_per_drive, float(log.time[0]), log.source)


def record(
    period: float, position: np.ndarray, force: np.ndarray, start: float = 0.0, source: str = "the log"
) -> Record:
    """The record of arrays, checked; the arrays are not changed.

    Raises:
        DataError: fewer than :data:`LEAST` samples, or a position that stands still.
    """
    y, u = np.asarray(position, dtype=np.float64), np.asarray(force, dtype=np.float64)
    if y.size < LEAST:
        raise DataError(f"{source}: {y.size} samples; a model of an axis needs at least {LEAST}")
    if not np.ptp(y) > 0.0:
        raise DataError(f"{source}: the position stands still at {y[0]:g}: let the axis move")
    count = _count(y)
    return Record(float(period), y, u, count, _noise(y, count), start)


def _count(y: np.ndarray) -> float:
    """The smallest change from sample to sample; rounding errors of a decimal file are no counts."""
    moves = np.abs(np.diff(y))
    real = moves[moves > 1e-9 * float(np.ptp(y))]
    return float(np.min(real)) if real.size else 0.0


def _noise(y: np.ndarray, count: float) -> float:
    """From differences of fourth order where the axis is slow: there a smooth motion leaves nothing.

    White noise of the standard deviation s has differences of the variance 70 s^2. Not below count / sqrt(12), unless
    the position does not lie on counts.
    """
    wobble = np.abs(np.diff(y, 4))
    way = np.abs(y[4:] - y[:-4])
    slow = wobble[way <= max(2.5 * count, float(np.quantile(way, 0.3)))]
    slow = slow[slow <= np.quantile(slow, 0.99)]
    met = float(np.sqrt(np.mean(slow**2) / 70.0))
    on_counts = count > 0.0 and float(np.mean(np.abs((y - y[0]) / count - np.rint((y - y[0]) / count)) < 0.05)) > 0.95
    return max(met, count / np.sqrt(12.0)) if on_counts else met
