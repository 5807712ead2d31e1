"""Amplitudes and phases of lines at known frequencies, by linear least squares.

Model, for each record: ``y(t) = o + s (t - t_m) + sum_k a_k sin(2 pi f_k t) + b_k cos(2 pi f_k t)``, with ``t_m`` the
middle of the record, and ``A_k = hypot(a_k, b_k)``, ``phi_k = atan2(b_k, a_k)``: a line is ``A sin(2 pi f t + phi)``.
Unlike an FFT it needs no whole number of periods, and lines that are in the model do not leak into each other.

Noise: ``local`` takes the level at each line from the residual's periodogram in the 16 free bins nearest to the line,
so it holds for coloured residuals whose spectrum is about level over those bins, and has in it what strong lines that
are not in the model leak there; ``white`` takes the residual's variance over all samples, right only where the residual
is white; ``none`` computes no uncertainty. Both take the residual to be stationary and Gaussian, and the frequencies to
be right.

The fundamental of a record from its own lines, by nonlinear least squares over the frequency.

Model: ``y(t) = o + s (t - t_m) + sum_n A_n sin(2 pi n f_0 t + phi_n)``, n over the orders asked for. For a given
``f_0`` the rest is linear (as above); ``f_0`` follows from Gauss-Newton steps on all unknowns, started at the highest
common peak of the record's Hann spectrum at ``n f_0`` within the range asked for.

Uncertainty: linearised, with the noise at each order as above
(``cov = (J'J)^-1 (sum_n s_n^2 J_n'J_n) (J'J)^-1``, ``J_n`` the part of the Jacobian that belongs to order n):
stationary Gaussian residuals, level over the bins near each order; a constant fundamental over the record.

Amplitudes from an FFT, for comparison with least squares: window, and how a line is read.

With a window ``w`` of ``n`` samples an amplitude is ``2 abs(sum w y exp(-j 2 pi f t)) / sum w``, right where no other
line leaks to ``f``. It is read at the ``nearest`` bin (a line between two bins loses up to 36 % with a rectangular
window, 15 % with Hann, 0.1 % with flat-top), at the line's ``exact`` frequency, or ``interpolated`` from the two
highest bins near the line as if it stood alone (rectangular and Hann; the frequency need not be known).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from leadscrew.analysis.harmonics.record import (
    Array,
    Sampling,
    checked_frequencies,
    checked_level,
    folded,
    sampling,
    short_notes,
    values,
)
from leadscrew.util.errors import DataError, ValueRefused

Noise = Literal["local", "white", "none"]

BINS = 16
"""Free bins around a line that tell the local noise."""
CLEAR = 1.25
"""Bins beside a modelled line, or zero, that tell nothing: the fit took their energy."""
NORMAL_FROM = 30.0
"""Amplitude over its standard deviation from which its distribution counts as normal; Rice below."""
WORST_CONDITION = 1e7
SAFE_CONDITION = 1e4
"""Below this a factorisation by Cholesky, done twice, is as exact as Householder's."""
_BY_LINE = ("frequencies", "amplitudes", "phases", "sd", "dof", "level")


@dataclass(frozen=True)
class Harmonics:
    """Lines of one record (arrays of shape ``(lines,)``) or of several (``(..., lines)``), in the record's unit."""

    frequencies: Array
    """Hz, in the order asked for."""
    amplitudes: Array
    """Peak amplitudes, not negative."""
    phases: Array
    """rad in (-pi, pi], of ``sin(2 pi f t + phase)`` with the record's own ``t``."""
    sd: Array
    """Standard deviation of each amplitude where the line stands above the noise; NaN without noise."""
    dof: Array
    """Degrees of freedom of ``sd``, for each line."""
    offset: Array
    """Value at the middle of the record."""
    trend: Array
    """Slope, unit/s; 0 where none was fitted."""
    residual_rms: Array
    """What the lines, offset and trend leave."""
    level: Array
    """Standard deviation of white noise with the residual's spectrum at each line."""
    noise: Noise
    taken: Sampling
    notes: tuple[str, ...] = ()
    """Sentences about lines that this record separates badly."""

    def confidence(self, level: float = 0.95) -> tuple[Array, Array]:
        """Lower and upper end of each amplitude's confidence interval.

        From the Rice distribution of an amplitude whose two quadratures have standard deviation ``sd``, widened to
        Student's t for the degrees of freedom of ``sd``; normal from 30 ``sd`` on. The lower end is 0 for an amplitude
        that noise alone may give, the upper end at least one ``sd``: there the interval is wider than ``level`` asks.
        """
        from scipy.special import chndtrinc, ndtri, stdtrit

        half = 0.5 + 0.5 * checked_level(level)
        wide = self.sd * stdtrit(self.dof, half)
        shown = np.maximum(wide / ndtri(half), 1e-300)
        ratio = np.minimum(self.amplitudes / shown, NORMAL_FROM)
        seen = -np.expm1(-0.5 * ratio**2)
        # Where noise alone gives more than this, no amplitude is small enough for chndtrinc to find.
        low = np.where(
            seen > half, np.sqrt(np.maximum(chndtrinc(np.where(seen > half, ratio**2, 9.0), 2.0, half), 0.0)), 0.0
        )
        high = np.where(seen > 1.0 - half, chndtrinc(np.where(seen > 1.0 - half, ratio**2, 9.0), 2.0, 1.0 - half), 0.0)
        rice = shown * low, shown * np.maximum(np.sqrt(high), 1.0)
        normal = self.amplitudes - wide, self.amplitudes + wide
        ends = [np.where(ratio < NORMAL_FROM, r, n) + 0.0 * self.sd for r, n in zip(rice, normal, strict=True)]
        return ends[0], ends[1]

    def phase_confidence(self, level: float = 0.95) -> Array:
        """Half width of each phase's confidence interval, rad; pi where the amplitude does not tell a phase."""
        from scipy.special import stdtrit

        wide = self.sd * stdtrit(self.dof, 0.5 + 0.5 * checked_level(level))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(self.amplitudes > 0.0, wide / self.amplitudes, 1.0)
        return np.where(share < 1.0, np.arcsin(np.minimum(share, 1.0)), np.pi) + 0.0 * self.sd

    def first(self, count: int) -> Harmonics:
        """The first lines alone, as they were fitted together with all."""
        kept = {name: getattr(self, name)[..., :count] for name in _BY_LINE}
        return replace(self, **kept)

    def at(self, t: Any, trend: bool = True) -> Array:
        """The model's values at times ``t`` in s: lines alone without ``trend``."""
        times = np.asarray(t, dtype=np.float64)
        angle = 2.0 * np.pi * np.multiply.outer(self.frequencies, times)
        found = np.asarray(
            (self.amplitudes * np.cos(self.phases)) @ np.sin(angle)
            + (self.amplitudes * np.sin(self.phases)) @ np.cos(angle)
        )
        if trend:
            found = found + self.offset[..., None] + self.trend[..., None] * (times - _middle(self.taken))
        return found

    def as_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Everything for JSON."""
        low, high = self.confidence(level)
        return {
            "frequency_hz": self.frequencies.tolist(), "amplitude": self.amplitudes.tolist(),
            "phase_rad": self.phases.tolist(), "sd": self.sd.tolist(), "confidence_level": level,
            "amplitude_low": low.tolist(), "amplitude_high": high.tolist(),
            "phase_half_width_rad": self.phase_confidence(level).tolist(), "offset": self.offset.tolist(),
            "trend_per_s": self.trend.tolist(), "residual_rms": self.residual_rms.tolist(), "noise": self.noise,
            "samples": self.taken.samples, "rate_hz": self.taken.rate, "notes": list(self.notes),
        }  # fmt: skip


class LineFit:
    """Least squares at fixed frequencies and times, factorised once: :meth:`fit` is one product of matrices.

    Args:
        t: evenly spaced times, s (or a :class:`~leadscrew.analysis.harmonics.record.Sampling`).
        frequencies: of the lines, Hz; below half the sampling rate, each once.
        trend: fit a slope beside the offset.

    Raises:
        DataError: times that are not evenly spaced.
        ValueRefused: a line that is not below Nyquist (says where it folds), given twice or not positive; fewer samples
            than unknowns; lines that this record cannot separate at all.
    """

    def __init__(self, t: Any, frequencies: Sequence[float] | Array, trend: bool = True) -> None:
        self.taken = t if isinstance(t, Sampling) else sampling(t)
        self.frequencies = checked_frequencies(frequencies, self.taken)
        self.trend = bool(trend)
        lines = len(self.frequencies)
        unknowns = 2 * lines + 1 + self.trend
        if self.taken.samples < unknowns + 1:
            raise ValueRefused(
                f"{self.taken.samples} samples do not tell {unknowns} unknowns ({lines} lines, offset"
                f"{', trend' if trend else ''}); expected at least {unknowns + 1}"
            )
        self.notes = tuple(short_notes(self.frequencies, self.taken))
        time = self.taken.time
        angle = 2.0 * np.pi * np.multiply.outer(time, self.frequencies)
        centred = (time - _middle(self.taken)) / (0.5 * self.taken.duration)
        parts = [np.sin(angle), np.cos(angle), np.ones((len(time), 1))]
        design = np.hstack([*parts, centred[:, None]] if self.trend else parts)
        self._q, r = _orthogonal(design)
        if not np.linalg.cond(r) < WORST_CONDITION:
            raise ValueRefused(
                f"a record of {self.taken.duration:g} s cannot separate the lines at "
                f"{', '.join(f'{f:g}' for f in self.frequencies)} Hz from each other or from the trend"
            )
        self._inverse = np.linalg.inv(r)
        whole = self._inverse @ self._inverse.T
        at = np.arange(lines)
        self._spread = np.stack([whole[at, at], whole[at, at + lines], whole[at + lines, at + lines]])

    def fit(self, y: Any, noise: Noise = "local") -> Harmonics:
        """The lines of one record ``(n,)`` or of several ``(..., n)``.

        Raises:
            ValueRefused: a shape that does not fit the times, or an unknown noise.
            DataError: a value that is not finite.
        """
        if noise not in ("local", "white", "none"):
            raise ValueRefused(f"noise = {noise!r}: expected 'local', 'white' or 'none'")
        seen = values(y, self.taken.samples)
        rotated = seen @ self._q
        found = rotated @ self._inverse.T
        lines = len(self.frequencies)
        a, b = found[..., :lines], found[..., lines : 2 * lines]
        residual = seen - rotated @ self._q.T
        rms = np.sqrt(np.mean(residual**2, axis=-1))
        level, dof, notes = self._level(residual, rms, noise)
        amplitude = np.hypot(a, b)
        safe = np.where(amplitude > 0.0, amplitude, 1.0)
        across = (a**2 * self._spread[0] + 2.0 * a * b * self._spread[1] + b**2 * self._spread[2]) / safe**2
        slope = found[..., -1] / (0.5 * self.taken.duration) if self.trend else np.zeros(found.shape[:-1])
        return Harmonics(
            self.frequencies, amplitude, np.arctan2(b, a), level * np.sqrt(np.maximum(across, 0.0)), dof,
            found[..., 2 * lines], slope, rms, level, noise, self.taken, self.notes + notes,
        )  # fmt: skip

    def _level(self, residual: Array, rms: Array, noise: Noise) -> tuple[Array, Array, tuple[str, ...]]:
        """Standard deviation of the white noise that has the residual's spectrum at each line."""
        from scipy.fft import rfft

        lines, n = len(self.frequencies), self.taken.samples
        if noise == "none":
            return np.full((*rms.shape, lines), np.nan), np.full(lines, np.nan), ()
        if noise == "local":
            places = [self._free(f) for f in self.frequencies]
            if min(map(len, places)) >= BINS // 4:
                power = np.abs(rfft(residual, axis=-1)) ** 2 / n
                found = np.stack([np.mean(power[..., p], axis=-1) for p in places], axis=-1)
                return np.sqrt(found), np.array([2.0 * len(p) for p in places]), ()
        free = n - 2 * lines - 1 - self.trend
        white = np.repeat((rms * np.sqrt(n / free))[..., None], lines, axis=-1)
        short = () if noise == "white" else (
            f"a record of {self.taken.duration:g} s has too few bins beside its lines to tell the noise there: the "
            "residual is taken to be white",
        )  # fmt: skip
        return white, np.full(lines, float(free)), short

    def _free(self, frequency: float) -> np.ndarray:
        """The free bins nearest to a frequency."""
        duration, n = self.taken.duration, self.taken.samples
        bins = np.arange(1, (n - 1) // 2 + 1)
        centre = frequency * duration
        low = max(0, int(centre) - 8 * BINS)
        bins = bins[low : int(centre) + 8 * BINS]
        taken = np.concatenate([[0.0], self.frequencies * duration])
        bins = bins[np.min(np.abs(bins[:, None] - taken), axis=1) > CLEAR]
        return bins[np.argsort(np.abs(bins - centre), kind="stable")[:BINS]]


def least_squares(
    t: Any, y: Any, frequencies: Sequence[float] | Array, trend: bool = True, noise: Noise = "local"
) -> Harmonics:
    """Amplitudes and phases of lines in a record ``y`` of shape ``(n,)``, or in many of shape ``(..., n)``.

    ``t`` are evenly spaced times in s, ``frequencies`` in Hz. The factorisation of a combination of times and
    frequencies is kept for the next call. ``noise`` says how the uncertainty is found (see the module).

    Raises:
        DataError: times that are not evenly spaced, or a value that is not finite.
        ValueRefused: what :class:`LineFit` refuses, or a ``y`` that does not fit ``t``.
    """
    taken = t if isinstance(t, Sampling) else sampling(t)
    return _factorised(taken, tuple(np.atleast_1d(frequencies).tolist()), bool(trend)).fit(y, noise)


def _orthogonal(design: Array) -> tuple[Array, Array]:
    """``q, r`` with ``q`` orthonormal and ``design = q r``; rows far outnumber columns.

    By Cholesky of ``design' design``, and once more of the first ``q``: orthogonal to rounding, in products of matrices
    alone. Y. Yamamoto, Y. Nakatsukasa, Y. Yanagisawa, T. Fukaya, *Roundoff error analysis of the CholeskyQR2
    algorithm*, Electronic Transactions on Numerical Analysis 44 (2015) 306. Lines hard to separate: Householder.
    """
    try:
        first = np.linalg.cholesky(design.T @ design).T
        if np.linalg.cond(first) < SAFE_CONDITION:
            q = design @ np.linalg.inv(first)
            second = np.linalg.cholesky(q.T @ q).T
            return q @ np.linalg.inv(second), second @ first
    except np.linalg.LinAlgError:
        pass
    found = np.linalg.qr(design)
    return found.Q, found.R


@lru_cache(maxsize=16)
def _factorised(taken: Sampling, frequencies: tuple[float, ...], trend: bool) -> LineFit:
    return LineFit(taken, frequencies, trend)


def _middle(taken: Sampling) -> float:
    return taken.start + 0.5 * taken.step * (taken.samples - 1)


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


Window = Literal["rectangular", "hann", "flattop"]
Reading = Literal["nearest", "exact", "interpolated"]

WINDOWS = {"rectangular": "boxcar", "hann": "hann", "flattop": "flattop"}
"""Ours, and SciPy's name of it; periodic, as an FFT wants them."""
HALF_LOBE = {"rectangular": 1.0, "hann": 2.0, "flattop": 5.0}
"""Bins from a line to the first zero of its main lobe."""
COHERENT = 1e-3
"""Periods in the record may differ from a whole number by so many before a line counts as not coherent."""


@dataclass(frozen=True)
class Spectrum:
    """Amplitude spectrum of one record ``(bins,)`` or of several ``(..., bins)``."""

    frequencies: Array
    """Of the bins, Hz."""
    amplitudes: Array
    """Peak amplitude that a line on the bin would have; the record's unit."""
    window: Window
    taken: Sampling
    values: Array
    """The record, its mean taken out."""

    def amplitude(self, frequencies: Sequence[float] | Array, reading: Reading = "nearest") -> Array:
        """Amplitudes of lines at ``frequencies`` in Hz, along the last axis.

        Raises:
            ValueRefused: a line that is not below Nyquist (says where it folds), an unknown reading, or interpolation
                under a flat-top window.
        """
        wanted = checked_frequencies(frequencies, self.taken)
        if reading not in ("nearest", "exact", "interpolated"):
            raise ValueRefused(f"reading = {reading!r}: expected 'nearest', 'exact' or 'interpolated'")
        if reading == "exact":
            w = _window(self.window, self.taken.samples)
            turned = np.exp(-2j * np.pi * np.multiply.outer(self.taken.time, wanted))
            return 2.0 * np.abs((w * self.values) @ turned) / np.sum(w)
        nearest = np.clip(np.rint(wanted * self.taken.duration).astype(int), 1, self.amplitudes.shape[-1] - 2)
        if reading == "nearest":
            return np.asarray(self.amplitudes[..., nearest])
        if self.window == "flattop":
            raise ValueRefused("reading = 'interpolated': for the windows rectangular and hann; flattop needs none")
        return self._interpolated(nearest)[1]

    def peak(self, bin_: int) -> tuple[float, float]:
        """Frequency in Hz and amplitude of a lone line whose highest bin this is (one record; rectangular or Hann)."""
        off, size = self._interpolated(np.array([bin_]))
        return (bin_ + float(off[0])) / self.taken.duration, float(size[0])

    def _interpolated(self, highest: np.ndarray) -> tuple[Array, Array]:
        """Bins from the highest one to the line, and the line's amplitude, from the ratio of the two highest bins."""
        left, at, right = (self.amplitudes[..., highest + k] for k in (-1, 0, 1))
        ratio = np.maximum(left, right) / np.maximum(at, 1e-300)
        side = np.where(right >= left, 1.0, -1.0)
        if self.window == "rectangular":
            off = ratio / (1.0 + ratio)
            return np.asarray(side * off), np.asarray(at / np.sinc(off))
        off = np.clip((2.0 * ratio - 1.0) / (ratio + 1.0), -1.0 + 1e-9, 1.0 - 1e-9)
        return np.asarray(side * off), np.asarray(at * (1.0 - off**2) / np.sinc(off))

    def notes(self, frequencies: Sequence[float] | Array) -> list[str]:
        """What is wrong with reading these lines off this spectrum, a sentence each."""
        wanted = np.sort(checked_frequencies(frequencies, self.taken))
        periods = wanted * self.taken.duration
        off = [f for f, p in zip(wanted, periods, strict=True) if abs(p - np.rint(p)) > COHERENT]
        found = []
        if off:
            said = ", ".join(f"{f:g} ({f * self.taken.duration:.2f} periods)" for f in off)
            found.append(
                f"not coherent: a record of {self.taken.duration:g} s holds no whole number of periods of {said} Hz; "
                + ("they leak into each other; least squares does not" if self.window == "rectangular"
                   else f"with {self.window} the nearest bin reads them low" if self.window == "hann"
                   else "flat-top reads them nearly right where no other line is near")
            )  # fmt: skip
        lobe = HALF_LOBE[self.window] / self.taken.duration
        need = lobe if self.window == "rectangular" else 2.0 * lobe
        for low, high in pairwise(wanted):
            if high - low < need * (1.0 - 1e-6):
                found.append(
                    f"{low:g} and {high:g} Hz are {(high - low) * self.taken.duration:.2g} bins apart: with the window "
                    f"{self.window} a record of {need * self.taken.duration / (high - low):.3g} s separates them"
                )
        return found


def spectrum(t: Any, y: Any, window: Window = "rectangular") -> Spectrum:
    """The amplitude spectrum of a record ``y`` of shape ``(n,)``, or of many of shape ``(..., n)``.

    ``t`` are evenly spaced times in s; windows are SciPy's, periodic.

    Raises:
        DataError: times that are not even, or a value that is not finite.
        ValueRefused: an unknown window, or a ``y`` that does not fit ``t``.
    """
    from scipy.fft import rfft

    if window not in WINDOWS:
        raise ValueRefused(f"window = {window!r}: expected one of {', '.join(WINDOWS)}")
    taken = t if isinstance(t, Sampling) else sampling(t)
    seen = values(y, taken.samples)
    seen = seen - np.mean(seen, axis=-1, keepdims=True)
    w = _window(window, taken.samples)
    found = 2.0 * np.abs(rfft(w * seen, axis=-1)) / np.sum(w)
    bins = np.arange(found.shape[-1]) / taken.duration
    return Spectrum(bins, found, window, taken, seen)


def _window(name: str, samples: int) -> Array:
    from scipy.signal.windows import get_window

    return np.asarray(get_window(WINDOWS[name], samples, fftbins=True), dtype=np.float64)
