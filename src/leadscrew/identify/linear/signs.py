"""What a log and a residual show beside the fit: which frequencies speak, whether something is missed, feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.linear.intervals import LAGS, autoregression
from leadscrew.identify.linear.record import LinearRecord

if TYPE_CHECKING:
    from leadscrew.analysis.frequency_response import FrequencyResponse

SEGMENTS = 8


def correlations(residual: np.ndarray, u: np.ndarray) -> tuple[float, float]:
    """Largest correlation of the residual with the whitened input before and after it, in standard deviations.

    Both are whitened by autoregressions, so that their cross-correlation has the deviation ``1 / sqrt(n)`` at each of
    the 25 lags where they have nothing to do with each other (Ljung, *System Identification*, 2nd ed., 1999, 16.6).
    An input of the same sample counts as after: a controller has read the output before it answers.
    """
    e, v = _white(residual), _white(u - u.mean())
    n = min(len(e), len(v))
    e, v = e[-n:], v[-n:]
    if not (np.any(e) and np.any(v)):
        return 0.0, 0.0
    lags = min(LAGS, n // 4)
    size = float(np.sqrt(np.sum(e**2) * np.sum(v**2)))
    before = [abs(float(e[k:] @ v[: n - k])) for k in range(1, lags + 1)]
    after = [abs(float(e[: n - k] @ v[k:])) for k in range(lags)]
    return max(before) / size * np.sqrt(n), max(after) / size * np.sqrt(n)


def _white(values: np.ndarray) -> np.ndarray:
    from scipy.signal import lfilter

    a = autoregression(values)[0]
    return np.asarray(lfilter(a, [1.0], values))[len(a) - 1 :]


def repeats(u: np.ndarray, train: int) -> float:
    """Largest correlation of the input held out with the training's input at any shift, its mean taken off."""
    a, b = u[:train] - u[:train].mean(), u[train:] - u[train:].mean()
    size = 1 << int(len(a) + len(b)).bit_length()
    together = np.fft.irfft(np.fft.rfft(a, size) * np.fft.rfft(b, size).conj(), size)
    whole = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.max(np.abs(together))) / whole if whole > 0.0 else 0.0


def excited(
    u: np.ndarray, residual: np.ndarray, period: float, gain: tuple[np.ndarray, np.ndarray]
) -> tuple[float, float]:
    """First and last frequency, Hz, at which the model's answer to the input is larger than what is left.

    ``gain`` are frequencies and the model's gain at them.
    """
    from scipy.signal import welch

    size = min(len(u), max(128, 2 * len(u) // (SEGMENTS + 1)))
    hz, moved = welch(u, 1.0 / period, nperseg=size, detrend="linear")
    left = welch(residual, 1.0 / period, nperseg=size, detrend="linear")[1]
    answer = moved[1:] * np.interp(hz[1:], gain[0], np.abs(gain[1])) ** 2
    shows = np.flatnonzero(answer > left[1:])
    return (float(hz[1 + shows[0]]), float(hz[1 + shows[-1]])) if len(shows) else (0.0, 0.0)


def measured_response(record: LinearRecord, integrators: int) -> FrequencyResponse | None:
    """The log's own response from input to output; of both the differences where the plant integrates.

    The response between the differences is the same, and a position that has moved away does not leak into it.
    """
    from leadscrew.analysis.frequency_response import frequency_response
    from leadscrew.kernel.errors import LeadscrewError

    signals = [record.input, record.output] + ([] if record.command is None else [record.command])
    time = record.time
    if integrators:
        signals, time = [np.diff(s) for s in signals], time[1:]
    try:
        return frequency_response(time, signals[0], signals[1], excitation=signals[2] if len(signals) > 2 else None)
    except LeadscrewError:
        return None
