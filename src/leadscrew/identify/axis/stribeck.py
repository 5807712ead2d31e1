"""The one parameter of the friction's form that force is not linear in: the speed of the Stribeck fall.

For each of a row of speeds the other parameters follow by least squares; the fit is best where the residual is least
(a separable problem: G. Golub and V. Pereyra, 1973). At the best speed the line is extended by the slope of the term
against the logarithm of the speed, so the covariance holds all parameters together. The speed is common to both
directions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadscrew.identify.axis.filters import Samples, length_of, smoothed
from leadscrew.identify.axis.inverse_dynamics import APART, LinearFit, fit_rows, rows_of
from leadscrew.identify.axis.record import Record
from leadscrew.identify.axis.terms import Terms, columns

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
