"""How late the drive acts: the delay with which force and motion agree best, with its interval.

The force, taken ``tau`` periods late (any number, :func:`leadscrew.identify.axis.record.held`), is explained by the
terms of the model; the delay is that with the least residual. First whole periods are tried; then the straight line is
extended by the slope of the force against the delay,

    u(tau0) = sum_j theta_j phi_j - (tau - tau0) du/dtau,

and solved again until ``tau`` stands still. Its interval comes from the same covariance as those of the parameters, so
it knows of what the delay trades with. A delay whose interval holds 0 is taken as 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.identify.axis.inverse_dynamics import APART, Terms, blocks, huber, refuse_few, rows_of, weighted
from leadscrew.identify.axis.record import Record, held, length_of, smoothed
from leadscrew.identify.estimation import identifiable, quantile

EARLIEST, LONGEST_S = -6, 0.05
"""Delays that are tried, in periods and in seconds."""
ROUNDS = 6
FLOOR = 0.02
"""Added to half of the interval, in periods: signs of the speed are not timed better between the samples."""
NOT_OUT = 4.0
"""Rise of the sum of squares, in variances of a row, up to which a delay is not ruled out (95 %)."""
SLOPE = 0.25
"""Half of the step, in periods, over which the force's slope against the delay is taken."""


class Delay(NamedTuple):
    """In periods."""

    value: float
    low: float
    high: float
    """95 % interval."""
    sharp: bool
    """Whether it is identifiable and off the ends of what is tried."""

    @property
    def open(self) -> bool:
        """Whether the linear stage does not determine it and it may be above 0: a simulation, which knows the drive
        exactly where least squares takes noise of the sensor for motion, may.
        """
        return not self.sharp and self.high > 0.0

    @property
    def used(self) -> float:
        """0 where the interval holds it or lies below it, or where the delay is not identifiable."""
        return self.value if self.low > 0.0 and self.sharp else 0.0


def find_delay(record: Record, terms: Terms, corner_hz: float) -> Delay:
    """The delay between force and motion, in periods of the log.

    Raises:
        DataError: too few rows in which the axis surely moves.
    """
    length = length_of(corner_hz, record.period)
    rows = rows_of(record, terms, length)
    refuse_few(rows, rows.matrix.shape[1] + 1, length)
    used, step = rows.used, max(1, length // APART)
    scale = np.sqrt(np.mean(rows.matrix[used] ** 2, axis=0))
    z = rows.matrix[used] / np.where(scale > 0.0, scale, 1.0)

    def force(delay: float) -> np.ndarray:
        return np.asarray((smoothed(held(record.force, delay), length, step) - rows.known)[used])

    latest = max(3, min(round(LONGEST_S / record.period), 60))
    tried = np.arange(EARLIEST, latest + 1)
    base, _ = np.linalg.qr(z)
    every = smoothed(held(record.force), length, 1)
    rows_at = np.arange(len(used)) * step
    sums = np.array([_left(base, _late(every, rows_at - d)[used] - rows.known[used]) for d in tried])
    tau = float(tried[int(np.argmin(sums))])
    for _ in range(ROUNDS):
        slope = (force(tau + SLOPE) - force(tau - SLOPE)) / (2.0 * SLOPE)
        size = float(np.sqrt(np.mean(slope**2))) or 1.0
        table = np.column_stack([z, -slope / size])
        theta, weights = huber(table, force(tau))
        change = float(np.clip(theta[-1] / size, -2.0, 2.0))
        tau += change
        if abs(change) < 1e-4 or not EARLIEST - 2 < tau < latest + 2:
            break
    left = force(tau - change) - table @ theta
    spread = weighted(table, left, weights, blocks(rows.at[used], length, table.shape[1]))
    half = FLOOR + quantile(float(spread.degrees[-1])) * float(np.sqrt(spread.covariance[-1, -1])) / size
    low, high, sharp = tau - half, tau + half, identifiable(tau, half, 1.0) and EARLIEST < tau < latest
    if not sharp:
        # a flat minimum: all that the sum of squares does not rule out; rows overlap, so half of them count
        count = max(1.0, 0.5 * float(used.sum()) - z.shape[1])
        open_to = tried[sums <= np.min(sums) * (1.0 + NOT_OUT / count)]
        low, high = min(low, float(open_to[0])), max(high, float(open_to[-1]))
    return Delay(tau, low, high, sharp)


def _late(every: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The windowed force of whole delays: a shift."""
    return np.asarray(every[np.clip(at, 0, len(every) - 1)])


def _left(base: np.ndarray, force: np.ndarray) -> float:
    """Sum of squares that the columns of ``base`` (orthonormal) leave."""
    return float(force @ force - np.sum((base.T @ force) ** 2))
