"""The log of an axis as the linear stage takes it: arrays, the sampling period, and how noisy the position is.

Derivatives of a sampled position and a low-pass that force and motion go through alike.

Between two samples the force is held, so the motion obeys exactly, with ``hat`` the triangle of width two periods,

    M (x[k+1] - 2 x[k] + x[k-1]) / dt^2 + hat * F(v) + offset = hat * u = (u[k-1] + u[k]) / 2

The central differences need no approximation of an acceleration. Then every term goes through the same symmetrical
window (cosine to the fourth, N samples, corner (-3 dB) at :data:`CORNER` / ((N + 1) dt)). A filter common to both sides
of a linear equation shifts nothing: only what the window lets through of the noise counts. The window has an end, so a
row of the regression sees the samples under it and no others, and rows that touch a stand-still can be left out
exactly, as can the edges of the log.

The corner follows from the log (:func:`choose_length`): the shortest window that leaves, in the acceleration, noise of
no more than :data:`SHARE` of the variance. Noise in a regressor makes its coefficient too small by that share.

M. Gautier, *Dynamic identification of robots with power model*, ICRA 1997, has the parallel filter on both sides;
the window with an end is that of modulating functions (M. Shinbrot, 1957).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from leadscrew.util.errors import DataError

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
        """Differences and signs of the speed, see :func:`samples`."""
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
        raise DataError(f"{source}: the position is constant at {y[0]:g}: let the axis move")
    count = count_of(y)
    return Record(float(period), y, u, count, _noise(y, count), start)


def count_of(y: np.ndarray) -> float:
    """The smallest change from sample to sample, 0 for none; rounding errors of a decimal file are no counts."""
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


CORNER = 0.9263
"""Corner frequency times the length of the window, from zero to zero."""
SHARE = 2e-6
"""Of noise in the variance of the filtered acceleration that a window may leave."""
SHORTEST, LONGEST_S = 9, 0.25
"""Length of the window: at least so many samples, at most so many seconds."""
FREE = 0.5
"""Windows that touch no stand-still, as a share of what the shortest window has of them, that should be left."""
SURE = 4.0
"""A speed of so many standard deviations has a sure sign."""


class Samples(NamedTuple):
    """What belongs to the samples 1 to n - 2 of a record, unfiltered; shape (n - 2,)."""

    acceleration: np.ndarray
    speed: np.ndarray
    """Mean over two periods."""
    sign: np.ndarray
    """Mean sign of the speed over two periods, from -1 to 1; the speed is smoothed over :func:`speed_length`."""
    smooth: np.ndarray
    """The speed that the signs are of."""
    slow: np.ndarray
    """Whether the sign is not sure, or the axis may stand: boolean."""
    slow_speed: float
    """Below this a speed counts as slow."""


def window(length: int) -> np.ndarray:
    """Weights of a cosine to the fourth that sum to 1, shape (length,)."""
    weights = np.sin(np.pi * np.arange(1, length + 1) / (length + 1)) ** 4
    return np.asarray(weights / weights.sum())


def length_of(corner_hz: float, period: float) -> int:
    """Samples of the window with this corner, at least 3."""
    return max(3, round(CORNER / (corner_hz * period)) - 1)


def corner_of(length: int, period: float) -> float:
    """Corner (-3 dB) of the window, Hz."""
    return CORNER / ((length + 1) * period)


def speed_length(record: Record) -> int:
    """Samples that speed is smoothed over where its sign is sought, an odd number.

    The sign is not sure for as long as the window is, and while the axis is slower than the noise of the speed; the sum
    of the two is smallest at the length taken, at the root mean square of the acceleration.
    """
    dt = record.period
    rough = np.convolve(np.diff(record.position, 2), window(max(SHORTEST, round(0.02 / dt))), "valid") / dt**2
    pull = float(np.sqrt(np.mean(rough**2))) or 1.0
    lengths = [n for n in (5, 7, 9, 13, 19, 27, 39, 55, 79, 111, 157) if n * dt <= 0.5 * LONGEST_S] or [5]
    lost = [n + 2.0 * SURE * speed_noise(record.noise, n, dt) / (pull * dt) for n in lengths]
    return lengths[int(np.argmin(lost))]


def speed_noise(noise: float, length: int, period: float) -> float:
    """Standard deviation of a smoothed central difference."""
    return float(noise * np.sqrt(np.sum(np.convolve(window(length), [0.5, 0.0, -0.5]) ** 2)) / period)


def choose_length(record: Record) -> int:
    """The window's length by the rule above; less where too few windows would be free of stand-stills."""
    length = _by_noise(record)
    slow = record.samples.slow
    enough = FREE * float(np.mean(~touched(slow, SHORTEST, 1)))
    while length > SHORTEST and np.mean(~touched(slow, length, 1)) < enough:
        length = max(SHORTEST, int(length / 1.3))
    return length


def _by_noise(record: Record) -> int:
    """The shortest window whose acceleration holds no more than :data:`SHARE` of noise, or the longest allowed."""
    dt, n = record.period, len(record.position)
    longest = max(SHORTEST, min(round(LONGEST_S / dt), n // 40))
    second = np.diff(record.position, 2)
    length = SHORTEST
    while length < longest:
        weights = window(length)
        noise = record.noise**2 * float(np.sum(np.convolve(weights, [1.0, -2.0, 1.0]) ** 2))
        if noise <= SHARE * float(np.var(np.convolve(second, weights, "valid"))):
            return length
        length = max(length + 2, int(1.2 * length))
    return longest


def samples(record: Record) -> Samples:
    """Central differences, and the sign of the speed with where it is sure."""
    y, dt = record.position, record.period
    side = speed_length(record)
    steps = np.diff(y) / dt
    padded = np.pad(steps, side // 2, mode="edge")
    smooth = np.convolve(padded, window(side), "valid")
    middle = np.convolve(smooth, [0.5, 0.5], "valid")
    noise = speed_noise(record.noise, side, dt)
    low = max(SURE * noise, record.count / (side * dt), 1e-9 * float(np.max(np.abs(steps))))
    unsure = ((np.abs(middle) < low) | (smooth[:-1] * smooth[1:] <= 0.0)).astype(np.float64)
    near = np.convolve(unsure, np.ones(side), "same") > 0.5
    return Samples(
        np.diff(y, 2) / dt**2, (y[2:] - y[:-2]) / (2.0 * dt), _mean_sign(smooth), middle, near, low,
    )  # fmt: skip


def _mean_sign(speed: np.ndarray) -> np.ndarray:
    """Mean sign over the two periods around a sample; within a period the speed changes along a line."""
    a, b = speed[:-1], speed[1:]
    size = np.abs(a) + np.abs(b)
    return np.asarray(np.divide(a + b, size, out=np.zeros_like(size), where=size > 0.0))


def held(force: np.ndarray, delay: float = 0.0) -> np.ndarray:
    """``hat * u`` at the samples 1 to n - 2, the force acting ``delay`` periods late (any number, exact).

    The triangle around ``k - delay`` covers parts of four held values at most; before the log the first one holds,
    after it the last.
    """
    whole = int(np.floor(delay))
    f = delay - whole
    at = np.arange(1, len(force) - 1) - whole
    u = [force[np.clip(at - j, 0, len(force) - 1)] for j in (2, 1, 0)]
    return np.asarray(0.5 * f * f * u[0] + (0.5 + f - f * f) * u[1] + 0.5 * (1.0 - f) ** 2 * u[2])


def smoothed(values: np.ndarray, length: int, step: int) -> np.ndarray:
    """Every ``step``-th value of the windowed signal, no edges; shape (rows,) or (rows, columns)."""
    from scipy.signal import oaconvolve

    if values.shape[0] < length:
        return values[:0]
    weights = window(length)
    if values.ndim == 1:
        return np.asarray(oaconvolve(values, weights, "valid")[::step])
    return np.asarray(oaconvolve(values, weights[:, None], "valid", axes=0)[::step])


def touched(flags: np.ndarray, length: int, step: int) -> np.ndarray:
    """Whether a row's window touches a flagged sample; boolean, shape (rows,)."""
    total = np.concatenate([[0], np.cumsum(flags.astype(np.int64))])
    return np.asarray((total[length:] - total[:-length] > 0)[::step])
