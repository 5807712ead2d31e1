"""What the observers and learners of a tangential axis share: beliefs, and where the axis was when the cut was seen.

    x(k+1) = x(k) + (1 - e^(-T / axis_lag_s)) (d(k) - x(k))            the axis, as believed
    c(k)   = y(k) - g x(k - m)                                         what the offset does not explain, deg

``y`` is the reading of the cut line's deviation, ``m`` its delay in samples, ``g`` the believed gain from offset to
deviation. ``x`` follows the offset that was sent, limits counted, so nothing winds up.

``RING`` samples are remembered. A ring is written at ``at``, and :func:`back` reads what was written some samples ago.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused

RING = 32
"""Samples that are remembered."""
TINY = 1e-30
"""Below this a filter's state is 0."""
TWICE = math.pi / 90.0
"""Twice an angle in deg, in radians."""
MOST_DEG = 15.0
"""Largest offset of the study's axis."""

PlantGain = Annotated[float, Gt(0), Le(10), Doc("believed gain from offset to deviation, g")]
AxisLag = Annotated[float, Unit("s"), Gt(0), Le(1), Doc("believed lag of the tangential axis")]
SensorDelay = Annotated[float, Unit("s"), Ge(0), Le(1), Doc("believed delay of the reading")]
MaxOffset = Annotated[float, Unit("deg"), Gt(0), Le(90), Doc("largest offset, either way")]
ObserverGain = Annotated[float, Ge(0), Le(2), Doc("share of what was found that is taken off")]
FilterS = Annotated[float, Unit("s"), Gt(0), Le(10), Doc("time constant of the observer's filter")]
ReturnS = Annotated[float, Unit("s"), Gt(0), Le(10), Doc("time in which learning is back after the cut was not seen")]
Preview = Annotated[int, Ge(0), Le(20), Doc("samples that the command looks ahead: that of the reference")]


def samples(delay_s: float, dt: float, reach: int, maker: str) -> int:
    """A delay in whole samples; with ``reach`` more it has to fit into the ring.

    Raises:
        ValueRefused: it does not.
    """
    late = round(delay_s / dt)
    if late + reach >= RING:
        raise ValueRefused(f"delay_s = {delay_s!r} ({maker}): {late} samples, expected {RING - 1 - reach} or fewer")
    return late


def checked_prior(params: Any, count: int, maker: str) -> tuple[np.ndarray, np.ndarray]:
    """What ``count`` weights start from, and its covariance.

    Raises:
        ValueRefused: a prior of the wrong shape, or one whose covariance is not symmetric.
    """
    prior, covariance = np.array(params.prior, dtype=float), np.array(params.prior_covariance, dtype=float)
    if prior.shape != (count,) or covariance.shape != (count, count):
        raise ValueRefused(
            f"prior of shape {prior.shape}, prior_covariance of shape {covariance.shape} ({maker}): expected {count} "
            f"and {count} x {count}"
        )
    if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=1e-12):
        raise ValueRefused(f"prior_covariance ({maker}): expected a symmetric matrix")
    return prior, 0.5 * (covariance + covariance.T)


def start_from_prior(p, s):
    """Weights and covariance of the prior, in place."""
    for i in range(s.weights.shape[0]):
        s.weights[i] = p.prior[i]
        for j in range(s.weights.shape[0]):
            s.covariance[i, j] = p.prior_covariance[i, j]
    return 0.0


def acting(p, s, wait, sight):
    """The share in which it learns: ``sight``; 0 while it waits, and where the last offset was at its limit."""
    return (1.0 if wait == 0 else 0.0) * sight * (1.0 if abs(s.sent) < p.max_offset else 0.0)


def back(ring, at, late):
    """What was written ``late`` samples before the place ``at``."""
    k = at - late
    return ring[k + RING if k < 0 else k]


def next_place(at):
    """The place after ``at``."""
    return at + 1 if at + 1 < RING else 0


def trusted(sight, seen, returns):
    """Share of a reading that is taken: 0 while the cut is not seen, then up to 1 by ``returns`` a sample."""
    return min(sight + returns, 1.0) if seen > 0.5 else 0.0


def quiet(x):
    """A number, or 0 where it would soon be denormal."""
    return x if abs(x) > TINY else 0.0


def within(d, max_offset):
    """An offset within the limits."""
    return min(max(d, -max_offset), max_offset)
