"""The fundamental of a record from its own lines, by nonlinear least squares over the frequency.

Model: ``y(t) = o + s (t - t_m) + sum_n A_n sin(2 pi n f_0 t + phi_n)``, n over the orders asked for. For a given
``f_0`` the rest is linear (:mod:`leadscrew.analysis.harmonics.lines`); ``f_0`` follows from Gauss-Newton steps on all
unknowns, started at the highest common peak of the record's Hann spectrum at ``n f_0`` within the range asked for.

Uncertainty: linearised, with the noise at each order as in :mod:`leadscrew.analysis.harmonics.lines`
(``cov = (J'J)^-1 (sum_n s_n^2 J_n'J_n) (J'J)^-1``, ``J_n`` the part of the Jacobian that belongs to order n):
stationary Gaussian residuals, level over the bins near each order; a constant fundamental over the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from leadscrew.analysis.harmonics.lines import Harmonics, least_squares
from leadscrew.analysis.harmonics.record import Array, Sampling, checked_level, folded, sampling, values
from leadscrew.kernel.errors import DataError, ValueRefused

ROUNDS = 50
EDGE = 0.02
"""How far beyond the range a fit may end that began inside it, in bins: noise moves it there too."""
SETTLED = 1e-10
"""Change of phase at the ends of the record, rad, below which the steps stop."""


@dataclass(frozen=True)
class Fundamental:
    """A fitted fundamental with its lines."""

    frequency: float
    """f_0, Hz."""
    sd: float
    """Standard deviation of f_0, Hz."""
    dof: float
    """Degrees of freedom of ``sd``: those of the order that tells most about f_0."""
    orders: tuple[float, ...]
    harmonics: Harmonics
    """The lines at ``orders`` times f_0."""

    def confidence(self, level: float = 0.95) -> tuple[float, float]:
        """Lower and upper end of the confidence interval of f_0, Hz."""
        from scipy.special import stdtrit

        wide = self.sd * float(stdtrit(self.dof, 0.5 + 0.5 * checked_level(level)))
        return self.frequency - wide, self.frequency + wide

    def as_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Everything for JSON."""
        low, high = self.confidence(level)
        return {
            "base_hz": self.frequency, "base_sd_hz": self.sd, "base_low_hz": low, "base_high_hz": high,
            "orders": list(self.orders), **self.harmonics.as_dict(level),
        }  # fmt: skip


def fitted_fundamental(
    t: Any,
    y: Any,
    base: float,
    orders: Sequence[float] = (1,),
    within: float = 0.05,
    trend: bool = True,
    noise: Literal["local", "white"] = "local",
    others: Sequence[float] = (),
) -> Fundamental:
    """The fundamental near ``base`` Hz (a share ``within`` to both sides) of one record, and its lines.

    Args:
        t: evenly spaced times, s.
        y: the record.
        base: where to look, Hz.
        orders: multiples of the fundamental that the model has; need not be whole.
        within: share of ``base`` to look to both sides, 0 to 0.5.
        trend: fit a slope beside the offset.
        noise: how the uncertainty is found.
        others: lines at known frequencies that are in the record too, Hz: left out of the result, but what they would
            leak does not bias it.

    Raises:
        DataError: times that are not even, a value that is not finite, or no fundamental inside the range: the best one
            lies at its end, or none of its lines stands above the noise.
        ValueRefused: an order whose line is not below Nyquist (says where it folds), or a value out of its range.
    """
    taken = t if isinstance(t, Sampling) else sampling(t, 8)
    seen = values(y, taken.samples)
    if seen.ndim != 1:
        raise ValueRefused(f"y has the shape {seen.shape}: a fundamental is fitted to one record at a time")
    if not 0.0 < base < np.inf:
        raise ValueRefused(f"base = {base!r}: expected a positive frequency in Hz")
    if not 0.0 < within <= 0.5:
        raise ValueRefused(f"within = {within!r}: allowed range is (0, 0.5] of the base")
    if noise not in ("local", "white"):
        raise ValueRefused(f"noise = {noise!r}: expected 'local' or 'white'")
    n = np.asarray(orders, dtype=np.float64)
    if n.ndim != 1 or not len(n) or not np.all(n > 0.0) or len(np.unique(n)) < len(n):
        raise ValueRefused(f"orders = {tuple(orders)!r}: expected positive orders, each once")
    highest = float(np.max(n)) * base * (1.0 + within)
    if highest >= taken.nyquist:
        raise ValueRefused(
            f"order {np.max(n):g} of {base:g} Hz within {100.0 * within:g} % reaches {highest:g} Hz, not below half "
            f"the sampling rate ({taken.nyquist:g} Hz): it folds to {folded(highest, taken.rate):g} Hz"
        )
    low, high = base * (1.0 - within), base * (1.0 + within)
    rest = seen - least_squares(taken, seen, others, trend, "none").at(taken.time) if len(others) else seen
    f0 = _start(taken, rest, n, low, high)
    f0 = _refined(taken, seen, n, np.asarray(others, dtype=np.float64), trend, f0)
    beside = EDGE / (taken.duration * float(np.max(n)))
    if not low - beside <= f0 <= high + beside:
        raise DataError(
            f"no fundamental within {100.0 * within:g} % of {base:g} Hz: the best fit leaves the range at "
            f"{low if f0 < low else high:g} Hz; widen the range or look at the spectrum"
        )
    lines = least_squares(taken, seen, [*(n * f0), *others], trend, noise)
    if not np.any(lines.first(len(n)).confidence(0.95)[0] > 0.0):
        raise DataError(
            f"no fundamental within {100.0 * within:g} % of {base:g} Hz: none of its lines stands above the noise"
        )
    sd, dof = _uncertainty(taken, lines, n, trend)
    return Fundamental(float(f0), sd, dof, tuple(float(k) for k in n), lines.first(len(n)))


def _start(taken: Sampling, seen: Array, orders: Array, low: float, high: float) -> float:
    """The base with the highest sum of the record's Hann power at all orders, looked up between bins of 1 / (8 T)."""
    from scipy.fft import next_fast_len, rfft

    n = taken.samples
    size = next_fast_len(8 * n, real=True)
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n)
    power = np.abs(rfft(hann * (seen - np.mean(seen)), size)) ** 2
    steps = max(2, int(np.ceil((high - low) * np.max(orders) * taken.duration * 8.0)) + 1)
    tried = np.linspace(low, high, steps)
    at = np.multiply.outer(tried, orders) * size * taken.step
    return float(tried[int(np.argmax(np.sum(np.interp(at, np.arange(len(power)), power), axis=1)))])


def _refined(taken: Sampling, y: Array, orders: Array, others: Array, trend: bool, f0: float) -> float:
    """Gauss-Newton steps on all unknowns from a start; the frequency."""
    time = _centred(taken)
    most = 0.25 / (taken.duration * float(np.max(orders)))
    n = np.concatenate([orders, np.zeros(len(others))])
    found: Array | None = None
    for _ in range(ROUNDS):
        columns = _columns(taken, time, np.concatenate([orders * f0, others]), trend)
        if found is None:
            found = _solved(columns, y)
        jacobian = np.hstack([columns, (_bent(time, columns, found, len(n)) @ n)[:, None]])
        step = _solved(jacobian, y - columns @ found)
        found = found + step[:-1]
        moved = float(np.clip(step[-1], -most, most))
        f0 += moved
        if 2.0 * np.pi * abs(moved) * float(np.max(orders)) * taken.duration < SETTLED:
            break
    return f0


def _solved(matrix: Array, right: Array) -> Array:
    """Least squares by scaled normal equations: exact enough, as each step starts from the residual of the last."""
    scale = np.sqrt(np.maximum(np.sum(matrix * matrix, axis=0), 1e-300))
    product = (matrix.T @ matrix) / np.multiply.outer(scale, scale)
    found = np.linalg.lstsq(product, (matrix.T @ right) / scale, rcond=1e-13)[0]
    return np.asarray(found / scale)


def _centred(taken: Sampling) -> Array:
    """Times from the middle of the record, which takes most of the correlation of f_0 with the phases away."""
    return np.asarray(taken.step * (np.arange(taken.samples) - 0.5 * (taken.samples - 1)), dtype=np.float64)


def _columns(taken: Sampling, time: Array, frequencies: Array, trend: bool) -> Array:
    """Sines, cosines, one and slope."""
    angle = 2.0 * np.pi * np.multiply.outer(time, frequencies)
    level = [np.ones((len(time), 1)), time[:, None] / (0.5 * taken.duration)]
    return np.hstack([np.sin(angle), np.cos(angle), *(level if trend else level[:1])])


def _bent(time: Array, columns: Array, found: Array, lines: int) -> Array:
    """What each line's frequency does to the model: derivatives for it, one column a line."""
    sines, cosines = columns[:, :lines], columns[:, lines : 2 * lines]
    return 2.0 * np.pi * time[:, None] * (cosines * found[:lines] - sines * found[lines : 2 * lines])


def _uncertainty(taken: Sampling, found: Harmonics, orders: Array, trend: bool) -> tuple[float, float]:
    lines = len(found.frequencies)
    time = _centred(taken)
    columns = _columns(taken, time, found.frequencies, trend)
    phase = found.phases + 2.0 * np.pi * found.frequencies * (taken.start - time[0])
    bent = _bent(
        time, columns, np.concatenate([found.amplitudes * np.cos(phase), found.amplitudes * np.sin(phase)]), lines
    )
    n = np.concatenate([orders, np.zeros(lines - len(orders))])
    jacobian = np.hstack([columns, (bent @ n)[:, None]])
    scale = np.sqrt(np.maximum(np.sum(jacobian * jacobian, axis=0), 1e-300))
    row = np.linalg.pinv((jacobian.T @ jacobian) / np.multiply.outer(scale, scale), rcond=1e-13)[-1]
    shares = np.empty(lines)
    for k in range(lines):
        part = bent[:, k] * (n[k] / scale[-1] * row[-1])
        part = part + columns[:, k] * (row[k] / scale[k]) + columns[:, lines + k] * (row[lines + k] / scale[lines + k])
        shares[k] = found.level[k] ** 2 * float(part @ part)
    return float(np.sqrt(np.sum(shares)) / scale[-1]), float(found.dof[int(np.argmax(shares))])
