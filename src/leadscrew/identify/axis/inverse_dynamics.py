"""Mass and friction by linear least squares: what the drive pushed, explained by how the axis moved.

    minimise  sum_r w_r (u_r - sum_j theta_j phi_jr)^2

over rows ``r``: force and terms under one window of :mod:`leadscrew.identify.axis.record`, a quarter of its length
apart. Huber's weights (1 up to 1.345 standard deviations, then falling with the distance) keep jolts from deciding.

Covariance: what filters leave is coloured, and what the model lacks (a ripple of the screw) is no noise at all. The
log is therefore cut into blocks of at least :data:`BLOCK` windows, the clusters of
:func:`leadscrew.identify.estimation.clustered`: of the residual it asks only that blocks are nearly independent. (P.
Huber, *Robust Statistics*, 1981, for the weights.)

The terms of an axis that are linear in what is sought, sample by sample.

    u = M a + offset + C sgn v + B v + (S - C) sgn v exp(-(v / v_s)^2)

``C``, ``B`` and ``S - C`` once for both directions, or once for each. By direction there is no offset beside them: a
constant force pushes like a Coulomb friction that is larger one way and smaller the other, at rest as in motion, and no
log of drive and motion can tell the two apart. It is then counted as friction, unless it is given.

The one parameter of the friction's form that force is not linear in: the speed of the Stribeck fall.

For each of a row of speeds the other parameters follow by least squares; the fit is best where the residual is least
(a separable problem: G. Golub and V. Pereyra, 1973). At the best speed the line is extended by the slope of the term
against the logarithm of the speed, so the covariance holds all parameters together. The speed is common to both
directions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from leadscrew.identify.axis.record import Record, Samples, held, length_of, smoothed, touched
from leadscrew.identify.estimation import Spread, clustered
from leadscrew.util.errors import DataError

SIDES = ("forward", "backward")


def friction_key(side: str, name: str) -> str:
    """Dotted key of a friction parameter."""
    return f"friction.{side}.{name}"


@dataclass(frozen=True)
class Terms:
    """Which terms a model has, and which of them are known."""

    symmetric: bool = True
    stribeck_speed: tuple[float, float] | None = None
    """Of both directions; None: no Stribeck term."""
    known: Mapping[str, float] = field(default_factory=dict)
    """Values that are not sought, by key; ``friction.*.excess`` stands for static less Coulomb friction."""
    without: frozenset[str] = frozenset()
    """Keys that the log cannot tell: left out, which is 0."""

    @property
    def keys(self) -> tuple[str, ...]:
        """All terms of the model, known ones too; symmetric friction has the keys of ``forward``."""
        sides = SIDES[:1] if self.symmetric else SIDES
        names = ["coulomb", "viscous"] + (["excess"] if self.stribeck_speed else [])
        found = ["mass", *(friction_key(s, n) for n in names for s in sides), "offset"]
        if not self.symmetric and "offset" not in self.known:
            found.remove("offset")
        return tuple(key for key in found if key not in self.without)

    @property
    def sought(self) -> tuple[str, ...]:
        """The terms that a fit finds."""
        return tuple(key for key in self.keys if key not in self.known)


def columns(samples: Samples, terms: Terms, keys: Sequence[str]) -> np.ndarray:
    """What one unit of each key makes of force, shape (samples, keys)."""
    return np.column_stack([_column(samples, terms, key) for key in keys])


def _column(s: Samples, terms: Terms, key: str) -> np.ndarray:
    if key == "mass":
        return s.acceleration
    if key == "offset":
        return np.ones_like(s.speed)
    _, side, name = key.split(".")
    share = np.ones_like(s.sign) if terms.symmetric else 0.5 * (1.0 + (1.0 if side == "forward" else -1.0) * s.sign)
    way = s.sign if terms.symmetric else share * (1.0 if side == "forward" else -1.0)
    if name == "coulomb":
        return way
    if name == "viscous":
        return share * s.speed
    assert terms.stribeck_speed is not None
    fall = terms.stribeck_speed[0 if side == "forward" else 1]
    return np.asarray(way * np.exp(-((s.smooth / fall) ** 2)))


HUBER = 1.345
ROUNDS = 8
BLOCK = 6
"""Length of a block, in windows."""
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
    degrees: np.ndarray
    """Of freedom of Student's t, by key."""
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
    """Huber's regression of the used rows; ``keys`` name the columns, else ``terms.sought`` does."""
    keys = keys or terms.sought
    a, b, at = rows.matrix[rows.used], rows.force[rows.used], rows.at[rows.used]
    refuse_few(rows, len(keys), length)
    scale = np.sqrt(np.mean(a * a, axis=0))
    safe = np.where(scale > 0.0, scale, 1.0)
    z = a / safe
    theta, weights = huber(z, b)
    spread = weighted(z, b - z @ theta, weights, blocks(at, length, len(keys)))
    left = rows.force - rows.matrix @ (theta / safe)
    whole = b + rows.known[rows.used]
    return LinearFit(
        keys=keys, values=dict(zip(keys, (theta / safe).tolist(), strict=True)),
        covariance=spread.covariance / np.outer(safe, safe), degrees=spread.degrees,
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


def weighted(z: np.ndarray, left: np.ndarray, weights: np.ndarray, block: np.ndarray) -> Spread:
    """Covariance of a weighted fit, by block."""
    root = np.sqrt(weights)
    return clustered(z * root[:, None], left * root, block)


def blocks(at: np.ndarray, length: int, keys: int) -> np.ndarray:
    """Number of the block that each row is in: of equal duration, at least :data:`BLOCK` windows."""
    span = float(at[-1] - at[0] + 1)
    count = int(np.clip(span // (BLOCK * length), max(4, keys + 2), BLOCKS))
    return np.asarray(np.minimum((at - at[0]) * count // span, count - 1), dtype=np.int64)


TRIED = 16
"""Stribeck speeds of the first search, from the slowest sure speed to :data:`FASTEST` of the top speed."""
FASTEST = 0.3
KEY = "friction.forward.stribeck_speed"


def stribeck_fit(record: Record, terms: Terms, corner_hz: float, delay: float = 0.0) -> LinearFit:
    """The best line with a Stribeck term; its keys end with the Stribeck speed, unless ``terms.known`` has it.

    Raises:
        DataError: too few rows.
    """
    length = length_of(corner_hz, record.period)
    s = record.samples
    base = rows_of(record, replace(terms, stribeck_speed=None), length, delay)
    if KEY in terms.known:
        fall = float(terms.known[KEY])
        known = replace(terms, stribeck_speed=(fall, fall))
        return fit_rows(rows_of(record, known, length, delay), known, length, delay)
    lowest, highest = np.log(s.slow_speed), np.log(max(FASTEST * float(np.max(np.abs(s.smooth))), 4.0 * s.slow_speed))
    step = max(1, length // APART)

    plain, _ = np.linalg.qr(_scaled(base.matrix[base.used]))
    force = _beside(plain, base.force[base.used])

    def left(log_fall: float) -> float:
        extra = _scaled(_beside(plain, smoothed(_fall_columns(s, terms, log_fall), length, step)[base.used]))
        q, _ = np.linalg.qr(extra)
        return float(force @ force - np.sum((q.T @ force) ** 2))

    tried = np.linspace(lowest, highest, TRIED)
    best = float(tried[int(np.argmin([left(t) for t in tried]))])
    width = float(tried[1] - tried[0])
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(left, bounds=(best - width, best + width), method="bounded", options={"xatol": 1e-4})
    fall = float(np.exp(found.x))
    full = replace(terms, stribeck_speed=(fall, fall))
    fit = fit_rows(rows_of(record, full, length, delay), full, length, delay)
    slope = (_fall_columns(s, terms, found.x + 1e-3) - _fall_columns(s, terms, found.x - 1e-3)) / 2e-3
    excess = [fit.values.get(k, 0.0) for k in _excess_keys(full)]
    return _extended(fit, smoothed(slope, length, step) @ np.array(excess), fall)


def _excess_keys(terms: Terms) -> list[str]:
    sides = ("forward",) if terms.symmetric else ("forward", "backward")
    return [f"friction.{side}.excess" for side in sides]


def _fall_columns(s: Samples, terms: Terms, log_fall: float) -> np.ndarray:
    fall = float(np.exp(log_fall))
    return columns(s, replace(terms, stribeck_speed=(fall, fall)), _excess_keys(terms))


def _beside(plain: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """What orthonormal columns leave of others."""
    return np.asarray(columns - plain @ (plain.T @ columns))


def _scaled(columns: np.ndarray) -> np.ndarray:
    """Columns of the length of one; a column of zeros stays one."""
    size = np.sqrt(np.sum(columns * columns, axis=0))
    return np.asarray(columns / np.where(size > 0.0, size, 1.0))


def _extended(fit: LinearFit, slope: np.ndarray, fall: float) -> LinearFit:
    """The fit with the Stribeck speed as its last key, linearised; ``slope`` is against the speed's logarithm."""
    size = float(np.sqrt(np.mean(slope[fit.rows.used] ** 2)))
    if not size > 0.0:
        return fit
    rows = fit.rows._replace(matrix=np.column_stack([fit.rows.matrix, slope / fall]))
    keys = (*fit.keys, KEY)
    wide = fit_rows(rows, fit.terms, fit.length, fit.delay, keys)
    return replace(
        wide, values=fit.values | {KEY: fall}, residual=fit.residual, rms=fit.rms, rows=rows, condition=fit.condition
    )
