"""What a linear fit says of itself in words: what the log does not tell, what is odd, what to measure next."""

from __future__ import annotations

import numpy as np

from leadscrew.identify.linear.choose import Task
from leadscrew.identify.linear.record import LinearRecord
from leadscrew.identify.linear.result import LinearFit
from leadscrew.identify.linear.signs import repeats
from leadscrew.identify.linear.sureness import TOLD, beyond, hertz

SIGNIFICANT = 4.0
"""Standard deviations of a correlation among 25 lags: about one in 600 by chance."""
ALIKE = 0.9
"""Correlation of the two parts' inputs above which the hold-out is the training again."""
POOR = 50.0
"""Fit in percent below which the model explains little."""


def untold(fit: LinearFit) -> list[str]:
    """Quantities whose interval is too wide to be of use, or whose frequency the log does not excite."""
    return [name for name, p in fit.parameters.items() if not p.told or _beyond(fit, name)]


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
                "output by more than what is left: the log does not tell it, nor the coefficients, nor the delay"
            )
        elif not fit.parameters[name].told:
            wide = fit.parameters[name].percent >= TOLD
            why = "its 95 % interval is as wide as the value" if wide else "others stand in for it within its interval"
            said.append(f"{name} is not told by this log: {why}")
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
        said.append("a pole is slower than the log is long: it cannot be told from one at 0")
    return said


def next_steps(fit: LinearFit, record: LinearRecord) -> list[str]:
    """What to measure next, most useful first."""
    said = []
    fast = [
        _hertz(fit, n) for n in fit.parameters if _hertz(fit, n) and (_beyond(fit, n) or not fit.parameters[n].told)
    ]
    if fast:
        said.append(
            f"excite {min(fast):.3g} to {2.0 * max(fast):.3g} Hz as well: a chirp, or steps of the input itself"
        )
    if not fit.parameters["delay_s"].told:
        said.append("for the delay: steep changes of the input, and a faster clock")
    if fit.feedback > SIGNIFICANT and record.command is None:
        said.append("log the command too, with some steps or a chirp in it")
    if _misses(fit, record):
        said.append("where friction is behind it, `leadscrew identify axis` fits it: a linear model cannot")
    return said
