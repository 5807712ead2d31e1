"""All friction models of a measured friction force, fitted to its first part and judged on the rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.identify.friction_force.lugre_fit import fit_lugre
from leadscrew.identify.friction_force.map_fit import bins_of, fit_coulomb, fit_map, sliding_rows
from leadscrew.identify.friction_force.path_fit import fit_dahl, fit_slip
from leadscrew.identify.friction_force.record import LEAST, ForceRecord
from leadscrew.identify.friction_force.result import Bin, FrictionForceFit, Load, ModelFit
from leadscrew.identify.friction_force.task import STRIBECK_RATIO, VISCOUS_RATIO, Task, task_of
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.kernel.one_thread import one_thread

Progress = Callable[[str, float], None]
LOADS = ("auto", "force", "coefficient")
USUAL = (0.001, 3.0)
"""Coefficients of friction; outside of them a unit is likely to be wrong."""
SAMPLES_BEFORE_SLIDING = 3
"""Samples in the travel before sliding below which stiffness is told by hardly anything."""
NORMAL_CHANGES = 0.1
"""Change of the normal force while sliding, as a share of it, below which the log cannot say how friction scales."""


@one_thread()
def identify_friction_force(
    record: ForceRecord, *, holdout: float = 0.5, load: Literal["auto", "force", "coefficient"] = "auto",
    progress: Progress | None = None,
) -> FrictionForceFit:  # fmt: skip
    """Coulomb and viscous friction, Stribeck map, Dahl, LuGre and Maxwell slip of a measured friction force.

    Every model is fitted to the first samples and simulated over all of them, driven by the measured motion alone, so
    that no force of the hold-out is ever seen.

    Args:
        record: the log.
        holdout: share of the samples at the end that is not fitted, 0 to 0.8; 0 judges on the fitted samples.
        load: ``coefficient`` takes friction as a coefficient times the measured normal force, ``force`` does not;
            ``auto`` is the first where the normal force was logged, before anything is fitted. Both are reported.
        progress: told what happens and the fraction done.

    Raises:
        ValueRefused: a hold-out or a load that is none, or a coefficient without a normal force.
        DataError: too little of the motion lies in the training part.
    """
    if not 0.0 <= holdout <= 0.8:
        raise ValueRefused(f"holdout = {holdout!r}: allowed range is [0, 0.8]")
    if load not in LOADS:
        raise ValueRefused(f"load = {load!r}: allowed are {', '.join(LOADS)}")
    if load == "coefficient" and record.normal is None:
        raise ValueRefused("load = 'coefficient': the record has no normal force; name its column, or fit the force")
    last = len(record.time) - int(holdout * len(record.time))
    _check_training(record, last)
    wanted: Load = "coefficient" if load == "coefficient" or (load == "auto" and record.normal is not None) else "force"
    judged_force = record.force[last:] if last < len(record.time) else record.force
    amplitude = 0.5 * float(np.ptp(judged_force))
    if amplitude == 0.0:
        raise DataError(
            f"{record.source}: the force does not change in the part that is judged; choose another hold-out"
        )
    report = progress or (lambda what, done: None)
    task = task_of(record, wanted, last)
    models, rows, bins = _all(task, amplitude, lambda what, done: report(what, 0.8 * done))
    others: dict[str, ModelFit] = {}
    if record.normal is not None:
        other = task_of(record, "force" if wanted == "coefficient" else "coefficient", last)
        report(f"LuGre, {other.load}", 0.8)
        others = {m.name: m for m in (fit_coulomb(other, amplitude), fit_lugre(other, amplitude))}
    normal = 1.0 if record.normal is None else float(record.normal[rows if len(rows) else slice(last)].mean())
    fit = FrictionForceFit(record, wanted, models, others, bins, last, amplitude, normal, task.speeds)
    fit.notes.extend([f.sentence for f in record.findings] + _notes(fit, task, rows))
    fit.advice.extend(_advice(fit, task))
    return fit


def _all(task: Task, amplitude: float, report: Progress) -> tuple[dict[str, ModelFit], np.ndarray, list[Bin]]:
    found = [fit_coulomb(task, amplitude)]
    report("Maxwell slip", 0.0)
    slip, share = fit_slip(task, amplitude)
    rows = sliding_rows(task, share)
    if all((task.record.way[rows] == way).sum() >= 10 for way in (1.0, -1.0)):
        report("Stribeck map", 0.1)
        found.append(fit_map(task, rows, amplitude))
    report("LuGre", 0.2)
    lugre = fit_lugre(task, amplitude)
    report("Dahl", 0.7)
    found += [fit_dahl(task, lugre, amplitude), lugre, slip]
    return {m.name: m for m in found}, rows, bins_of(task, rows)


def _check_training(record: ForceRecord, last: int) -> None:
    if last < LEAST:
        raise DataError(f"{record.source}: {last} samples to fit; expected at least {LEAST}: choose a smaller hold-out")
    travel = record.travel[:last]
    if not (travel > 0.0).any() or not (travel < 0.0).any():
        raise DataError(
            f"{record.source}: the first {last} samples, which are fitted, move one way only; choose a smaller "
            "hold-out or another start"
        )


def _notes(fit: FrictionForceFit, task: Task, rows: np.ndarray) -> list[str]:
    notes = [f"{m.name}: {note}" for m in fit.models.values() for note in m.notes]
    r, f = task.record, fit.chosen.friction
    assert isinstance(f, TwoSidedLuGre)
    length = max(f.forward.coulomb, f.backward.coulomb) / f.stiffness
    moved = np.abs(r.travel[: task.last])
    usual = float(np.median(moved[moved > 0.0]))
    if 3.0 * length < SAMPLES_BEFORE_SLIDING * usual:
        notes.append(
            f"sliding begins after {3.0 * length:.2g} {r.unit}, and samples are {usual:.2g} {r.unit} apart: stiffness "
            "and damping of the bristles rest on little"
        )
    level = 0.5 * (f.forward.coulomb + f.backward.coulomb)
    if task.load == "coefficient" and not USUAL[0] < level < USUAL[1]:
        notes.append(
            f"a coefficient of friction of {level:.3g} lies outside {USUAL[0]:g} to {USUAL[1]:g}: look at the units of "
            "force and normal force"
        )
    if r.normal is not None and len(rows):
        change = float(np.ptp(r.normal[rows])) / abs(fit.normal_mean)
        if change < NORMAL_CHANGES:
            notes.append(
                f"the normal force changes by {100.0 * change:.2g} % while sliding in the fitted part: that friction "
                "scales with it is assumed, not told by what was fitted"
            )
    return notes


def _advice(fit: FrictionForceFit, task: Task) -> list[str]:
    said, unit = [], task.record.unit
    slow, fast = fit.speeds
    if task.ratio < VISCOUS_RATIO:
        said.append(f"strokes at other speeds (here {slow:.3g} to {fast:.3g} {unit}/s) tell viscous friction")
    if task.ratio < STRIBECK_RATIO:
        said.append("slow strokes, down to a hundredth of the fastest, tell static friction and Stribeck speed")
    damping = fit.chosen.parameters["friction.damping"]
    if not damping.told:
        said.append("quick reversals inside the travel before sliding tell the damping of the bristles")
    return said
