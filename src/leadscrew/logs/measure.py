"""What a measured position says of its encoder and its motion: step, noise, speed and acceleration."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Motion(NamedTuple):
    """Filtered derivatives of a position: a straight line and a parabola fitted to a window around every sample."""

    speed: np.ndarray
    acceleration: np.ndarray
    margin: int
    """Samples at either end where they mean little."""

    @property
    def top_speed(self) -> float:
        """Passed in 1 sample of 1000 only, so that single bad samples do not count."""
        return _top(self.speed, self.margin)

    @property
    def top_acceleration(self) -> float:
        """The same of the acceleration."""
        return _top(self.acceleration, self.margin)


def motion(position: np.ndarray, period: float, seconds: float = 0.02) -> Motion:
    """Speed and acceleration by polynomials of order 2 over windows of about ``seconds`` and at least 7 samples.

    Source: A. Savitzky, M. Golay, Smoothing and differentiation of data, Analytical Chemistry 36 (1964) 1627.
    """
    from scipy.signal import savgol_filter

    half = int(np.clip(round(0.5 * seconds / period), 3, np.clip((len(position) - 1) // 4, 3, 200)))
    width = 2 * half + 1
    if len(position) < width:
        return Motion(np.gradient(position, period), np.gradient(np.gradient(position, period), period), 0)
    centred = position - position[0]
    return Motion(
        savgol_filter(centred, width, 2, deriv=1, delta=period),
        savgol_filter(centred, width, 2, deriv=2, delta=period),
        half,
    )


def _top(values: np.ndarray, margin: int) -> float:
    inner = values[margin : len(values) - margin] if len(values) > 4 * margin else values
    return float(np.quantile(np.abs(inner), 0.999))


def dust(position: np.ndarray) -> float:
    """Differences up to which two values are the same but for rounding of their last digits."""
    return 1e-9 * float(np.ptp(position)) + 4.0 * np.finfo(float).eps * float(np.abs(position).max(initial=0.0))


def encoder_step(position: np.ndarray) -> float:
    """The grid that the values lie on; 0 where there is none.

    The smallest difference between neighbours that is no rounding of the last digits, if nine of ten differences are
    multiples of it within 5 %.
    """
    steps = np.abs(np.diff(position))
    turns = np.count_nonzero(np.diff(steps > 0.0))
    least = dust(position)
    steps = steps[steps > least]
    if not len(steps):
        return 0.0
    if len(steps) < 10:
        return 0.0
    if float(np.ptp(steps)) <= least:
        # Single counts with standing between them; a constant speed has no standing between.
        return float(steps.mean()) if turns >= 10 else 0.0
    for small in (float(steps.min()), *(float(x) for x in np.quantile(steps, (0.001, 0.01)))):
        step = _refined(steps, small)
        few = steps[steps < 20.5 * step]
        # Each size once: a smooth signal repeats some, and they would pass for a grid.
        sizes = np.unique(np.rint(few / (0.01 * step))) / 100.0
        off = np.abs(sizes % 1.0 - 0.5)
        if len(few) >= 10 and float(np.mean(off > 0.45)) > 0.9:
            return step
    return 0.0


def _refined(steps: np.ndarray, step: float) -> float:
    """A better estimate of a grid from its larger multiples, as far as they can be counted."""
    for most in (1.5, 5.0, 20.0):
        some = steps[steps < most * step]
        step = float((some / np.maximum(np.rint(some / step), 1.0)).mean())
    return step


def noise(position: np.ndarray, step: float) -> float:
    """Root mean square of the noise of a position, quantisation included.

    From third differences, which smooth motion hardly has: their median over 1.4826 sigma, by sqrt(20) for white noise;
    never below the ``step`` over sqrt(12).
    """
    third = np.diff(position, 3)
    sigma = 1.4826 * float(np.median(np.abs(third))) / np.sqrt(20.0) if len(third) else 0.0
    return float(max(sigma, step / np.sqrt(12.0)))


def beyond_step(noise: float, step: float) -> float:
    """Noise besides the rounding to steps, root mean square; 0 where the rounding is all of it."""
    return float(np.sqrt(noise**2 - step**2 / 12.0)) if noise > (1.0 + 1e-6) * step / np.sqrt(12.0) else 0.0
