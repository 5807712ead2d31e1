"""What an axis does at rest and at its reversals: bristles before sliding, and a play. Added where the log shows it.

Pre-sliding (LuGre) of an axis from its log, where the log excites it: :mod:`leadscrew.identify.friction` in m and N.

The fit of friction is made for rad and N m. Here its "radian" is 1 mm of a linear axis: with ``L`` = 1 mm

    torque = L force      angle = x / L      sigma_0 = stiffness / L^2      F_C = torque / L      v_s = L speed

For a rotary axis ``L`` is 1. What it needs of a log says :mod:`leadscrew.identify.friction_record`: slow reversals, or
a drive that creeps up to a slip, sampled every 2 ms or faster.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.identify.axis.inverse_dynamics import SIDES, stretches
from leadscrew.identify.axis.job import Job
from leadscrew.identify.axis.parameters import Estimates
from leadscrew.identify.axis.record import Record
from leadscrew.identify.estimation import Parameter, fixed, given, quantile
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog


SHARE = 0.5
"""Of Coulomb friction that the drive must change by while the axis stands, for bristles to be looked for."""
BENDS = 20.0
"""Noises of the position that the axis must move by, along with the drive, while it stands."""
ALONG = 0.9
"""Correlation of that motion with the drive."""
OFF = 0.01
"""Share of a value that half of its interval is not below: standard errors of that fit are lower bounds."""
NO_CREEP = "equal to Coulomb friction: not identifiable from the log; it takes slips under a drive that creeps up"
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

    values = {key: table[key].value for key in ("mass", "force_per_drive") if key in table}
    bristles = presliding(
        job.stretch(0, job.cut), values, table["delay_s"].value, lambda what, done: job.say(what, 0.9)
    )
    if bristles.why_not:
        return AtRest({}, [bristles.why_not], False)
    found = {}
    for key, p in bristles.parameters.items():
        if key in ("mass", "offset") or key in job.given:
            continue
        half = float(np.hypot(p.half, OFF * p.value))
        for side in SIDES if ".forward." in key else ("",):
            name = key.replace("forward", side) if side else key
            if p.identifiable:
                found[name] = p._replace(unit=units[name], low=p.value - half, high=p.value + half)
            elif key.endswith(".static"):
                found[name] = fixed(bristles.parameters["friction.forward.coulomb"].value, units[name], NO_CREEP)
    notes = ["Bristles are fitted alike both ways, and so is the friction beside them."]
    if not bristles.consistent:
        notes.append("Around standstills the residuals are not the noise of the log: this is not quite LuGre.")
    return AtRest(found, notes, True)


def play(
    job: Job, table: Mapping[str, Parameter], unit: str, estimates: Estimates, cascade: Cascade | None = None
) -> Parameter:
    """The lost motion: given, refined with the others, found in the drive's law, or 0 with the reason."""
    from leadscrew.identify.axis.backlash import DWELL, backlash_of

    if "backlash" in job.given:
        return given(job.given["backlash"], unit)
    if "backlash" in estimates.values:
        return estimates.parameter("backlash", unit, DWELL)
    values = {key: p.value for key, p in table.items() if key != "delay_s"}
    found = backlash_of(job.stretch(0, job.cut), cascade=cascade)
    if found.identifiable and found.low > 0.0:
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
    from leadscrew.identify.axis.verdict import simulated

    parts = [("training", 0, job.cut)]
    without, with_it = (simulated(job, {**values, "backlash": b}, late, parts, None)[0] for b in (0.0, value))
    if without is None or with_it is None:
        return False
    measured = job.training.position
    return bool(np.mean((with_it - measured) ** 2) < CLEARLY * np.mean((without - measured) ** 2))


TURN = 1e-3
"""m of a linear axis that count as a radian."""


class Presliding(NamedTuple):
    """LuGre by key of the plant, or why it is not identifiable."""

    parameters: dict[str, Parameter]
    """``mass``, ``offset``, ``friction.stiffness``, ``friction.damping``, ``friction.forward.*``: alike both ways."""
    consistent: bool
    """Whether the residuals are white and no larger than the noise: if not, this is no LuGre axis."""
    rms: float
    """Of position around stand-stills, m or rad."""
    why_not: str = ""
    """A sentence; empty where stiffness and damping are identifiable."""


def presliding(
    log: AxisLog,
    values: Mapping[str, float],
    delay_s: float = 0.0,
    progress: Callable[[str, float], None] | None = None,
) -> Presliding:
    """LuGre friction of the axis, alike both ways, from the stand-stills of its log.

    Args:
        log: is not changed.
        values: the model so far; of it ``force_per_drive`` and ``mass`` count.
        delay_s: from a logged drive to its act; whole periods of it are taken.
        progress: gets what happens and the fraction done.
    """
    from leadscrew.identify.friction import fit_friction

    turn = TURN if log.unit.position == "m" else 1.0
    force = log.drive * values.get("force_per_drive", log.force_per_drive or 1.0)
    mass = values.get("mass")
    try:
        fit = fit_friction(
            log.time, force * turn, log.position / turn, inertia=None if mass is None else mass * turn * turn,
            delay=round(delay_s / log.period), progress=progress,
        )  # fmt: skip
    except DataError as error:
        text = str(error)
        return Presliding({}, False, math.nan, f"Pre-sliding is not identifiable: {text}.")
    scale = {"stiffness": turn**-2, "damping": turn**-2, "viscous": turn**-2, "inertia": turn**-2,
             "coulomb": 1 / turn, "static": 1 / turn, "offset": 1 / turn, "stribeck_speed": turn}  # fmt: skip
    found = {}
    for name, p in fit.parameters.items():
        value, low, high = (scale[name] * x for x in (p.value, p.low, p.high))
        found[_key(name)] = p._replace(value=value, low=low, high=high)
    for name, value in (("inertia", fit.inertia), ("offset", fit.offset)):
        half = quantile() * fit.standard_error[name]
        found[_key(name)] = Parameter(
            scale[name] * value, "", scale[name] * (value - half), scale[name] * (value + half)
        )
    return Presliding(found, fit.consistent, fit.rms * turn)


def _key(name: str) -> str:
    if name in ("stiffness", "damping"):
        return f"friction.{name}"
    return {"inertia": "mass", "offset": "offset"}.get(name, f"friction.forward.{name}")
