"""What a record of evenly spaced samples can tell about lines: its checks, and where a line above Nyquist folds to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.util.errors import DataError, ValueRefused

EVEN = 1e-3
"""Deviation of a sample from its even place, in sample intervals, up to which the samples count as evenly spaced."""

Array = NDArray[np.float64]


class Sampling(NamedTuple):
    """Even sampling of a record."""

    samples: int
    start: float
    """Time of the first sample, s."""
    step: float
    """Interval between samples, s."""

    @property
    def rate(self) -> float:
        """Samples a second, Hz."""
        return 1.0 / self.step

    @property
    def nyquist(self) -> float:
        """Half the rate, Hz."""
        return 0.5 / self.step

    @property
    def duration(self) -> float:
        """Samples times interval, s; its inverse is what two lines must be apart (Rayleigh)."""
        return self.samples * self.step

    @property
    def time(self) -> Array:
        """Seconds, one for each sample."""
        return np.asarray(self.start + self.step * np.arange(self.samples), dtype=np.float64)


def sampling(t: Any, least: int = 4) -> Sampling:
    """The sampling of a record's times.

    Raises:
        DataError: times that are not finite, do not rise, or are not evenly spaced to 0.1 % of the interval; names the
            sample.
        ValueRefused: fewer than ``least`` samples.
    """
    times = np.asarray(t, dtype=np.float64)
    if times.ndim != 1 or len(times) < least:
        raise ValueRefused(f"t has the shape {times.shape}: expected at least {least} times in a row, in s")
    if not np.all(np.isfinite(times)):
        raise DataError(f"t: sample {int(np.flatnonzero(~np.isfinite(times))[0])} is not a finite number")
    n = len(times)
    step = (times[-1] - times[0]) / (n - 1)
    if not step > 0.0:
        raise DataError(f"t: runs from {times[0]:g} to {times[-1]:g} s; expected times that rise")
    off = np.abs(times - times[0] - step * np.arange(n))
    worst = int(np.argmax(off))
    if off[worst] > EVEN * step:
        raise DataError(
            f"t: sample {worst} at {times[worst]:g} s is {off[worst]:.2g} s off its even place; "
            f"expected samples every {step:g} s"
        )
    return Sampling(n, float(times[0]), float(step))


def values(y: Any, samples: int, name: str = "y") -> Array:
    """The samples of one record or of several (one a row), as finite numbers.

    Raises:
        ValueRefused: a shape that does not fit the times.
        DataError: a value that is not finite; names its place.
    """
    found = np.asarray(y, dtype=np.float64)
    if found.ndim < 1 or found.shape[-1] != samples:
        raise ValueRefused(f"{name} has the shape {found.shape}; expected {samples} samples along its last axis, as t")
    if not np.all(np.isfinite(found)):
        place = np.argwhere(~np.isfinite(found))[0]
        raise DataError(f"{name}: sample {', '.join(map(str, place))} is not a finite number")
    return found


def folded(frequency: float, rate: float) -> float:
    """Where a line shows in samples taken at ``rate``: itself below ``rate / 2``, else its alias, both in Hz.

    ``f' = abs(f - rate round(f / rate))``.
    """
    return abs(frequency - rate * round(frequency / rate))


def checked_frequencies(frequencies: Sequence[float] | Array, taken: Sampling) -> Array:
    """The frequencies of lines, in Hz, as an array.

    Raises:
        ValueRefused: none at all, one that is not positive, the same twice, or one at or above Nyquist: says to which
            frequency it folds.
    """
    found = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    if found.ndim != 1 or not len(found):
        raise ValueRefused(f"frequencies = {frequencies!r}: expected one or more frequencies in Hz")
    for f in found:
        if not 0.0 < f < np.inf:
            raise ValueRefused(f"frequencies: {f:g} Hz; expected a positive number of Hz (offset and trend are apart)")
        if f >= taken.nyquist * (1.0 - 1e-9):
            raise ValueRefused(
                f"a line at {f:g} Hz is not below half the sampling rate ({taken.nyquist:g} Hz): sampled at "
                f"{taken.rate:g} Hz it folds to {folded(f, taken.rate):g} Hz"
            )
    rising = np.sort(found)
    same = np.flatnonzero(np.diff(rising) < 1e-9 * rising[1:])
    if len(same):
        raise ValueRefused(f"frequencies: {rising[same[0]]:g} Hz is given twice")
    return found


def short_notes(frequencies: Array, taken: Sampling, base: bool = True) -> list[str]:
    """Sentences about lines closer together, or closer to zero (with ``base``), than one over the record's length."""
    found = []
    rising = np.sort(frequencies)
    resolved = 1.0 / taken.duration
    for low, high in pairwise(rising):
        if high - low < resolved * (1.0 - 1e-6):
            found.append(
                f"a record of {taken.duration:g} s is too short to separate {low:g} and {high:g} Hz (Rayleigh): "
                f"that takes {1.0 / (high - low):.3g} s; their amplitudes are uncertain together"
            )
    if base and rising[0] < resolved * (1.0 - 1e-6):
        found.append(
            f"a record of {taken.duration:g} s holds less than one period of {rising[0]:g} Hz: "
            "the line cannot be separated from offset and trend"
        )
    return found


def checked_level(level: float) -> float:
    """A level of confidence.

    Raises:
        ValueRefused: it is not between 0 and 1.
    """
    if not 0.0 < level < 1.0:
        raise ValueRefused(f"level = {level!r}: expected a probability between 0 and 1, for example 0.95")
    return float(level)
