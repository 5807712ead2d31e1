"""The lines of a machine's record by name: a motion's orders, a spindle's turns and teeth, lines of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from leadscrew.analysis.harmonics.lines import (
    Fundamental,
    Harmonics,
    Spectrum,
    Window,
    fitted_fundamental,
    least_squares,
    spectrum,
)
from leadscrew.analysis.harmonics.record import Array, Sampling, folded, sampling, values
from leadscrew.util.errors import DataError, ValueRefused

ROUNDS = 3
"""How often base and spindle are fitted, each with the other's lines in the model."""
SLIP = 0.02
"""How far the spindle's speed is looked for to both sides."""
LOUD = 8.0
"""A line of the residual stands out where its Hann amplitude is so many medians of the spectrum beside it."""
CHANCE = 1e-3
"""How often noise alone may pass for a line somewhere in the range of a fitted frequency."""


@dataclass(frozen=True)
class Measured:
    """Named lines of one record."""

    names: tuple[str, ...]
    harmonics: Harmonics
    base: Fundamental | None
    """The motion's fundamental, where it was fitted."""
    spindle: Fundamental | None
    """The spindle's frequency, where it was fitted."""
    spectrum: Spectrum
    fft: Array
    """Amplitudes of the same lines at the nearest bin of the spectrum."""
    notes: tuple[str, ...]

    def as_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Everything for JSON."""
        found: dict[str, Any] = {"line": list(self.names), **self.harmonics.as_dict(level)}
        for name, fit in (("base", self.base), ("spindle", self.spindle)):
            low, high = (None, None) if fit is None else fit.confidence(level)
            found[f"{name}_fitted_hz"] = None if fit is None else fit.frequency
            found[f"{name}_low_hz"], found[f"{name}_high_hz"] = low, high
        return {**found, "fft_window": self.spectrum.window, "fft_amplitude": self.fft.tolist(),
                "notes": list(self.notes)}  # fmt: skip


def measure(
    t: Any,
    y: Any,
    *,
    base: float | None = None,
    orders: Sequence[float] = (),
    lines: Sequence[float] = (),
    fit_base: bool = False,
    within: float = 0.05,
    spindle_rpm: float | None = None,
    teeth: int = 1,
    fit_spindle: bool = False,
    window: Window = "hann",
) -> Measured:
    """Amplitudes of named lines in one record, by least squares, all at once.

    Args:
        t: evenly spaced times, s.
        y: the record.
        base: frequency of the motion, Hz; it is always in the model, as it is what leaks most.
        orders: its harmonics that are asked for.
        lines: other frequencies, Hz.
        fit_base: fit the motion's frequency, a share ``within`` to both sides.
        within: see ``fit_base``.
        spindle_rpm: speed of the spindle, 1/min: lines once a turn and once a tooth.
        teeth: of the cutter.
        fit_spindle: fit the spindle's speed within 2 %.
        window: of the FFT that is shown beside.

    A line of the spindle above half the sampling rate is measured where it folds to, and a note says so.

    Raises:
        DataError: times that are not even, a value that is not finite, no fundamental within the range: the best fit
            lies at its end, or none of its lines is larger than what noise makes at the best place of such a range
            (once in 1000 records).
        ValueRefused: no line at all, another line above Nyquist (says where it folds), or a value out of its range.
    """
    taken = t if isinstance(t, Sampling) else sampling(t, 8)
    seen = values(y, taken.samples)
    if base is None and (orders or fit_base):
        raise ValueRefused("orders and a fitted base are of a motion: expected its frequency as base, in Hz")
    if base is None and not lines and spindle_rpm is None:
        raise ValueRefused("no line to measure: expected base with orders, spindle_rpm, or lines")
    if spindle_rpm is None and (fit_spindle or teeth != 1):
        raise ValueRefused("teeth and a fitted spindle need the spindle's speed: expected spindle_rpm, in 1/min")
    if any(n != int(n) or n < 1 for n in orders):
        raise ValueRefused(f"orders = {tuple(orders)!r}: expected whole orders from 1 on")
    if teeth != int(teeth) or teeth < 1:
        raise ValueRefused(f"teeth = {teeth!r}: expected a whole number from 1 on")
    if spindle_rpm is not None and not 0.0 < spindle_rpm < np.inf:
        raise ValueRefused(f"spindle_rpm = {spindle_rpm!r}: expected a positive speed in 1/min")
    whole = sorted({1, *map(int, orders)}) if base is not None else []
    turns = [1, *([int(teeth)] if teeth > 1 else [])] if spindle_rpm is not None else []
    of_base, of_spindle = base or 0.0, (spindle_rpm or 0.0) / 60.0
    found_base = found_spindle = None
    for _ in range(ROUNDS if fit_base and fit_spindle else 1):
        if fit_spindle:
            rest = [*(n * of_base for n in whole), *lines]
            found_spindle = fitted_fundamental(taken, seen, (spindle_rpm or 0.0) / 60.0, turns, SLIP, others=rest)
            of_spindle = found_spindle.frequency
        if fit_base:
            rest = [*(folded(n * of_spindle, taken.rate) for n in turns), *lines]
            found_base = fitted_fundamental(taken, seen, base or 0.0, whole, within, others=rest)
            of_base = found_base.frequency
    named = {f"order {n}": n * of_base for n in whole} | {f"{f:g} Hz": float(f) for f in lines}
    notes: list[str] = []
    for n in turns:
        name, f = "spindle" if n == 1 else f"teeth ({n})", n * of_spindle
        named[name] = folded(f, taken.rate)
        if f >= taken.nyquist:
            notes.append(
                f"{name} at {f:g} Hz is above half the sampling rate: measured at its alias, {named[name]:g} Hz"
            )
    if found_base is not None:
        _stands_out(taken, found_base, within * (base or 0.0), f"{100.0 * within:g} % of {base:g} Hz")
    if found_spindle is not None:
        _stands_out(taken, found_spindle, SLIP * (spindle_rpm or 0.0) / 60.0, f"2 % of {spindle_rpm:g} 1/min")
    _no_two_alike(named)
    h = least_squares(taken, seen, list(named.values()))
    shown = spectrum(taken, seen, window)
    wanted = list(named.values())
    notes += [*h.notes, *_part_of_a_period(taken, named), *_loud(taken, seen - h.at(taken.time), h)]
    return Measured(tuple(named), h, found_base, found_spindle, shown, shown.amplitude(wanted), tuple(notes))


def _stands_out(taken: Sampling, found: Fundamental, reach: float, where: str) -> None:
    """Refuses a frequency whose lines are no larger than noise makes them at the best place of ``reach`` to both sides.

    A line at a given place is seen where noise alone makes it so large in 1 of 20 records. The best of many places is
    that large in most records: here 1 in 1000 records counts, shared among all places, one a bin and order.
    """
    lines = found.harmonics
    bins = [max(1.0, 2.0 * reach * n * taken.duration) for n in found.orders]
    if np.any(lines.confidence(1.0 - 2.0 * CHANCE / sum(bins))[0] > 0.0):
        return
    best = int(np.argmax(lines.amplitudes / np.maximum(lines.sd, 1e-300)))
    raise DataError(
        f"no fundamental within {where}: the best, {found.frequency:.6g} Hz, is no better than noise makes somewhere "
        f"in such a range (its clearest line has {lines.amplitudes[best]:.3g}, the noise {lines.sd[best]:.2g}); look "
        "at the spectrum for the right one, or name the strong lines beside it"
    )


def _part_of_a_period(taken: Sampling, named: dict[str, float]) -> list[str]:
    """A sentence for every line of which the record holds less than a period."""
    return [
        f"{name}: {f * taken.duration:.2g} of a period is in the record: do not believe its amplitude and interval; "
        f"take {1.0 / f:.3g} s or more"
        for name, f in named.items()
        if f * taken.duration < 1.0 - 1e-6
    ]


def _no_two_alike(named: dict[str, float]) -> None:
    rising = sorted(named, key=named.__getitem__)
    for one, other in pairwise(rising):
        if named[other] - named[one] < 1e-9 * named[other]:
            raise ValueRefused(f"at {named[one]:g} Hz, {one} and {other} cannot be distinguished in this record")


def _loud(taken: Sampling, residual: Array, found: Harmonics) -> list[str]:
    """A sentence about the largest line that is not in the model, where it stands out."""
    left = spectrum(taken, residual, "hann")
    amplitudes = left.amplitudes[3:]
    if len(amplitudes) < 32:
        return []
    k = int(np.argmax(amplitudes))
    beside = np.concatenate([amplitudes[max(0, k - 40) : max(0, k - 3)], amplitudes[k + 4 : k + 41]])
    if amplitudes[k] > LOUD * np.median(beside) and amplitudes[k] > 0.1 * np.min(found.amplitudes):
        frequency, size = left.peak(k + 3)
        return [
            f"the largest line that is not in the model is at {frequency:.4g} Hz, {size:.3g}: name it, and the others "
            "are measured better"
        ]
    return []
