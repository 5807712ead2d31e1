"""Mass and friction by linear least squares: what the drive pushed, explained by how the axis moved.

    minimise  sum_r w_r (u_r - sum_j theta_j phi_jr)^2

over rows ``r``: force and terms under one window of :mod:`leadscrew.identify.axis.filters`, a quarter of its length
apart. Huber's weights (1 up to 1.345 standard deviations, then falling with the distance) keep jolts from deciding.

Covariance: what filters leave is coloured, and what the model lacks (a ripple of the screw) is no noise at all. The
log is therefore cut into blocks of at least :data:`BLOCK` windows, the fit repeated without each in turn, and the
scatter of these fits is the covariance,

    cov = (G - 1) / G  sum_g (theta_g - mean) (theta_g - mean)'

(delete-a-group jackknife; P. Huber, *Robust Statistics*, 1981, for the weights; B. Efron, *The Jackknife*, 1982.)
It asks of the residual only that blocks are nearly independent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.identify.axis.filters import held, length_of, smoothed, touched
from leadscrew.identify.axis.record import Record
from leadscrew.identify.axis.terms import Terms, columns
from leadscrew.kernel.errors import DataError

HUBER = 1.345
ROUNDS = 8
BLOCK = 6
"""Length of a block of the jackknife, in windows."""
BLOCKS = 40
"""At most so many blocks: longer ones where the log is long."""
APART = 4
"""Rows in the length of a window."""


class Rows(NamedTuple):
    """The regression: every row one window."""

    matrix: np.ndarray
    """What one unit of each sought parameter makes of force, shape (rows, sought)."""
    force: np.ndarray
    """Force less what known terms make, shape (rows,)."""
    known: np.ndarray
    """What the known terms make."""
    speed: np.ndarray
    acceleration: np.ndarray
    at: np.ndarray
    """Sample in the middle of each window."""
    used: np.ndarray
    """Whether the row takes part: its sign is sure throughout."""


@dataclass(frozen=True)
class LinearFit:
    """Parameters of a line through the rows."""

    keys: tuple[str, ...]
    values: dict[str, float]
    covariance: np.ndarray
    """Shape (keys, keys)."""
    freedom: int
    """Degrees of freedom of the covariance: blocks less one."""
    condition: float
    """Of the matrix with columns of equal length."""
    effect: dict[str, float]
    """Root mean square of the force that each term makes for a unit of its parameter."""
    rows: Rows
    residual: np.ndarray
    """Force less the model's, all rows, also unused ones."""
    rms: float
    """Of the residual of used rows."""
    rms_force: float
    length: int
    """Of the window, in samples."""
    terms: Terms
    delay: float
    """Periods that the force was taken late."""

    @property
    def standard_error(self) -> dict[str, float]:
        """Of each parameter."""
        return dict(zip(self.keys, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> np.ndarray:
        """Between the parameters, shape (keys, keys)."""
        spread = np.sqrt(np.diag(self.covariance))
        safe = np.where(spread > 0.0, spread, 1.0)
        return np.asarray(self.covariance / np.outer(safe, safe))


def rows_of(record: Record, terms: Terms, length: int, delay: float = 0.0, step: int | None = None) -> Rows:
    """The regression of a record; ``step``: samples from row to row, a quarter of the window unless given."""
    s = record.samples
    step = step or max(1, length // APART)
    every = terms.keys
    table = smoothed(columns(s, terms, every), length, step)
    sought = [every.index(key) for key in terms.sought]
    known = np.zeros(len(table))
    for key, value in terms.known.items():
        if key in every:
            known = known + value * table[:, every.index(key)]
    force = smoothed(held(record.force, delay), length, step) - known
    at = 1 + np.arange(len(table)) * step + length // 2
    speed, acceleration = (smoothed(z, length, step) for z in (s.speed, s.acceleration))
    left_out = s.slow if record.hidden is None else s.slow | record.hidden[1:-1]
    return Rows(table[:, sought], force, known, speed, acceleration, at, ~touched(left_out, length, step))


def stretches(flags: np.ndarray) -> list[tuple[int, int]]:
    """First and last (left out) of each run of true flags."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return list(zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True))


def inverse_dynamics(record: Record, terms: Terms, corner_hz: float, *, delay: float = 0.0) -> LinearFit:
    """The terms that explain the force best.

    Args:
        record: position and force.
        terms: the model; values in ``terms.known`` are not sought.
        corner_hz: of the window that both sides go through.
        delay: periods from a logged force to its act, any number.

    Raises:
        DataError: too few rows in which the axis surely moves.
    """
    length = length_of(corner_hz, record.period)
    return fit_rows(rows_of(record, terms, length, delay), terms, length, delay)


def fit_rows(rows: Rows, terms: Terms, length: int, delay: float, keys: tuple[str, ...] | None = None) -> LinearFit:
    """Huber's regression of the used rows with its jackknife; ``keys`` name the columns, else ``terms.sought`` does."""
    keys = keys or terms.sought
    a, b, at = rows.matrix[rows.used], rows.force[rows.used], rows.at[rows.used]
    refuse_few(rows, len(keys), length)
    scale = np.sqrt(np.mean(a * a, axis=0))
    safe = np.where(scale > 0.0, scale, 1.0)
    z = a / safe
    theta, weights = huber(z, b)
    freedom, covariance = jackknife(z, b, weights, blocks(at, length, len(keys)))
    left = rows.force - rows.matrix @ (theta / safe)
    whole = b + rows.known[rows.used]
    return LinearFit(
        keys=keys, values=dict(zip(keys, (theta / safe).tolist(), strict=True)),
        covariance=covariance / np.outer(safe, safe), freedom=freedom,
        condition=float(np.linalg.cond(z)) if keys else 1.0,
        effect=dict(zip(keys, scale.tolist(), strict=True)), rows=rows, residual=left,
        rms=float(np.sqrt(np.mean(left[rows.used] ** 2))), rms_force=float(np.sqrt(np.mean(whole**2))),
        length=length, terms=terms, delay=delay,
    )  # fmt: skip


def refuse_few(rows: Rows, keys: int, length: int) -> None:
    """Refuses a regression of too few rows.

    Raises:
        DataError: fewer than three rows for each parameter and one more.
    """
    moving = int(rows.used.sum())
    if moving < 3 * (keys + 1):
        raise DataError(
            f"the axis surely moves in {moving} of {len(rows.used)} windows of {length} samples, too few to find "
            f"{keys} parameters: let it move longer or faster, sample faster, or take a finer encoder (of a log with a "
            "hold-out, only the first part trains)"
        )


def huber(z: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parameters and weights of Huber's regression by repeated least squares."""
    weights = np.ones(len(b))
    theta = np.zeros(z.shape[1])
    for _ in range(ROUNDS):
        root = np.sqrt(weights)
        before, theta = theta, np.linalg.lstsq(z * root[:, None], b * root, rcond=None)[0]
        left = np.abs(b - z @ theta)
        deviation = 1.4826 * float(np.median(left))
        if not deviation > 0.0 or np.allclose(before, theta, rtol=1e-6, atol=0.0):
            break
        weights = np.minimum(1.0, HUBER * deviation / np.maximum(left, 1e-300))
    return theta, weights


def blocks(at: np.ndarray, length: int, keys: int) -> np.ndarray:
    """Number of the block that each row is in: of equal duration, at least :data:`BLOCK` windows."""
    span = float(at[-1] - at[0] + 1)
    count = int(np.clip(span // (BLOCK * length), max(4, keys + 2), BLOCKS))
    return np.asarray(np.minimum((at - at[0]) * count // span, count - 1), dtype=np.int64)


def jackknife(z: np.ndarray, b: np.ndarray, weights: np.ndarray, block: np.ndarray) -> tuple[int, np.ndarray]:
    """Degrees of freedom and covariance from fits without each block in turn."""
    count, p = int(block[-1]) + 1, z.shape[1]
    wz = z * weights[:, None]
    whole, side = wz.T @ z, wz.T @ b
    fits = []
    for g in np.unique(block):
        inside = block == g
        fits.append(np.linalg.lstsq(whole - wz[inside].T @ z[inside], side - wz[inside].T @ b[inside], rcond=None)[0])
    table = np.array(fits)
    if len(table) < 2:
        return 1, np.full((p, p), np.inf)
    apart = table - table.mean(axis=0)
    return min(count, len(table)) - 1, (len(table) - 1) / len(table) * apart.T @ apart
