"""The clock of a log: gaps, steps backwards, double stamps, jitter; and the even grid that its samples lie on.

Stamps that keep within 1 % of an even clock (that of EMPS keeps within 0.003 %) go onto the even grid as they are, and
so do stamps that were only rounded when they were printed: no value is interpolated. Stamps that scatter by more are
taken at their word: position, command and velocity are interpolated between them, the drive is held, and the log says
so. Gaps are refused, with the longest stretch that has none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from leadscrew.logs.finding import Finding
from leadscrew.util.errors import DataError

JITTER = 0.01
"""Share of a period by which a clock may be off and still be called even."""

GAP = 1.5
"""Periods between two stamps that make a gap."""

SLOW, FAST = 0.5, 2e-6
"""Periods in s that no log of an axis has; from a fortieth, or up to five times of them, a unit is asked for."""

SHORTEST_S = 1e-9
"""Shorter periods are not computed with."""

Place = Callable[[int], str]


class Clock(NamedTuple):
    """What the stamps say."""

    time: np.ndarray | None
    """Of the even grid, s; None where there is none."""
    period: float
    scattered: bool
    """Values must be interpolated onto the grid."""
    findings: list[Finding]


def clock(time: np.ndarray, place: Place, lost: Sequence[int] = ()) -> Clock:
    """The even grid nearest to the stamps (s, finite) and what is wrong with them.

    Raises:
        DataError: fewer than three stamps.
    """
    if len(time) < 3:
        raise DataError(f"{len(time)} row{'s' if len(time) != 1 else ''} of data: three or more tell a sampling period")
    steps = np.diff(time)
    typical = float(np.median(steps))
    even = float(time[-1] - time[0]) / (len(time) - 1)
    if 0.0 < even < SHORTEST_S:
        said = f"times rise by {even:g} s from row to row: is their unit right?"
        return Clock(None, even, False, [Finding("clock", "refused", said)])
    if even > 0.0 and float(np.abs(steps / even - 1.0).max()) <= JITTER:
        return Clock(time[0] + even * np.arange(len(time)), even, False, _rate(even) + _lost(lost, place))
    if rounded := _rounded(time):
        step, period = rounded
        note = f"times are rounded to {step:g} s: taken as even, every {period:.6g} s"
        findings = [Finding("clock", "note", note), *_rate(period), *_lost(lost, place)]
        return Clock(time[0] + period * np.arange(len(time)), period, False, findings)
    if faults := _faults(time, steps, typical, place):
        return Clock(None, typical, False, faults)
    scatter = float(np.sqrt(np.mean((steps / even - 1.0) ** 2)))
    at = int(np.argmax(np.abs(steps - even)))
    said = (
        f"times scatter by {100.0 * scatter:.2g} % of the period of {even:.6g} s (worst {place(at + 1)}, "
        f"{steps[at]:.6g} s after the one before): position interpolated, drive held on an even grid; record with a "
        "real-time clock for sound accelerations"
    )
    return Clock(time[0] + even * np.arange(len(time)), even, True, [Finding("jitter", "warning", said), *_rate(even)])


def on_grid(stamps: np.ndarray, grid: np.ndarray, values: np.ndarray, held: bool) -> np.ndarray:
    """Values on an even grid: held from the last stamp before, or on straight lines between stamps."""
    if not held:
        return np.interp(grid, stamps, values)
    slack = 1e-9 * (grid[1] - grid[0])
    return np.asarray(values[np.clip(np.searchsorted(stamps, grid + slack, side="right") - 1, 0, None)])


def _rounded(time: np.ndarray) -> tuple[float, float] | None:
    """Step of rounding and true period, where an even clock and rounding explain all stamps."""
    index = np.arange(len(time))
    period, start = (float(x) for x in np.polyfit(index, time - time[0], 1))
    off = float(np.abs(time - time[0] - start - period * index).max())
    for digits in range(10):
        step = 10.0**-digits
        if float(np.abs(time / step - np.rint(time / step)).max()) < 1e-4:
            # Ten stamps to a step of rounding at most: else gaps could hide.
            return (step, period) if off <= 0.75 * step and period > 0.1 * step else None
    return None


def _faults(time: np.ndarray, steps: np.ndarray, typical: float, place: Place) -> list[Finding]:
    """What makes an even grid impossible."""
    if not np.any(steps):
        return [Finding("clock", "refused", f"the time is {time[0]:g} s in every row: name another column of times")]
    back = np.flatnonzero(steps < 0.0)
    if len(back):
        return [Finding("clock", "refused", _backwards(time, back, place))]
    double = np.flatnonzero(steps == 0.0)
    if len(double):
        k = int(double[0]) + 1
        more = f", and so on {len(double)} times" if len(double) > 1 else ""
        said = f"{place(k)} has the time {time[k]:.9g} s of the one before{more}: leave out double samples"
        return [Finding("clock", "refused", said)]
    wide = np.flatnonzero(steps > GAP * typical)
    if len(wide):
        return [Finding("gap", "refused", _gaps(time, steps, wide, typical, place))]
    period, start = np.polyfit(np.arange(len(time)), time, 1)
    if float(np.abs(time - start - period * np.arange(len(time))).max()) > 2.0 * typical:
        said = (
            f"the period drifts from {steps[: len(steps) // 4].mean():.6g} to {steps[-len(steps) // 4 :].mean():.6g} "
            "s: take a part with an even clock with --start and --end"
        )
        return [Finding("clock", "refused", said)]
    return []


def _backwards(time: np.ndarray, back: np.ndarray, place: Place) -> str:
    k = int(back[0]) + 1
    if len(back) == len(time) - 1:
        return f"the time falls from {time[0]:g} to {time[-1]:g} s in every row: name another column of times"
    if len(back) < 10 and abs(time[k] - time[0]) <= 2.0 * abs(np.median(np.diff(time))):
        return (
            f"{place(k)}: the time starts again at {time[k]:g} s after {time[k - 1]:g} s: {len(back) + 1} records in "
            "one file; cut it there"
        )
    more = f", and {len(back) - 1} times more" if len(back) > 1 else ""
    return (
        f"{place(k)}: the time {time[k]:.9g} s lies before the {time[k - 1]:.9g} s of the one before{more}: the clock "
        "was set while it recorded; take a part without this with --start and --end, or name another column of times"
    )


def _gaps(time: np.ndarray, steps: np.ndarray, wide: np.ndarray, typical: float, place: Place) -> str:
    k = int(wide[np.argmax(steps[wide])])
    edges = np.concatenate([[-1], wide, [len(time) - 1]])
    longest = int(np.argmax(np.diff(edges)))
    low, high = time[edges[longest] + 1], time[edges[longest + 1]]
    count = "a gap" if len(wide) == 1 else f"{len(wide)} gaps, the longest"
    return (
        f"{count} of {steps[k]:.4g} s before {place(k + 1)} (after {time[k]:.6g} s) where the period is {typical:.4g} "
        f"s: the longest part without one is --start {low:.6g} --end {high:.6g}"
    )


def _lost(lost: Sequence[int], place: Place) -> list[Finding]:
    if not lost:
        return []
    said = (
        f"the recorder lost samples {len(lost)} times ('overrun'), first before {place(lost[0])}, and how many is not "
        "known: record with halsampler -t, or a deeper FIFO"
    )
    return [Finding("gap", "refused", said)]


def _rate(period: float) -> list[Finding]:
    """A period that no log of an axis has, or hardly one."""
    if period >= SLOW:
        said = f"a period of {period:g} s is too long for an axis: if the times are in ms, say --unit time=ms"
        return [Finding("unit", "refused", said)]
    if period <= FAST:
        said = f"a period of {period:g} s is too short for an axis: if the times are in s, say --unit time=s"
        return [Finding("unit", "refused", said)]
    if period >= SLOW / 40.0:
        said = (
            f"a period of {period:g} s tells little of an axis's dynamics: record every 2 ms or faster; if the times "
            "are in another unit, say --unit time=UNIT"
        )
        return [Finding("rate", "warning", said)]
    if period <= 5.0 * FAST:
        said = f"a period of {period:g} s is very short for an axis: if the times are in s, say --unit time=s"
        return [Finding("unit", "warning", said)]
    return []
