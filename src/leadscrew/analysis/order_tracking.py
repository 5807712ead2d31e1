"""Orders of a turning spindle in a record: amplitudes that follow its speed.

An order ``o`` is a line at ``o`` times the spindle's frequency: runout is order 1, tooth passing of ``z`` teeth order
``z``. With the angle ``theta(t) = 2 pi integral n / 60 dt`` of a known or measured speed ``n`` in 1/min, two ways:

:func:`track_orders`
    least squares of ``cos(o theta)``, ``sin(o theta)``, offset and slope in windows of so many revolutions: amplitude
    and phase for each window, with the standard deviation from its residual (taken to be white).
:func:`vold_kalman`
    envelopes ``x_o`` that bend little: least ``sum abs(y - sum x_o exp(j o theta))^2 + r^2 sum abs(D^p x_o)^2`` (Vold
    and Leuridan, SAE 931288), ``D`` the difference from sample to sample, amplitude ``2 abs(x_o)``. ``r`` follows from
    the bandwidth ``b``: a change of amplitude at ``b / 2`` is halved in power where
    ``r^2 (2 sin(pi b / (2 f_s)))^(2 p) = sqrt(2) - 1``. Orders are solved together, so close and crossing ones part, as
    far as the bandwidth lets them.

An unknown speed: :func:`speed_trace` fits the fundamental window by window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadscrew.analysis.harmonics.lines import fitted_fundamental
from leadscrew.analysis.harmonics.record import Array, Sampling, folded, sampling, values
from leadscrew.util.errors import ValueRefused

TWO_PI = 2.0 * np.pi
REVOLUTIONS = 8.0
"""Length of a window unless given."""


@dataclass(frozen=True)
class Orders:
    """Amplitudes and phases of orders against time, shape ``(orders, times)``."""

    time: Array
    """Middle of each window, or every sample, s."""
    rpm: Array
    """Speed there, 1/min."""
    orders: tuple[float, ...]
    amplitudes: Array
    """Peak amplitudes in the record's unit."""
    phases: Array
    """rad, of ``cos(o theta + phase)`` with the angle theta counted from the first sample."""
    sd: Array
    """Standard deviation of the amplitudes; NaN where the method gives none."""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class SpeedTrace:
    """An estimated speed against time."""

    time: Array
    rpm: Array
    sd: Array
    """Standard deviation of each window's speed, 1/min."""

    def at(self, t: Any) -> Array:
        """Speed at times in s, linear between the windows' middles, constant beyond."""
        return np.asarray(np.interp(np.asarray(t, dtype=np.float64), self.time, self.rpm))


def angle(taken: Sampling, rpm: Any) -> Array:
    """Angle of the spindle at each sample, rad from the first one, by the trapezoidal rule.

    Raises:
        ValueRefused: a speed that is not positive, or a trace that does not fit the record.
    """
    trace = np.asarray(rpm, dtype=np.float64)
    if trace.ndim == 0:
        trace = np.full(taken.samples, float(trace))
    if trace.shape != (taken.samples,):
        raise ValueRefused(f"rpm has the shape {trace.shape}: expected one speed, or one a sample ({taken.samples})")
    if not np.all((trace > 0.0) & np.isfinite(trace)):
        raise ValueRefused(f"rpm: {trace[~((trace > 0.0) & np.isfinite(trace))][0]:g} 1/min; expected positive speeds")
    turned = np.cumsum(0.5 * (trace[1:] + trace[:-1])) * taken.step * TWO_PI / 60.0
    return np.concatenate([[0.0], turned])


def track_orders(
    t: Any, y: Any, rpm: Any, orders: Sequence[float], revolutions: float = REVOLUTIONS, overlap: float = 0.5
) -> Orders:
    """Orders of one record by least squares in windows of ``revolutions`` turns, each overlapping the last.

    ``rpm``: one speed, or one a sample.

    Raises:
        DataError: times that are not even, or a value that is not finite.
        ValueRefused: an order above Nyquist (says where it folds), orders too close for the window, a record shorter
            than one window, or a value out of its range.
    """
    taken, seen, wanted, theta = _given(t, y, rpm, orders)
    if not 0.0 <= overlap < 1.0:
        raise ValueRefused(f"overlap = {overlap!r}: allowed range is [0, 1) of a window")
    apart = min([*np.diff(np.sort(wanted)), float(np.min(wanted))])
    if not revolutions * apart >= 1.0 - 1e-9:
        raise ValueRefused(
            f"revolutions = {revolutions!r}: orders {apart:g} apart (from each other or from zero) take windows of at "
            f"least {1.0 / apart:g} revolutions (Rayleigh)"
        )
    if theta[-1] < TWO_PI * revolutions:
        raise ValueRefused(
            f"revolutions = {revolutions!r}: the record holds {theta[-1] / TWO_PI:.3g} revolutions; expected a window "
            "that fits"
        )
    starts = np.arange(0.0, theta[-1] - TWO_PI * revolutions + 1e-9, TWO_PI * revolutions * (1.0 - overlap))
    rows = []
    for first in starts:
        begin, end = np.searchsorted(theta, [first - 1e-9, first + TWO_PI * revolutions - 1e-9])
        rows.append(_window(taken, seen[begin:end], theta[begin:end], wanted, begin))
    found = [np.array(column) for column in zip(*rows, strict=True)]
    return Orders(found[0], found[1], tuple(map(float, wanted)), found[2].T, found[3].T, found[4].T)


def _window(
    taken: Sampling, y: Array, theta: Array, orders: Array, begin: int
) -> tuple[float, float, Array, Array, Array]:
    n, lines = len(y), len(orders)
    if n < 2 * lines + 3:
        raise ValueRefused(f"a window of {n} samples does not tell {lines} orders; take more revolutions")
    turned = np.multiply.outer(theta, orders)
    place = np.linspace(-1.0, 1.0, n)
    design = np.hstack([np.cos(turned), np.sin(turned), np.ones((n, 1)), place[:, None]])
    q, r = np.linalg.qr(design)
    inverse = np.linalg.inv(r)
    found = inverse @ (q.T @ y)
    left = y - design @ found
    noise = np.sqrt(np.sum(left**2) / (n - design.shape[1]))
    spread = np.sum(inverse**2, axis=1)
    a, b = found[:lines], found[lines : 2 * lines]
    amplitude = np.hypot(a, b)
    safe = np.where(amplitude > 0.0, amplitude, 1.0)
    sd = noise * np.sqrt((a**2 * spread[:lines] + b**2 * spread[lines : 2 * lines]) / safe**2)
    middle = taken.start + taken.step * (begin + 0.5 * (n - 1))
    rpm = 60.0 * (theta[-1] - theta[0]) / (TWO_PI * taken.step * (n - 1))
    return middle, rpm, amplitude, np.arctan2(-b, a), sd


def vold_kalman(t: Any, y: Any, rpm: Any, orders: Sequence[float], bandwidth: float = 0.5, poles: int = 2) -> Orders:
    """Orders of one record at every sample by the Vold-Kalman filter of the second generation.

    Args:
        t: evenly spaced times, s.
        y: the record.
        rpm: one speed, or one a sample.
        orders: which.
        bandwidth: Hz, both sides of an order together; smaller is smoother.
        poles: order of the difference, 1 or 2.

    Raises:
        DataError: times that are not even, or a value that is not finite.
        ValueRefused: an order above Nyquist (says where it folds), or a value out of its range.
    """
    from scipy.linalg import solveh_banded

    taken, seen, wanted, theta = _given(t, y, rpm, orders)
    if poles not in (1, 2):
        raise ValueRefused(f"poles = {poles!r}: expected 1 or 2")
    if not 2.0 / taken.duration <= bandwidth < taken.nyquist:
        raise ValueRefused(
            f"bandwidth = {bandwidth!r}: allowed range is [{2.0 / taken.duration:g}, {taken.nyquist:g}) Hz, from two "
            "over the record's length to half the sampling rate"
        )
    weight = (np.sqrt(2.0) - 1.0) / (2.0 * np.sin(0.5 * np.pi * bandwidth / taken.rate)) ** (2 * poles)
    n, lines = taken.samples, len(wanted)
    carrier = np.exp(1j * np.multiply.outer(wanted, theta))
    # Unknowns sample by sample, orders side by side: a band of poles * lines beside the diagonal.
    band: NDArray[np.complex128] = np.zeros((poles * lines + 1, n * lines), dtype=np.complex128)
    stencil = np.array([1.0, -1.0]) if poles == 1 else np.array([1.0, -2.0, 1.0])
    for off in range(poles + 1):
        products = stencil[: poles + 1 - off] * stencil[off:]
        count = np.zeros(n - off)
        for k, product in enumerate(products):
            count[k : n - off - (poles - off) + k] += product
        band[off * lines, : (n - off) * lines] += np.repeat(weight * count, lines)
    for one in range(lines):
        for other in range(one, lines):
            band[other - one, one::lines] += np.conj(carrier[other]) * carrier[one]
    right = (np.conj(carrier) * (seen - np.mean(seen))).T.reshape(-1)
    found = 2.0 * solveh_banded(band, right, lower=True, check_finite=False).reshape(n, lines).T
    speed = np.gradient(theta, taken.step) * 60.0 / TWO_PI
    return Orders(
        taken.time, speed, tuple(map(float, wanted)), np.abs(found), np.angle(found), np.full(found.shape, np.nan)
    )


def speed_trace(
    t: Any, y: Any, rpm: float, orders: Sequence[float], within: float = 0.02, window: float = 2.0
) -> SpeedTrace:
    """The spindle's speed from its own orders: a fitted fundamental in windows of ``window`` s, half overlapped.

    ``rpm`` is the nominal speed, looked for a share ``within`` to both sides; it should hold still within a window.

    Raises:
        DataError: no fundamental within the range in some window; names it.
        ValueRefused: a window that does not fit the record, an order above Nyquist, or a value out of its range.
    """
    taken = t if isinstance(t, Sampling) else sampling(t, 8)
    seen = values(y, taken.samples)
    size = round(window * taken.rate) if 0.0 < window < np.inf else 0
    if not 8 <= size <= taken.samples:
        raise ValueRefused(
            f"window = {window!r}: allowed range is [{8 * taken.step:g}, {taken.duration:g}] s, 8 samples to the record"
        )
    rows = []
    for first in range(0, taken.samples - size + 1, max(1, size // 2)):
        part = Sampling(size, taken.start + first * taken.step, taken.step)
        found = fitted_fundamental(part, seen[first : first + size], rpm / 60.0, orders, within)
        rows.append((part.start + 0.5 * taken.step * (size - 1), 60.0 * found.frequency, 60.0 * found.sd))
    middle, speed, sd = np.array(rows).T
    return SpeedTrace(middle, speed, sd)


def _given(t: Any, y: Any, rpm: Any, orders: Sequence[float]) -> tuple[Sampling, Array, Array, Array]:
    taken = t if isinstance(t, Sampling) else sampling(t, 8)
    seen = values(y, taken.samples)
    if seen.ndim != 1:
        raise ValueRefused(f"y has the shape {seen.shape}: orders are tracked in one record at a time")
    wanted = np.asarray(orders, dtype=np.float64)
    if wanted.ndim != 1 or not len(wanted) or not np.all(wanted > 0.0) or len(np.unique(wanted)) < len(wanted):
        raise ValueRefused(f"orders = {tuple(orders)!r}: expected positive orders, each once")
    theta = angle(taken, rpm)
    fastest = float(np.max(np.diff(theta))) / (TWO_PI * taken.step)
    highest = float(np.max(wanted)) * fastest
    if highest >= taken.nyquist:
        raise ValueRefused(
            f"order {np.max(wanted):g} at {60.0 * fastest:g} 1/min is {highest:g} Hz, not below half the sampling rate "
            f"({taken.nyquist:g} Hz): it folds to {folded(highest, taken.rate):g} Hz"
        )
    return taken, seen, wanted, theta
