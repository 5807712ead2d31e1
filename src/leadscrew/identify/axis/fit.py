"""``identify axis``: from a log to a model of the axis, with intervals, and judged on validation data.

1. The log is cut in time: the first part is estimation data, the rest (half by default) validation data.
2. Linear stage: delay (:mod:`delay`), then inverse-dynamics least squares (:mod:`inverse_dynamics`) of four models of
   friction; the simplest that cross-validation inside the training part does not speak against (:mod:`linear_stage`).
3. Refinement by simulation of the plant itself over windows of the training part (:mod:`refine`); where these leave far
   more than the sensor's noise, by what serves best between halves of the training part (:mod:`simulation_stage`).
4. Bristles and a play, where the log shows them (:mod:`static_friction`).
5. The model is simulated over both parts from their measured first state and compared (:mod:`verdict`).

Parameters and every choice come from the training part alone: the hold-out is looked at once, to judge the model that
is handed on. With ``holdout=0`` everything trains.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from leadscrew.identify.axis import advice as words
from leadscrew.identify.axis.delay import Delay, find_delay
from leadscrew.identify.axis.inverse_dynamics import Terms
from leadscrew.identify.axis.job import Job, Progress, prepared, ways
from leadscrew.identify.axis.linear_stage import Candidate, Line, Model, Setting, choose, fitted, gauge_of, models
from leadscrew.identify.axis.parameters import Estimates, delay_parameter, parameters, terms_known, units
from leadscrew.identify.axis.record import corner_of
from leadscrew.identify.axis.result import AxisFit, Judged
from leadscrew.identify.axis.simulation_stage import refined
from leadscrew.identify.axis.static_friction import at_rest, bends, play
from leadscrew.identify.axis.verdict import all_judged, bins, cascade_left, extent, faults, sentence
from leadscrew.identify.estimation import Parameter
from leadscrew.identify.estimation import given as given_parameter
from leadscrew.kernel.one_thread import one_thread

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog

COULOMB = "friction.forward.coulomb"
Form = Literal["coulomb", "stribeck", "lugre"]
TRADES = "trades with the delay, which is not identifiable: give one of the two, or let the axis accelerate harder"
LAG = (
    "least squares and simulation contradict one another about it: a delay does not explain how the drive acts; a "
    "current loop with a lag, a filter or a flexible coupling would look like this, and the model has none of them"
)
SETTLED = 0.05
"""Change of the delay, in periods, after which the models are compared once more."""


@one_thread()
def identify_axis(
    log: AxisLog,
    *,
    symmetric: bool | None = None,
    model: str = "auto",
    holdout: float = 0.5,
    delay: float | None = None,
    given: Mapping[str, float] | None = None,
    refine: str = "auto",
    cascade: Cascade | None = None,
    progress: Progress | None = None,
) -> AxisFit:
    """A model of the axis that a log shows.

    Args:
        log: drive and position, evenly sampled; is not changed.
        symmetric: friction alike both ways, or by direction; decided by cross-validation unless given.
        model: ``coulomb``, ``stribeck``, ``lugre``, or ``auto``: decided by cross-validation.
        holdout: share of the log, at its end, that is validation data, 0 to 0.8.
        delay: s, from a logged drive to its act; found unless given.
        given: values that are known, by key of :obj:`leadscrew.plants.servo_axis`; they are not fitted.
        refine: ``none``: the linear stage alone; ``windows`` (``auto``), ``open``, ``closed``: see
            :mod:`leadscrew.identify.axis.refine`.
        cascade: the loop that was active; the closed loop is then judged too.
        progress: gets what happens and the fraction done.

    Raises:
        ValueRefused, NameUnknown: an option or a given value that cannot be.
        DataError: the mass is not identifiable, the log moves too little, or its columns do not belong together.
    """
    job, known_delay = prepared(log, holdout, delay, dict(given or {}), model, refine, cascade, progress)
    symmetric = ways(job, symmetric)
    found_delay, candidates, line = _linear(job, model, symmetric, known_delay)
    chosen = candidates[0]
    springs = bends(job.training, abs(line.fit.values.get(COULOMB, job.given.get(COULOMB, 0.0))))
    if springs and refine == "auto":
        refine = "none"
        job.notes.append(
            "The axis moves along with the drive while it stands, as on bristles or on a spring: a simulation in which "
            "it sticks does not refine it, and sliding alone counts."
        )
    estimates, method = refined(job, line, chosen.model.symmetric, found_delay, known_delay, refine, cascade)
    log_units = units(log.unit.position, log.unit.drive, _force_known(job))
    table = parameters(
        estimates, line.why, job.given, log_units, chosen.model.symmetric, job.both_ways,
        line.fit.terms.stribeck_speed is not None, line.fit.terms.known.get("offset", 0.0),
    )  # fmt: skip
    table["delay_s"] = delay_parameter(found_delay, log.period, estimates, known_delay)
    if found_delay and found_delay.open and not table["delay_s"].identifiable and table["mass"].how == "fitted":
        table["mass"] = table["mass"]._replace(identifiable=False, note=TRADES)
    for key in job.doubtful:
        table[key] = table[key]._replace(identifiable=False, note=LAG)
    if "force_per_drive" in job.given:
        table["force_per_drive"] = given_parameter(job.given["force_per_drive"], log_units["force_per_drive"])
    rest = at_rest(job, model, springs, table, log_units)
    table |= rest.found
    table["backlash"] = play(job, table, log_units["backlash"], estimates, cascade)
    job.notes += rest.notes
    if not rest.lugre:
        job.notes += _lacks(job, table, log_units["offset"])
    job.say("simulation", 0.95)
    stretches = all_judged(job, table, cascade)
    form = "lugre" if rest.lugre else "stribeck" if line.fit.terms.stribeck_speed is not None else "coulomb"
    return _result(job, table, estimates, candidates, stretches, method, form, cascade_left(job, cascade))


def _linear(
    job: Job, model: str, symmetric: bool | None, delay_s: float | None
) -> tuple[Delay | None, list[Candidate], Line]:
    """Delay, candidates with the chosen one first, and its line on all that trains."""
    job.say("linear stage", 0.0)
    known = terms_known(job.given)
    without = frozenset() if job.both_ways or "offset" in known else frozenset({"offset"})
    corner, tried = corner_of(job.length, job.record.period), models(model, symmetric)
    setting = Setting(corner, 0.0, known, without)
    training, found = job.training, None
    if delay_s is None:
        found = find_delay(training, _widest(tried[-1], setting), corner)
    setting = setting._replace(delay=found.used if found else delay_s / job.record.period if delay_s else 0.0)
    job.say("linear stage", 0.1)
    if job.both_ways and "offset" not in known and any(not m.symmetric for m in tried):
        setting = setting._replace(gauge=gauge_of(training, setting))
    candidates = choose(training, tried, setting)
    if found:
        # the delay once more, with the friction that was chosen
        assert candidates[0].line is not None
        again = find_delay(training, candidates[0].line.fit.terms, corner)
        changed = abs(again.used - setting.delay) > SETTLED
        found, setting = again, setting._replace(delay=again.used)
        if changed:
            candidates = choose(training, tried, setting)
        else:
            candidates[0].line = fitted(training, candidates[0].model, setting)
    assert candidates[0].line is not None
    return found, candidates, candidates[0].line


def _widest(model: Model, setting: Setting) -> Terms:
    """The richest model without a Stribeck term."""
    return Terms(model.symmetric, None, setting.known, setting.without)


def _force_known(job: Job) -> bool:
    return "force_per_drive" in job.given or job.log.unit.drive in ("N", "N m")


def _result(
    job: Job, table: dict[str, Parameter], estimates: Estimates, candidates: list[Candidate],
    stretches: list[Judged], method: str, form: str, cascade_left_percent: float | None,
) -> AxisFit:  # fmt: skip
    chosen, record, log = candidates[0], job.record, job.log
    training = next((j for j in stretches if j.what == "training"), None)
    left = training.force_percent if training else float("nan")
    size = extent(record, job.length)
    worthless = faults(stretches)
    notes = worthless + [f.sentence for f in log.findings] + job.notes + _remarks(table, estimates, chosen)
    share = 100.0 * (1.0 - job.cut / len(record.position))
    method += (
        f" Parameters from the first {100.0 - share:.0f} % of the log." if share else " Parameters from all of the log."
    )
    return AxisFit(
        source=log.source, model=cast(Form, form), symmetric=chosen.model.symmetric or form == "lugre",
        position_unit=log.unit.position, drive_unit=log.unit.drive, period=log.period, parameters=table,
        judged=stretches, condition=estimates.condition, correlation=estimates.correlation(), method=method,
        encoder_step=record.count, noise=record.noise, top_drive=float(np.max(np.abs(log.drive))),
        faults=worthless, notes=notes,
        advice=words.advice(table, size["top_speed"], log.unit.position, job.both_ways, left),
        missing=words.missing(table), compared=[c.as_dict() for c in candidates],
        cascade_left_percent=cascade_left_percent, **size,
    )  # fmt: skip


def _lacks(job: Job, table: Mapping[str, Parameter], force_unit: str) -> list[str]:
    """Where the form of friction does not fit the training part."""
    values = {key: p.value for key, p in table.items()}
    found = bins(job.training, values, job.length, values["delay_s"] / job.record.period)
    said = sentence(found, job.log.unit.position, force_unit)
    return [said] if said else []


def _remarks(table: Mapping[str, Parameter], estimates: Estimates, chosen: Candidate) -> list[str]:
    notes = []
    offset = table["offset"]
    if chosen.model.symmetric and offset.how == "fitted":
        notes.append(
            "A constant force and Coulomb friction that differs by direction act alike in any log: what differs is "
            f"counted as the offset, {offset.value:.3g} {offset.unit}."
        )
    if estimates.condition > 100.0:
        notes.append(f"The condition number is {estimates.condition:.3g}: some parameters trade with one another.")
    return notes
