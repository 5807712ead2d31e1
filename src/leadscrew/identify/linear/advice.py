"""What a linear fit says of itself in words: what is not identifiable, what is odd, what to measure next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.estimation import LAGS, SHARE, autoregression
from leadscrew.identify.linear.choose import Task
from leadscrew.identify.linear.record import LinearRecord
from leadscrew.identify.linear.result import LinearFit
from leadscrew.identify.linear.uncertainty import beyond, hertz

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
    from leadscrew.util.errors import LeadscrewError

    signals = [record.input, record.output] + ([] if record.command is None else [record.command])
    time = record.time
    if integrators:
        signals, time = [np.diff(s) for s in signals], time[1:]
    try:
        return frequency_response(time, signals[0], signals[1], excitation=signals[2] if len(signals) > 2 else None)
    except LeadscrewError:
        return None


SIGNIFICANT = 4.0
"""Standard deviations of a correlation among 25 lags: about one in 600 by chance."""
ALIKE = 0.9
"""Correlation of the two parts' inputs above which the hold-out is the training again."""
POOR = 50.0
"""Fit in percent below which the model explains little."""


def not_identifiable(fit: LinearFit) -> list[str]:
    """Quantities whose interval is too wide to be of use, or whose frequency the log does not excite."""
    return [name for name, p in fit.parameters.items() if not p.identifiable or _beyond(fit, name)]


def _beyond(fit: LinearFit, name: str) -> bool:
    return fit.excited_hz[1] > 0.0 and beyond(name, fit.parameters[name], fit.excited_hz[1])


def _hertz(fit: LinearFit, name: str) -> float:
    return hertz(name, fit.parameters[name])


def _misses(fit: LinearFit, record: LinearRecord) -> bool:
    """Whether something other than noise is left; what feedback alone explains does not count."""
    looped = fit.feedback > max(SIGNIFICANT, fit.missed) and record.command is None
    return fit.missed > SIGNIFICANT and not looped


def notes(fit: LinearFit, record: LinearRecord, task: Task, asked: bool) -> list[str]:
    """Sentences on the log and the fit."""
    said = []
    high = fit.excited_hz[1]
    if high == 0.0:
        said.append("the input moves the output by less than what is left at every frequency: this is no model of it")
    for name in fit.parameters:
        if _beyond(fit, name):
            said.append(
                f"{name} lies at {_hertz(fit, name):.3g} Hz, above the {high:.3g} Hz up to which the input moves the "
                "output by more than what is left: neither it nor the coefficients nor the delay are identifiable"
            )
        elif not fit.parameters[name].identifiable:
            wide = fit.parameters[name].percent > 100.0 * SHARE
            why = (
                f"half of its 95 % interval is more than {100.0 * SHARE:.0f} % of its value"
                if wide
                else "others stand in for it within its interval"
            )
            said.append(f"{name} is not identifiable from this log: {why}")
    if fit.numerator[-1] < 0.0:
        said.append(
            f"the gain is negative: a positive {fit.input_name} moves {fit.output_name} backwards; a machine file has "
            "it turned"
        )
    last = fit.stretches[-1]
    if len(fit.stretches) == 1:
        said.append("nothing was held out: the error is that of the data the model was fitted to")
    elif last.rms > 2.0 * fit.stretches[0].rms and last.nrmse_percent > 0.1:
        said.append(
            f"the error on the part held out is {last.rms / fit.stretches[0].rms:.2g} times that of the training: the "
            "two parts differ, or the plant is not linear"
        )
    if len(fit.stretches) > 1 and np.ptp(record.input[task.train :]) == 0.0:
        said.append("the input does not change in the part held out: its error judges nothing; log moves in both parts")
    if len(fit.stretches) > 1 and repeats(record.input, task.train) > ALIKE:
        said.append(
            "the part held out repeats the move of the training, and cannot show a model that has only learned this "
            "move: log different moves, and doubt poles and zeros that the axis cannot have"
        )
    if last.fit_percent < POOR:
        said.append(
            f"the model explains little: what it leaves is {100.0 - last.fit_percent:.0f} % of the output's standard "
            "deviation; are input and output the right columns, and not exchanged?"
        )
    if _misses(fit, record):
        said.append(
            "what is left follows the input: the plant is not linear (friction, play, a limit) or has a higher order; "
            "then the intervals, which know of noise only, are too narrow"
        )
    elif fit.missed > SIGNIFICANT:
        said.append(
            f"what is left goes with the input before it as well ({fit.missed:.1f} deviations): feedback alone can do "
            "that; if it is friction, play or a higher order, the intervals, which know of noise only, are too narrow"
        )
    if fit.feedback > SIGNIFICANT and record.command is None:
        said.append(
            "the input answers what is left of the output: the log is from a closed loop, and where the noise is not "
            "white the model leans towards the controller; name the command as well"
        )
    if record.command is not None and not fit.closed_loop:
        said.append("the command explains too little of the input to be an instrument: fitted by output error instead")
    if task.delay is None and fit.delay_s > 0.99 * task.longest:
        said.append(f"the delay ended at the longest that was tried, {task.longest:g} s: allow a longer one")
    if task.delay is None and fit.delay_s < 1e-3 * fit.period:
        said.append("the delay ended at 0: is the output perhaps logged one sample later than the input?")
    if (
        asked
        and fit.structure.integrators == 0
        and np.any(np.abs(fit.poles) < 1.0 / (record.period * len(record.time)))
    ):
        said.append("a pole is slower than the log is long: it cannot be distinguished from one at 0")
    return said


def next_steps(fit: LinearFit, record: LinearRecord) -> list[str]:
    """What to measure next, most useful first."""
    said = []
    fast = [_hertz(fit, n) for n in not_identifiable(fit) if _hertz(fit, n)]
    if fast:
        said.append(
            f"excite {min(fast):.3g} to {2.0 * max(fast):.3g} Hz as well: a chirp, or steps of the input itself"
        )
    if not fit.parameters["delay_s"].identifiable:
        said.append("for the delay: steep changes of the input, and a faster clock")
    if fit.feedback > SIGNIFICANT and record.command is None:
        said.append("log the command too, with some steps or a chirp in it")
    if _misses(fit, record):
        said.append("where friction is behind it, `leadscrew identify axis` fits it: a linear model cannot")
    return said
