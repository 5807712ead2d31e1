"""Amplitudes from an FFT, for comparison with least squares: window, and how a line is read.

With a window ``w`` of ``n`` samples an amplitude is ``2 abs(sum w y exp(-j 2 pi f t)) / sum w``, right where no other
line leaks to ``f``. It is read at the ``nearest`` bin (a line between two bins loses up to 36 % with a rectangular
window, 15 % with Hann, 0.1 % with flat-top), at the line's ``exact`` frequency, or ``interpolated`` from the two
highest bins near the line as if it stood alone (rectangular and Hann; the frequency need not be known).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from leadscrew.analysis.harmonics.record import Array, Sampling, checked_frequencies, sampling, values
from leadscrew.kernel.errors import ValueRefused

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
