"""What an axis does at rest and at its reversals: bristles before sliding, and a play. Added where the log shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.identify.axis.intervals import Estimates, fixed, given, parameter
from leadscrew.identify.axis.inverse_dynamics import stretches
from leadscrew.identify.axis.job import Job
from leadscrew.identify.axis.record import Record
from leadscrew.identify.axis.result import Parameter
from leadscrew.identify.axis.terms import SIDES

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade

SHARE = 0.5
"""Of Coulomb friction that the drive must change by while the axis stands, for bristles to be looked for."""
BENDS = 20.0
"""Noises of the position that the axis must move by, along with the drive, while it stands."""
ALONG = 0.9
"""Correlation of that motion with the drive."""
OFF = 0.01
"""Share of a value that half of its interval is not below: standard errors of that fit are lower bounds."""
NO_CREEP = "equal to Coulomb friction: the log does not tell it; it takes slips under a drive that creeps up"
FOLLOWS = "the simulated axis follows its reversals as well without it"
MOTORS = "; if the position is the motor's, that says nothing of the table: taken as 0"
CLEARLY = 0.25
"""Of the squared error without a play that a simulation with it may leave."""
LEAST = 20
"""Samples of such a stand-still."""


class AtRest(NamedTuple):
    """Parameters to add or replace, and sentences."""

    found: dict[str, Parameter]
    notes: list[str]
    lugre: bool


def bends(record: Record, coulomb: float) -> bool:
    """Whether the axis moves along with the drive while it stands, as bristles do and a Coulomb friction does not."""
    s = record.samples
    for first, last in stretches(s.slow):
        force, place = record.force[first + 1 : last + 1], record.position[first + 1 : last + 1]
        if last - first < LEAST or np.ptp(force) < SHARE * coulomb or np.ptp(place) < BENDS * record.noise:
            continue
        if np.corrcoef(force, place)[0, 1] > ALONG:
            return True
    return False


def at_rest(job: Job, model: str, springs: bool, table: Mapping[str, Parameter], units: Mapping[str, str]) -> AtRest:
    """LuGre where it is asked for, or the log shows bristles (``springs``) and no other model is asked for."""
    if model in ("coulomb", "stribeck") or (model == "auto" and not springs):
        return AtRest({}, [], False)
    from leadscrew.identify.axis.presliding import presliding

    values = {key: table[key].value for key in ("mass", "force_per_drive") if key in table}
    told = presliding(job.stretch(0, job.cut), values, table["delay_s"].value, lambda what, done: job.say(what, 0.9))
    if not told.found:
        return AtRest({}, [told.why_not], False)
    found = {}
    for key, value in told.values.items():
        if key in ("mass", "offset") or key in job.given:
            continue
        half = float(np.hypot(value - told.interval[key][0], OFF * value))
        for side in SIDES if ".forward." in key else ("",):
            name = key.replace("forward", side) if side else key
            if told.told[key]:
                found[name] = Parameter(value, units[name], value - half, value + half, "fitted", True)
            elif key.endswith(".static"):
                found[name] = fixed(told.values["friction.forward.coulomb"], units[name], NO_CREEP)
    notes = ["Bristles are fitted alike both ways, and so is the friction beside them."]
    if not told.consistent:
        notes.append("Around stand-stills the residuals are not the noise of the log: this is not quite LuGre.")
    return AtRest(found, notes, True)


def play(
    job: Job, table: Mapping[str, Parameter], unit: str, estimates: Estimates, cascade: Cascade | None = None
) -> Parameter:
    """The lost motion: given, refined with the others, found in the drive's law, or 0 with the reason."""
    from leadscrew.identify.axis.backlash import DWELL, backlash_of

    if "backlash" in job.given:
        return given(job.given["backlash"], unit)
    if "backlash" in estimates.values:
        return parameter(estimates, "backlash", unit, DWELL)
    values = {key: p.value for key, p in table.items() if key != "delay_s"}
    found = backlash_of(job.stretch(0, job.cut), cascade=cascade)
    if found.told and found.low > 0.0:
        if _borne_out(job, values, table["delay_s"].value, found.value):
            return Parameter(found.value, unit, found.low, found.high, "fitted", True, found.note)
        return fixed(
            0.0, unit, f"the drive's law gives {found.value:.3g}, but simulated with it the axis comes no nearer"
        )
    if job.follows:
        return fixed(0.0, unit, FOLLOWS + MOTORS)
    if job.dwell is not None and np.isfinite(job.dwell.high):
        return fixed(0.0, unit, f"reversals do not tell one, {job.dwell.high:.2g} {unit} at most" + MOTORS)
    return fixed(0.0, unit, found.note)


def _borne_out(job: Job, values: Mapping[str, float], late: float, value: float) -> bool:
    """Whether the simulated training part comes nearer to the log with this play than without."""
    from leadscrew.identify.axis.stretches import simulated

    parts = [("training", 0, job.cut)]
    without, with_it = (simulated(job, {**values, "backlash": b}, late, parts, None)[0] for b in (0.0, value))
    if without is None or with_it is None:
        return False
    measured = job.training.position
    return bool(np.mean((with_it - measured) ** 2) < CLEARLY * np.mean((without - measured) ** 2))
