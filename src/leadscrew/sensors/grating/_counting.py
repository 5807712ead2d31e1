"""From two signals to a count: eight comparators, a code, the direction, a reversible counter. For arrays.

Sixteen counts a pitch by Long et al. (2014), section III, "subdividing, directional identifying, reversible counter":

1. Comparators ``w_i = [u cos(psi_i) - v sin(psi_i) >= 0]`` with ``psi_i = 2 pi (i + 1/2) / 16``, ``i = 0 ... 7``:
   ``w_i`` is 1 on the half turn that begins at ``psi_i``.
2. The eight bits are a Johnson code: one bit changes from each of the sixteen sectors to the next. With ``n`` ones the
   sector is ``n`` where ``w_0 = 1`` and ``16 - n`` (modulo 16) where it is 0.
3. The counter adds the change of sector, wrapped to -8 ... 7; its sign is the direction.

The count is ``floor(16 phi / (2 pi) + 1/2)`` with the unwrapped ``phi = atan2(u, v)``, as long as no sample is more
than 7 counts from the one before it (:func:`fastest`). Exactly between two counts the last bit of the arithmetic
decides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadscrew.sensors.grating._quadrature import TWO_PI
from leadscrew.util.errors import ValueRefused

SECTORS = 16
PSI = TWO_PI * (np.arange(SECTORS // 2) + 0.5) / SECTORS
"""Angles at which the comparators switch, rad."""
COMPARE_U, COMPARE_V = np.cos(PSI), np.sin(PSI)
"""The resistor network: weights of u and of v."""
SAFE_COUNTS = 7
"""A motion of 7 counts changes the sector by at most 7, the largest that the counter takes as forward."""

Whole = NDArray[np.int64]


def comparators(u: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
    """The eight bits, in a last axis added to the shape of ``u`` and ``v``."""
    u, v = np.asarray(u, dtype=np.float64)[..., None], np.asarray(v, dtype=np.float64)[..., None]
    return np.asarray(u * COMPARE_U - v * COMPARE_V >= 0.0)


def sectors(code: NDArray[np.bool_]) -> Whole:
    """The sector 0 ... 15 of each code of :func:`comparators`."""
    ones = code.sum(axis=-1)
    return np.asarray(np.where(code[..., 0], ones, (SECTORS - ones) % SECTORS), dtype=np.int64)


def counts(sector: ArrayLike, count: int = 0, before: int = 0) -> Whole:
    """The reversible counter's reading after each sector in turn; it starts at ``count`` in the sector ``before``."""
    sector = np.asarray(sector, dtype=np.int64)
    change = (np.diff(sector, prepend=before) + SECTORS // 2) % SECTORS - SECTORS // 2
    return np.asarray(count + np.cumsum(change), dtype=np.int64)


def counted(u: ArrayLike, v: ArrayLike) -> Whole:
    """The whole chain: the count after each pair of signals in turn, from 0 at ``phi`` = 0."""
    return counts(sectors(comparators(u, v)))


def analytic_counts(position_mm: ArrayLike, error_mm: ArrayLike = 0.0, pitch_mm: float = 0.01, n: int = 16) -> Whole:
    """The count worked out in one go: ``floor(n (x + error) / P + 1/2)``, the error that of an interpolator."""
    turns = np.asarray(position_mm, dtype=np.float64) / pitch_mm
    return np.asarray(np.floor(n * turns + n * np.asarray(error_mm) / pitch_mm + 0.5), dtype=np.int64)


def fastest(resolution_mm: float, period_s: float) -> float:
    """The speed in mm/s up to which a counter that samples every ``period_s`` loses no count: ``7 resolution/period``.

    4.4 mm/s for 0.625 um at 1 ms; 258.7 mm/s needs a sample every 16.9 us. For signals with errors or noise take off
    their share of a count.

    Raises:
        ValueRefused: a resolution or a period that is not above 0.
    """
    for name, value in (("resolution_mm", resolution_mm), ("period_s", period_s)):
        if not value > 0.0:
            raise ValueRefused(f"{name} = {value!r} (fastest): allowed range is (0, inf)")
    return SAFE_COUNTS * resolution_mm / period_s


def longest_period(resolution_mm: float, speed_mm_s: float) -> float:
    """The longest period in s at which a counter follows a speed: the inverse of :func:`fastest`.

    Raises:
        ValueRefused: a resolution or a speed that is not above 0.
    """
    for name, value in (("resolution_mm", resolution_mm), ("speed_mm_s", speed_mm_s)):
        if not value > 0.0:
            raise ValueRefused(f"{name} = {value!r} (longest_period): allowed range is (0, inf)")
    return SAFE_COUNTS * resolution_mm / speed_mm_s
