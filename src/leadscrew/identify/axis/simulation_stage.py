"""The second stage of a fit: refinement by simulation, and whether it is better than the linear stage.

Which refinement, where the windows leave more than the sensor's noise: by halves of the training part, in turn.

With noise of the sensor alone windows are maximum likelihood. On a real axis forces act that no model knows; then long
windows add up more of them, short ones tell less, and which serves best is a matter of the log. So each way of
:data:`TRIED` is fitted to one half of the training part and simulated, from the drive alone, over the other half, and
the reverse; the way whose simulated position is off by least, both halves together, is taken. The hold-out takes no
part in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

import numpy as np

from leadscrew.identify.axis.delay import Delay
from leadscrew.identify.axis.inverse_dynamics import rows_of
from leadscrew.identify.axis.job import LEAST, Job
from leadscrew.identify.axis.linear_stage import PENDING, Line, line
from leadscrew.identify.axis.parameters import Estimates, estimates_of, parameters, units
from leadscrew.identify.axis.record import corner_of
from leadscrew.identify.axis.refine import WINDOW_S
from leadscrew.identify.axis.verdict import force_left
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.identify.axis.refine import Refined
    from leadscrew.logs import AxisLog


class Way(NamedTuple):
    """A way to refine."""

    mode: Literal["windows", "open", "none"]
    window_s: float | None
    error: float = float("nan")
    """Root mean square of the simulated position's prediction error, m or rad."""

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
    from leadscrew.identify.axis.replay import played
    from leadscrew.identify.axis.simulation import by_model, plant_values, simulate_open

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


BY_CLOCK = 5e-5
"""Share of a value that half of an interval is not below: clocks and converters of a log are no better."""
FOLLOWS = 2.0
"""Noises of the sensor: where windows leave no more there is nothing to be explained by a play."""
CLEARLY = 0.25
"""Of the squared error without a play that windows with it may leave."""
WORSE = 2.0
"""Times the force that the linear stage leaves: more, and a refinement went astray."""


def refined(
    job: Job, line: Line, symmetric: bool, delay: Delay | None, delay_s: float | None, refine: str,
    cascade: Cascade | None,
) -> tuple[Estimates, str]:  # fmt: skip
    """Estimates after the refinement, and what was done in a sentence."""
    estimates = estimates_of(line.fit)
    corner = corner_of(job.length, job.record.period)
    method = (
        f"inverse-dynamics least squares under a window of {1e3 * job.length * job.record.period:.3g} ms "
        f"(corner {corner:.3g} Hz, both sides alike)"
    )
    if not line.fit.keys:
        method = f"every parameter of the drive's force is given; the rest by {method}"
    if refine == "none":
        return estimates, _capital(method)
    way = Way("windows" if refine == "auto" else cast(Literal["open"], refine), None)
    late = delay_s if delay_s is not None else (delay.used * job.record.period if delay else 0.0)
    extra = ["delay_s"] if delay_s is None and (late > 0.0 or (delay is not None and delay.open)) else []
    if not estimates.keys and not extra:
        return estimates, _capital(method)
    task = _Task(job, _start(estimates, job, line, symmetric), [*estimates.keys, *extra], symmetric, late, cascade)
    try:
        found = task.run(way)
        if refine == "auto":
            again, way = _disturbed(task, found, line)
            if again is None:
                return estimates, _capital(method)
            found = again
    except DataError as problem:
        job.notes.append(
            f"The refinement by simulation was given up ({problem}); the values are those of the linear stage."
        )
        return estimates, _capital(method)
    if found.left_out:
        job.notes.append(
            f"{found.left_out} of {found.windows + found.left_out} windows were left out of the refinement: the model "
            "misses them by far more than the others (it sticks there where the axis slides, or the reverse)."
        )
    effect = estimates.effect | {"delay_s": 0.0}
    better = Estimates(
        found.keys, {k: found.values[k] for k in found.keys}, found.covariance,
        np.array([found.degrees[k] for k in found.keys]), found.condition, effect, estimates.rms_force,
        {k: _widened(found.values[k], *ends) for k, ends in found.interval.items()},
    )  # fmt: skip
    if not job.follows:
        job.doubtful = _apart(estimates, better, delay, job.record.period)
    if refine == "auto" and _worse(job, line, found.values, late):
        job.notes.append(
            "The refinement by simulation leaves more of the force than the linear stage and is not taken: "
            "the values are those of the linear stage."
        )
        return estimates, _capital(method)
    bound = [key for key in found.at_bound if key != "delay_s" or found.values[key] > 0.5 * job.record.period]
    if bound:
        job.notes.append(f"The refinement ended on a bound of {', '.join(bound)}: the best value may lie beyond.")
    if not found.converged:
        job.notes.append(f"The refinement stopped before it had settled ({found.message}).")
    length = "" if way.window_s is None else f" of {way.window_s:g} s"
    what = {"windows": f"{found.windows} windows{length} with free starts",
            "open": "the whole training part in open loop, its start speed free",
            "closed": "the training part in the known closed loop"}[way.mode]  # fmt: skip
    return better, _capital(f"{method}, then output-error refinement by simulation over {what} ({found.runs} runs)")


class _Task(NamedTuple):
    """What all refinements of one fit share."""

    job: Job
    start: dict[str, float]
    keys: list[str]
    symmetric: bool
    late: float
    cascade: Cascade | None

    def run(self, way: Way, start: Mapping[str, float] | None = None, keys: Sequence[str] = ()) -> Refined:
        """One refinement of the training part."""
        from leadscrew.identify.axis.refine import Mode, refine

        job = self.job
        return refine(
            job.stretch(0, job.cut), start or self.start, [*self.keys, *keys], self.symmetric, cast(Mode, way.mode),
            self.late, self.cascade, lambda what, done: job.say(what, 0.2 + 0.7 * done), window_s=way.window_s,
        )  # fmt: skip


def _disturbed(task: _Task, found: Refined, line: Line) -> tuple[Refined | None, Way]:
    """Where windows leave more than the sensor's noise: with a play, or by the way that cross-validation takes.

    None for the refinement where the linear stage alone is taken.
    """
    from leadscrew.identify.axis.refine import BEYOND

    job, usual = task.job, Way("windows", None)
    job.follows = found.rms <= FOLLOWS * job.record.noise
    if not job.follows:
        played = _with_play(task, found)
        if played is not None:
            return played, usual
    if found.rms <= BEYOND * job.record.noise:
        return found, usual
    ways = compared(job, line, task.start, task.keys, task.symmetric, task.late)
    job.notes += _said(ways, found.rms, job)
    if not ways or ways[0].name == TRIED[0].name:
        return found, usual
    return (None if ways[0].mode == "none" else task.run(ways[0])), ways[0]


def _with_play(task: _Task, found: Refined) -> Refined | None:
    """The refinement with a play between drive and table, where the table's dwell at reversals shows one and with it
    the windows leave clearly less.
    """
    from leadscrew.identify.axis.backlash import backlash_of

    job = task.job
    if "backlash" in job.given:
        return None
    values = {k: v for k, v in found.values.items() if k != "delay_s"}
    log = replace(job.stretch(0, job.cut), command=None)
    job.dwell = backlash_of(log, values, found.values.get("delay_s", task.late))
    if not job.dwell.low > 0.0:
        return None
    again = task.run(Way("windows", None), {**values, "backlash": job.dwell.value}, ["backlash"])
    return again if again.rms**2 < CLEARLY * found.rms**2 else None


def _said(ways: Sequence[Way], rms: float, job: Job) -> list[str]:
    """What was compared, for the notes."""
    if not ways:
        return []
    unit, factor = ("mm", 1e3) if job.log.unit.position == "m" else ("mrad", 1e3)
    errors = ", ".join(f"{way.name} {factor * way.error:.3g} {unit}" for way in ways)
    return [
        f"Forces act that the model does not know: within windows of the usual length {factor * rms:.2g} {unit} is "
        f"left, the sensor's noise is {factor * job.record.noise:.2g} {unit}. So refinements were compared by "
        f"halves of the training part, each simulated with the values of the other (rms): {errors}. The first "
        "was taken."
    ]


def _apart(line: Estimates, other: Estimates, delay: Delay | None, period: float) -> set[str]:
    """Of mass and delay, those whose intervals by least squares and by simulation do not meet."""
    ends = {"mass": (line, other)} if "mass" in line.values and "mass" in other.values else {}
    found = {k for k, (a, b) in ends.items() if a.ends(k)[0] > b.ends(k)[1] or b.ends(k)[0] > a.ends(k)[1]}
    if delay is not None and "delay_s" in other.values:
        low, high = other.ends("delay_s")
        if low > delay.high * period or high < delay.low * period:
            found.add("delay_s")
    return found


def _widened(value: float, low: float, high: float) -> tuple[float, float]:
    floor = BY_CLOCK * abs(value)
    return value - float(np.hypot(value - low, floor)), value + float(np.hypot(high - value, floor))


def _worse(job: Job, line: Line, values: Mapping[str, float], late: float) -> bool:
    """Whether values leave clearly more of the force than the line does."""
    record = job.training
    rows = rows_of(record, line.fit.terms, line.fit.length, line.fit.delay)
    if not rows.used.any():
        return False
    theta = np.array([line.fit.values[key] for key in line.fit.terms.sought])
    by_line = float(np.sqrt(np.mean((rows.force - rows.matrix @ theta)[rows.used] ** 2)))
    delay = values.get("delay_s", late) / record.period
    left, _ = force_left(record, values, line.fit.length, delay)
    return float(np.sqrt(np.nanmean(left**2))) > WORSE * by_line


def _capital(sentence: str) -> str:
    return sentence[0].upper() + sentence[1:] + "."


def _start(estimates: Estimates, job: Job, line: Line, symmetric: bool) -> dict[str, float]:
    """Values that a refinement starts from: fitted, given, and 0 for what was taken out."""
    log_units = units(job.log.unit.position, job.log.unit.drive, True)
    table = parameters(
        estimates, line.why, job.given, log_units, symmetric, job.both_ways,
        line.fit.terms.stribeck_speed is not None, line.fit.terms.known.get("offset", 0.0),
    )  # fmt: skip
    extra = {k: v for k, v in job.given.items() if k in ("force_per_drive", "backlash")}
    return {key: p.value for key, p in table.items()} | extra
