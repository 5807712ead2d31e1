"""Amplitudes and phases of lines at known frequencies, by linear least squares.

Model, for each record: ``y(t) = o + s (t - t_m) + sum_k a_k sin(2 pi f_k t) + b_k cos(2 pi f_k t)``, with ``t_m`` the
middle of the record, and ``A_k = hypot(a_k, b_k)``, ``phi_k = atan2(b_k, a_k)``: a line is ``A sin(2 pi f t + phi)``.
Unlike an FFT it needs no whole number of periods, and lines that are in the model do not leak into each other.

Noise: ``local`` takes the level at each line from the residual's periodogram in the 16 free bins nearest to the line,
so it holds for coloured residuals whose spectrum is about level over those bins, and has in it what strong lines that
are not in the model leak there; ``white`` takes the residual's variance over all samples, right only where the residual
is white; ``none`` computes no uncertainty. Both take the residual to be stationary and Gaussian, and the frequencies to
be right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from leadscrew.analysis.harmonics.record import (
    Array,
    Sampling,
    checked_frequencies,
    checked_level,
    sampling,
    short_notes,
    values,
)
from leadscrew.kernel.errors import ValueRefused

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

    @property
    def phase_sd(self) -> Array:
        """Standard deviation of each phase, rad, where the line stands above the noise."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.sd / self.amplitudes

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
