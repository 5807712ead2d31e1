"""Which refinement, where the windows leave more than the sensor's noise: by halves of the training part, in turn.

With noise of the sensor alone windows are maximum likelihood. On a real axis forces act that no model knows; then long
windows add up more of them, short ones tell less, and which serves best is a matter of the log. So each way of
:data:`TRIED` is fitted to one half of the training part and simulated, from the drive alone, over the other half, and
the reverse; the way whose simulated position is off by least, both halves together, is taken. The hold-out takes no
part in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from leadscrew.identify.axis.filters import corner_of
from leadscrew.identify.axis.intervals import estimates_of
from leadscrew.identify.axis.job import LEAST, Job
from leadscrew.identify.axis.refine_windows import WINDOW_S
from leadscrew.identify.axis.stage import PENDING, Line, line
from leadscrew.kernel.errors import DataError

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog


class Way(NamedTuple):
    """A way to refine."""

    mode: Literal["windows", "open", "none"]
    window_s: float | None
    error: float = float("nan")
    """Root mean square of the simulated position's error where it was foretold, m or rad."""

    @property
    def name(self) -> str:
        """In words."""
        if self.mode == "windows":
            return f"windows of {self.window_s:g} s"
        return "open loop over all" if self.mode == "open" else "no refinement"


TRIED = (
    Way("windows", WINDOW_S), Way("windows", 0.5), Way("windows", 0.25), Way("open", None), Way("none", None),
)  # fmt: skip
"""The usual one first."""


def compared(
    job: Job, model: Line, start: Mapping[str, float], keys: Sequence[str], symmetric: bool, delay_s: float
) -> list[Way]:
    """The ways with their errors, least first; none where the training part is too short for halves.

    Args:
        job: the log and where it is cut.
        model: the line of the whole training part: its terms and delay are those of the halves.
        start: values that a refinement starts from, all that the plant needs.
        keys: fitted ones.
        symmetric: friction alike both ways.
        delay_s: of the drive.
    """
    middle = job.cut // 2
    if middle < LEAST:
        return []
    halves = ((0, middle), (middle, job.cut))
    squares = np.zeros((len(TRIED), 2))
    for half, (first, last) in enumerate(halves):
        other, seen = job.stretch(*halves[1 - half]), job.stretch(first, last)
        begin = dict(start)
        try:
            begin |= _by_line(job, model, first, last, symmetric)
        except DataError:
            return []
        for i, way in enumerate(TRIED):
            job.say("comparing refinements", 0.5 + 0.05 * (half * len(TRIED) + i) / len(TRIED))
            squares[i, half] = _error(way, seen, other, begin, keys, symmetric, delay_s)
    found = [way._replace(error=float(np.sqrt(np.mean(s)))) for way, s in zip(TRIED, squares, strict=True)]
    return sorted(found, key=lambda way: way.error)


def _by_line(job: Job, model: Line, first: int, last: int, symmetric: bool) -> dict[str, float]:
    """Values of the same line on one half."""
    fit, record = model.fit, job.record
    terms = replace(fit.terms, stribeck_speed=PENDING if fit.terms.stribeck_speed is not None else None)
    found = estimates_of(line(record.part(first, last), terms, corner_of(fit.length, record.period), fit.delay).fit)
    values = dict(found.values)
    sides = ("backward",) if symmetric else ()
    values |= {k.replace("forward", s): v for s in sides for k, v in found.values.items() if ".forward." in k}
    for key, value in found.values.items():
        if key.endswith(".stribeck_speed"):
            values[key.replace("forward", "backward")] = value
        static = key.replace(".coulomb", ".static")
        if static != key and static not in found.values:
            values |= dict.fromkeys([static, static.replace("forward", "backward")] if symmetric else [static], value)
    return {k: v for k, v in values.items() if k not in job.given}


def _error(
    way: Way, seen: AxisLog, other: AxisLog, begin: Mapping[str, float], keys: Sequence[str], symmetric: bool,
    delay_s: float,
) -> float:  # fmt: skip
    """Mean square of the simulated position's error on the other half; infinite where it cannot be had."""
    from leadscrew.identify.axis.refine import refine
    from leadscrew.identify.axis.refine_replay import played
    from leadscrew.identify.axis.simulation import plant_values, simulate_open
    from leadscrew.identify.axis.starts import by_model

    values, late = dict(begin), delay_s
    try:
        if way.mode != "none":
            values = refine(seen, begin, keys, symmetric, way.mode, delay_s, window_s=way.window_s).values
            late = values.get("delay_s", delay_s)
        values.pop("delay_s", None)
        begins = by_model(other, played(other), plant_values(values, other.force_per_drive), [0], late)[0]
        return float(np.mean((simulate_open(other, values, late, begins) - other.position) ** 2))
    except DataError:
        return float("inf")
