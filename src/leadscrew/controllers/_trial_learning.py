"""Learning from pass to pass: the next feed-forward table of what the last pass lacked.

    u_next(k) = Q [ u(k) + gain d(k + lead) ],      k modulo n

``u`` is the table of a pass (:func:`~leadscrew.controllers.feed_forward_table`), ``d`` the torque
that was missing in that pass at the table's places: the load of a disturbance observer, or an error times a gain.
``lead`` makes up for the samples that the observer, the hold and the stage are late. ``Q`` is a Gaussian of a standard
deviation of ``width`` samples, forwards and backwards alike, so without a lag: it keeps out what would grow from pass
to pass at high frequency. What ``Q`` takes from ``u`` is missing for good: with ``gain d`` constant the table comes to
rest where ``(1 - Q) u = Q gain d``.

Source: iterative learning control with a zero-phase filter and a lead, D. A. Bristow, M. Tharayil, A. G. Alleyne, *A
survey of iterative learning control*, IEEE Control Systems Magazine 26 (2006) 96.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leadscrew.util.errors import DataError, ValueRefused

REACH = 4.0
"""Standard deviations after which the Gaussian is cut."""


def smoothed(values: Any, width: float) -> np.ndarray:
    """``Q``: a periodic row of numbers through a Gaussian of ``width`` samples; 0: as it is."""
    row = np.asarray(values, dtype=np.float64)
    if width == 0.0:
        return row.copy()
    reach = int(np.ceil(REACH * width))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    return np.convolve(np.take(row, np.arange(-reach, row.size + reach), mode="wrap"), weights / weights.sum(), "valid")


def taught(table: Any, missing: Any, lead: int = 4, gain: float = 0.7, width: float = 2.0) -> np.ndarray:
    """The next table of the last one and of the torque that was missing with it, both over one period.

    Raises:
        ValueRefused: a lead that is negative or longer than the table, a gain outside 0 to 2, a negative width.
        DataError: rows of different length, or values that are not finite.
    """
    u, d = np.asarray(table, dtype=np.float64), np.asarray(missing, dtype=np.float64)
    if u.ndim != 1 or u.shape != d.shape or not u.size:
        raise DataError(f"table of shape {u.shape}, missing of shape {d.shape} (taught): expected rows of one length")
    if not (np.isfinite(u).all() and np.isfinite(d).all()):
        raise DataError("table or missing (taught): has values that are not finite; the pass before has diverged")
    for name, value, least, most in (("lead", lead, 0, u.size), ("gain", gain, 0, 2), ("width", width, 0, u.size)):
        if not least <= value <= most:
            raise ValueRefused(f"{name} = {value} (taught): expected {least} to {most}")
    return smoothed(u + gain * np.roll(d, -lead), width)


def last_period(time: Any, values: Any, period_s: float, count: int) -> np.ndarray:
    """The last ``period_s`` of a recorded signal, at the ``count`` places of a table that started at time 0.

    Between samples the straight line. Where the record ends inside a period, the places behind its end are of the
    period before.

    Raises:
        DataError: time and values do not belong together, or the record is shorter than a period.
    """
    t, v = np.asarray(time, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if t.size < 2 or t.shape != v.shape:
        raise DataError(f"time of shape {t.shape}, values of shape {v.shape} (last_period): expected two samples each")
    first = t[-1] + (t[1] - t[0]) - period_s
    if first < -1e-9 * period_s:
        raise DataError(f"a record up to {t[-1]:.6g} s (last_period): expected a period of {period_s:.6g} s or more")
    places = np.arange(count) * (period_s / count)
    at: np.ndarray = np.interp(first + (places - first) % period_s, t, v)
    return at
