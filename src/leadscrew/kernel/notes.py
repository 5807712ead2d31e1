"""What a run shows that its metrics do not: a loop that moves away from its target, inputs outside of their ranges.

Both are judged from recorded signals and need the whole run: a live loop and a batch get no notes.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.kernel.frame import Pair, pairs, signal_tree, under
from leadscrew.util.frames import warning_level

if TYPE_CHECKING:
    from leadscrew.kernel.block import InputRange
    from leadscrew.kernel.loop import Loop
    from leadscrew.kernel.run import Run

WRONG_WAY, GROWTH, AT_END = 0.01, 1.1, 0.9
"""Shares by which a loop is judged to move away, see :func:`_moved_away`."""
OUTSIDE = 0.01
"""Share of the periods outside of an input's range from which a note says so."""


class Note(NamedTuple):
    """A sentence on a run and what it is about: ``moved_away`` or ``outside_range``."""

    kind: str
    message: str


class RunWarning(UserWarning):
    """A run has a note."""


class DivergenceWarning(UserWarning):
    """A loop diverged and was stopped."""


def warn_diverged(text: str) -> None:
    """Says once, in words, that a loop diverged."""
    warnings.warn(text, DivergenceWarning, stacklevel=warning_level())


def needed(loop: Loop) -> list[str]:
    """The recorded columns that the notes are made from."""
    roots = ["command", "actual", "true_error", "disturbance"]
    block = loop.blocks["controller"]
    return roots if block is None or not block.input_ranges else [*roots, "feedback"]


def notes(run: Run) -> tuple[Note, ...]:
    """The notes on a run, as far as its recorded signals allow."""
    if len(run.signals.get("time", ())) < 3:
        return ()
    loop = run.loop
    away: tuple[Note, float] | None = None
    quiet = loop.blocks["output_disturbance"] is None and not any(
        np.any(v) for k, v in run.signals.items() if k.split(".")[0] == "disturbance"
    )
    seen = loop.blocks["disturbance"] is None or any(k.split(".")[0] == "disturbance" for k in run.signals)
    if quiet and seen:
        found = pairs(signal_tree(loop.signals["command"]), signal_tree(loop.signals["actual"]))
        away = next((n for n in (_moved_away(run, pair) for pair in found) if n), None)
    controller = loop.blocks["controller"]
    ranges = controller.input_ranges if controller is not None else ()
    outside = [n for n in (_outside(run, r, away[1] if away else np.inf) for r in ranges) if n]
    return tuple([away[0], *outside] if away else outside)


def _moved_away(run: Run, pair: Pair) -> tuple[Note, float] | None:
    """A note where the axis left its start against the command, and the largest error that it would have at rest.

    With ``c`` the command and ``x`` the true output, both less the true output at the start, and ``e = c - x``: the
    first ``|x|`` above 1 % of ``max |c|`` has the sign of ``-c``, and ``x`` keeps that sign within 1 %; in every period
    ``|e| >= 0.99 |c|``; at the end ``|e|`` is at least ``1.1 max |c|`` and 0.9 of its maximum. Not judged: a run under
    a disturbance, and one whose command stays where the axis is.
    """
    names = [under("command", pair.command), under("actual", pair.other), f"true_error{pair.suffix}"]
    if any(n not in run.signals for n in names):
        return None
    command, actual, error = (run.signals[n] for n in names)
    kept = np.isfinite(command) & np.isfinite(actual) & np.isfinite(error)
    command, actual, error = command[kept], actual[kept], error[kept]
    if not len(error):
        return None
    at_rest, moved, size = command - actual[0], actual - actual[0], np.abs(error)
    reach = float(np.max(np.abs(at_rest)))
    if reach <= 1e-9 * max(float(np.max(np.abs(command))), abs(float(actual[0]))):
        return None
    left = np.flatnonzero(np.abs(moved) > WRONG_WAY * reach)
    if not len(left) or moved[left[0]] * at_rest[left[0]] >= 0.0:
        return None
    if np.any(moved * np.sign(moved[left[0]]) < -WRONG_WAY * reach):  # to and fro: unstable, not reversed
        return None
    if np.any(size < (1.0 - WRONG_WAY) * np.abs(at_rest)):
        return None
    if size[-1] < max(GROWTH * reach, AT_END * float(np.max(size))):
        return None
    loop, plant = run.loop, run.loop.blocks["plant"]
    assert plant is not None
    unit = f" {plant.unit}" if plant.unit not in ("", "1") else ""
    text = (
        f"the loop moved away from its target from the start: |error| is {size[-1]:.4g}{unit} at the end and would be "
        f"at most {reach:.4g}{unit} at rest; is the sign of the controller or of the drive reversed?"
    )
    if plant.sense < 0:
        scale = loop.parameters.get("controller.scale_output")
        text += f" A positive input moves {plant.name} towards negative values: " + (
            f"set controller.scale_output={-scale:g}."
            if isinstance(scale, float)
            else "take a controller whose positive output moves towards negative feedback: leadscrew list NAME."
        )
    return Note("moved_away", text), reach


def _outside(run: Run, covered: InputRange, largest_error: float) -> Note | None:
    """A note where an input of the controller lies outside of its range in at least 1 % of the periods.

    Periods with an error above ``largest_error`` are not judged: a loop that runs away leaves every range.
    """
    key = f"controller.{covered.scale}"
    scale = run.loop.parameters.get(key)
    names = covered.command, covered.feedback
    exact = run.every == 1 or covered.source in ("error", "command", "feedback")
    if not isinstance(scale, float) or any(n not in run.signals for n in names) or not exact:
        return None
    command, feedback = (run.signals[n] for n in names)
    error = command - feedback
    signal = {
        "error": error,
        "command": command,
        "feedback": feedback,
        "change": np.diff(error, prepend=error[0]),
        "rate": np.diff(error, prepend=error[0]) / run.loop.period,
        "integral": (np.cumsum(error) - error) * run.loop.period,
    }[covered.source]
    signal = signal[np.abs(error) <= largest_error * (1.0 + 1e-9)]
    values = scale * signal
    slack = 1e-9 * (covered.high - covered.low)
    out = (values < covered.low - slack) | (values > covered.high + slack)
    share = float(np.mean(out)) if len(out) else 0.0
    if share < OUTSIDE:
        return None
    largest = float(signal[np.argmax(np.abs(signal))])
    text = (
        f"input {covered.name} of the fuzzy system covers {covered.low:g} to {covered.high:g}; {covered.source} "
        f"reached {largest:.4g}, and {key}={scale:g} puts it outside in {100.0 * share:.3g} % of the periods"
    )
    side = covered.high if scale * largest > 0.0 else covered.low
    fits = side / largest
    if np.isfinite(fits) and fits * scale > 0.0:
        return Note("outside_range", f"{text}: {key}={_rounded_down(fits)} fits it in.")
    return Note("outside_range", f"{text}: set {key} so that it fits.")


def _rounded_down(value: float) -> str:
    """A number with two digits, rounded towards zero."""
    step = 10.0 ** (np.floor(np.log10(abs(value) * (1.0 + 1e-12))) - 1)
    return f"{np.trunc(value / step * (1.0 + 1e-12)) * step:.2g}"
