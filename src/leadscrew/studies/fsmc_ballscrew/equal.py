"""Seven laws under equal conditions: each tuned by the same search, judged on stages that no search saw.

Search: ``leadscrew tune`` by CMA-ES, the same for all laws of a case: 200 settings on six stages (80 on three
with a delay or the axial mode), seed 0, every parameter from the middle of a range of two decades and a half or more.
Coulomb friction within 20 %, static friction 7.5 to 11.2 N·m, inertia within 20 %; with the axial mode the table's
mass, 50 to 75 kg. Goal: the largest error after four tenths of a sine from rest; constraint: in nine of ten runs the
torque differs by less than 0.6 N·m RMS from sample to sample. All read the same scale at 4 kHz, and f̂, if any, is that
of Table 2, in four pieces a period. The commands stand in ``tuned/*.toml``.

PD with the observer and fixed gains is a PID: with ``T = J y_r'' + f̂ + d - kp e - kd e'`` and ``d = L (q - J v)``,
``q' = T - f̂ - d``, it has ``kp + L kd``, the integral gain ``L kp`` and ``kd + L J``. The integral law inside its layer
is one as well, see :func:`leadscrew.studies.fsmc_ballscrew.laws.integral_pid`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from leadscrew import controller_file
from leadscrew.experiment import Experiment
from leadscrew.studies.fsmc_ballscrew.controllers import EQUAL, FOLDER, ON_A_DRIVE, named
from leadscrew.studies.lab import Lab, measure
from leadscrew.tune.compare import compare
from leadscrew.tune.compare_result import Result
from leadscrew.tune.compare_statistics import Interval, paired, per_plant, plain
from leadscrew.tune.job import Job

LAWS = {
    "smc": "SMC",
    "csmc": "CSMC",
    "fsmc": "FSMC",
    "smc_integral": "SMC, integral surface",
    "pid_friction": "PID with f̂",
    "pd_dob": "scheduled PD, observer and f̂",
    "pid_bare": "PID without f̂",
    "fsmc_before": "FSMC as ours.fsmc_4khz",
}
"""By the name of the file in ``tuned``; the last one is not tuned here."""
GROUPS = {law: "no friction model" if law == "pid_bare" else "f̂ of Table 2" for law in LAWS}
BEFORE = "fsmc_before"
"""The setting of the fuzzy law that the study had before, found with more effort and another goal."""
FRICTION = {"plant.friction.coulomb": "5:7.5", "plant.friction.static": "7.5:11.2"}


class Case(NamedTuple):
    """A stage to tune and to compare on."""

    words: str
    scenarios: tuple[str, ...]
    over: dict[str, str]
    changes: dict[str, Any]
    laws: tuple[str, ...]
    plants: int
    """To judge on."""
    substeps: int | None
    """Of the judge: the search steps the rigid stage by 125 µs, the judge by 50 µs."""


RIGID = FRICTION | {"plant.inertia": "0.000296:0.000444"}
CASES = {
    "rigid": Case("rigid stage", ("rest_slow", "rest_wide", "rest_fast"), RIGID, {}, EQUAL, 16, 5),
    "delay": Case(
        "one sample of delay", ("rest_wide", "rest_fast"), RIGID, {"scenario.delay": True}, ON_A_DRIVE, 16, 5
    ),
    "mode": Case(
        "the axial mode", ("rest_fast",), FRICTION | {"plant.table_mass": "50:75"}, {"scenario.axial_mode": True},
        ON_A_DRIVE, 16, None,
    ),
}  # fmt: skip
UNIT_UM = 1e3
SEED = 7
"""Draws the stages of the judge; the searches have seed 0."""


class Judged(NamedTuple):
    """A law on stages that no search saw."""

    mean_um: float
    """Largest error of the sines, mean over the stages."""
    worst_um: float
    chatter: float
    """RMS difference of the torque from sample to sample, largest of the sines, mean over the stages, N m."""
    less: Interval
    """Mean largest error less that of FSMC, by the same stages, um."""
    failed: int
    """Stages on which it leaves the track."""


def searched_um(law: str, case: str = "rigid") -> float:
    """Largest error on the 24 stages that the search held back, by the search's own steps, um: from its file."""
    file = controller_file.read(FOLDER / f"{named(law, case)}.toml")
    return UNIT_UM * float(file.tuning["held_out"]["worst:max_error"])


NOMINAL = {"sine_slow": (2.6, 1.0), "sine_wide": (2.6, 1.0), "sine_fast": (1.1, 0.4)}
"""Length of a run over one reversal, and from when on it counts, s."""


@measure
def nominal_um(lab: Lab, name: str, scenario: str) -> float:
    """Largest error on the stage of Table 2, in motion and integrated by RODAS, um."""
    seconds, first = NOMINAL[scenario]
    run = lab.loop(name, scenario).run(seconds, record=("true_error",))
    return math.inf if run.diverged else UNIT_UM * float(np.abs(run["true_error"][run["time"] >= first]).max())


@measure
def judged(lab: Lab, case: str) -> dict[str, Judged]:
    """All laws of a case, on the same stages."""
    at = CASES[case]
    job = Job(Experiment(lab.study.name, changes=at.changes, substeps=at.substeps), at.scenarios)
    names = {f"tuned.{named(law, case)}": law for law in at.laws}
    if case == "rigid":
        names["ours.fsmc_4khz"] = BEFORE
    found = compare(
        job, list(names), ["max_error"], ["p90:chatter<=0.6"], over=at.over, unseen=at.plants, seed=SEED,
    )  # fmt: skip
    results = {names[r.name]: r for r in found.results}

    def errors(r: Result) -> np.ndarray:
        return UNIT_UM * per_plant(found.goals[0], r.samples)

    fuzzy, kept = results["fsmc"], {}
    for law, r in results.items():
        e, standing = errors(r), r.standings[plain(found.constraints[0])]
        lost = np.isnan(e)
        pair = paired(law, "fsmc", e, errors(fuzzy), lost, np.isnan(errors(fuzzy)), SEED, law == "fsmc")
        kept[law] = Judged(
            float(np.nanmean(e)), float(np.nanmax(e)), standing.mean.value, pair.difference, int(lost.sum())
        )
    return kept


def said(found: Mapping[str, Judged]) -> str:
    """What follows from a table of laws, in a sentence."""
    known = [law for law in found if law not in ("fsmc", "pid_bare", BEFORE)]
    best = min(known, key=lambda law: found[law].mean_um)
    fuzzy = found["fsmc"].mean_um

    def beside(law: str) -> str:
        r = found[law]
        word = "less" if r.less.high < 0.0 else "more" if r.less.low > 0.0 else "no difference shown"
        return f"{LAWS[law]} {r.worst_um:.2f} and {r.mean_um:.2f} µm ({word}: {r.less.low:+.2f} to {r.less.high:+.2f})"

    rest = [law for law in dict.fromkeys((best, "smc_integral", "pid_friction", "pid_bare", BEFORE)) if law in found]
    return (
        f"largest error of all and mean over the stages are {found['fsmc'].worst_um:.2f} and {fuzzy:.2f} µm (FSMC); "
        f"beside it, with the interval of the mean difference, {', '.join(map(beside, rest))}."
    )
