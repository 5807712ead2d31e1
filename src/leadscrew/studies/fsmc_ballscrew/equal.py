"""Seven laws under equal conditions: each tuned by the same search, judged on stages that no search saw.

Search: ``leadscrew tune`` by CMA-ES, the same for all laws of a case: 200 settings on six stages (80 on three
with a delay or the axial mode), seed 0, every parameter from the middle of a range of two decades and a half or more.
Coulomb friction within 20 %, static friction 7.5 to 11.2 N·m, inertia within 20 %; with the axial mode the table's
mass, 50 to 75 kg. Goal: the largest error after four tenths of a sine from rest; constraint: in nine of ten runs the
torque differs by less than 0.6 N·m RMS from sample to sample. All read the same scale at 4 kHz, and f̂, if any, is that
of Table 2, in four pieces a period. The commands stand in ``tuned/*.toml``.

PD with the observer and fixed gains is a PID: with ``T = J y_r'' + f̂ + d - kp e - kd e'`` and ``d = L (q - J v)``,
``q' = T - f̂ - d``, it has ``kp + L kd``, the integral gain ``L kp`` and ``kd + L J``. The integral law inside its layer
is one, with ``r = layer_rate`` and ``kp = J (3 lam^2 + 2 lam r)``, ``ki = J lam^2 (lam + r)``, ``kd = J (3 lam + r)``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leadscrew import controller_file
from leadscrew.experiment import Experiment
from leadscrew.studies.fsmc_ballscrew.controllers import EQUAL, FOLDER, ON_A_DRIVE, named
from leadscrew.studies.lab import Lab, measure

LAWS = {
    "smc": "SMC",
    "csmc": "CSMC",
    "fsmc": "FSMC",
    "smc_integral": "SMC, integral surface",
    "pid_friction": "PID with f̂",
    "pd_dob": "scheduled PD, observer and f̂",
    "pid_bare": "PID without f̂",
}
"""By the name of the file in ``tuned``."""
FRICTION = {"plant.friction.coulomb": "5:7.5", "plant.friction.static": "7.5:11.2"}
RIGID = FRICTION | {"plant.inertia": "0.000296:0.000444"}


class Case(NamedTuple):
    """A stage to tune and to compare on; ``substeps`` are the judge's: of 50 µs, while the search takes 125 µs."""

    words: str
    scenarios: tuple[str, ...]
    over: dict[str, str]
    changes: dict[str, Any]
    laws: tuple[str, ...]
    substeps: int | None


CASES = {
    "rigid": Case("rigid stage", ("rest_slow", "rest_wide", "rest_fast"), RIGID, {}, EQUAL, 5),
    "delay": Case("one sample of delay", ("rest_wide", "rest_fast"), RIGID, {"scenario.delay": True}, ON_A_DRIVE, 5),
    "mode": Case(
        "the axial mode", ("rest_fast",), FRICTION | {"plant.table_mass": "50:75"}, {"scenario.axial_mode": True},
        ON_A_DRIVE, None,
    ),
}  # fmt: skip
STAGES, SEED = 8, 7
"""Of the judge; the searches have seed 0."""


class Judged(NamedTuple):
    """A law on stages that no search saw: largest errors of the sines, um, RMS difference of the torque, N m."""

    mean_um: float
    less_from: float | None
    """95 % interval of the mean error less that of FSMC on the same stages, um; none for FSMC."""
    less_to: float | None
    worst_um: float
    chatter: float
    lost: int
    """Stages on which it leaves the track."""


def searched_um(law: str) -> float:
    """Largest error on the 24 stages that the search held back, by the search's own steps, um: from its file."""
    return 1e3 * float(controller_file.read(FOLDER / f"{law}.toml").tuning["held_out"]["worst:max_error"])


@measure
def judged(lab: Lab, case: str) -> dict[str, Judged]:
    """All laws of a case on the same stages, the best first."""
    from leadscrew.tune.compare import compare
    from leadscrew.tune.job import Job
    from leadscrew.tune.statistics import paired, per_plant, plain

    at = CASES[case]
    job = Job(Experiment(lab.study.name, changes=at.changes, substeps=at.substeps), at.scenarios)
    names = {f"tuned.{named(law, case)}": law for law in at.laws}
    found = compare(
        job, list(names), ["max_error"], ["p90:chatter<=0.6"], over=at.over, unseen=STAGES, seed=SEED,
    )  # fmt: skip
    errors = {names[r.name]: 1e3 * per_plant(found.goals[0], r.samples) for r in found.results}
    chatter = {names[r.name]: r.standings[plain(found.constraints[0])].mean.value for r in found.results}
    fuzzy, kept = errors["fsmc"], {}
    for law, e in sorted(errors.items(), key=lambda item: float(np.nanmean(item[1]))):
        less = paired(law, "fsmc", e, fuzzy, np.isnan(e), np.isnan(fuzzy), SEED, law == "fsmc").difference
        low, high = (None, None) if law == "fsmc" else (less.low, less.high)
        kept[law] = Judged(float(np.nanmean(e)), low, high, float(np.nanmax(e)), chatter[law], int(np.isnan(e).sum()))
    return kept
