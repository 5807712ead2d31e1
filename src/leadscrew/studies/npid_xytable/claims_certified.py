"""Claims about moonshot M4: a proved nonlinear law against the best linear PID as robust and as quiet at rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.driven import driven
from leadscrew.analysis.stability.margins import margins
from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable import certified as m4
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said, word
from leadscrew.studies.npid_xytable.trials import Trial, trial

DRAWS = 6
"""Of phases a speed."""
LOADS_MV = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 50.0)
"""Constant loads, as a voltage at the input; the paper's NPID chatters from 4 to 16 mV."""
LEAST = 15.0
"""Percent: what M4 asks of every row."""
STILL_UM = 1e-3


@dataclass
class Rivals:
    """Trials of both laws, each made once."""

    loops: Loops

    def cut(self, **options: Any) -> tuple[Trial, Trial]:
        """The nonlinear law and the linear one under the same cuts."""
        return (
            trial(self.loops, m4.SPLIT, draws=DRAWS, **options),
            trial(self.loops, m4.LINEAR, draws=DRAWS, **options),
        )

    @cached_property
    def measured(self) -> tuple[Trial, Trial]:
        """1 mm at 0.7 Hz, with encoder, noise and spindle."""
        return self.cut()

    @cached_property
    def proofs(self) -> list[Certificate]:
        """The nominal plant, then the twelve of the box."""
        return [driven(m4.around_large(m4.SPLIT, plant), (0.0, 1.0)) for plant in ({}, *m4.box_plants())]

    @cached_property
    def swings_um(self) -> np.ndarray:
        """Peak to peak of the true error in the last half second, under every load on every plant of the box."""
        loop = self.loops.get(m4.SPLIT, "constant_load", metrics={})
        plants = m4.box_plants()
        loads = np.repeat(1e-3 * np.array(LOADS_MV), len(plants))
        varied: dict[str, Any] = {"disturbance.first.amplitude": loads}
        for key in plants[0]:
            varied[key] = np.tile([plant[key] for plant in plants], len(LOADS_MV))
        done = loop.batch(3.0, varied, record=("true_error",))
        late = 1e3 * done["true_error"][:, -1000:]
        return np.asarray(late.max(axis=1) - late.min(axis=1))


def reductions(trials: tuple[Trial, Trial]) -> np.ndarray:
    """By how many percent the rows of the first are below those of the second: means over the draws, 15 rows."""
    ours, theirs = trials
    return np.asarray(100.0 * (1.0 - ours.by_row() / theirs.by_row()))


def certified_claims(loops: Loops) -> list[Claim]:
    """What was compared, under which equal conditions, what is proved, and where the gain is small."""
    found = Rivals(loops)
    return [*_equal(found), *_proved(found), *_rows(found)]


def _equal(found: Rivals) -> list[Claim]:
    line = margins(m4.loop_of(m4.LINEAR))
    ours = [margins(m4.frozen(m4.SPLIT, share)) for share in m4.SHARES]
    quiet = [float(m4.rest_du_mv(found.loops, [block])[0]) for block in (m4.SPLIT, m4.LINEAR)]
    p = m4.LINEAR.params
    return [
        said("m4_ms", "future work", "M4: largest Ms of the nonlinear loop, linearised at any error",
             max(m.ms for m in ours), "1", line.ms, f"bounded by that of the linear PID, {line.ms:.4f}; {len(ours)} "
             "slopes of the law from rest to far out", sense="<=", kind="moonshot"),
        said("m4_rest_du", "future work", "M4: change of the output at rest, rms from sample to sample, nonlinear law",
             quiet[0], "mV", quiet[1], f"bounded by that of the linear PID, {quiet[1]:.4f} mV; encoder of 0.5 um, 0.1 "
             f"um of noise, mean square of {m4.OFFSETS} places within a count", sense="<=", kind="moonshot"),
        said("m4_gm", "future work", "M4: smallest gain margin of the nonlinear loop, linearised at any error",
             min(m.gm for m in ours), "1", 2.0, f"the linear PID has {line.gm:.2f}", sense=">=", kind="moonshot"),
        said("m4_linear", "future work", "M4: mean row of Table II under the best linear PID with this Ms and this "
             "change of output", float(m4.linear_rows(np.array([p.kp, p.ki, p.kd, p.filter_s])).mean()), "um", None,
             f"kp {p.kp:g}, ki {p.ki:g}, kd {p.kd:g}, filter {1e3 * p.filter_s:g} ms, sought over all four; Table I "
             "has 0.720 um at 12 times the noise", kind="report"),
    ]  # fmt: skip


def _proved(found: Rivals) -> list[Claim]:
    nominal, *box = found.proofs
    tightest = min(float(c.limit or 0.0) for c in found.proofs)
    all_proved = all(c.grade == "certificate" for c in box)
    swing = float(found.swings_um.max())
    return [
        said("m4_proof", "future work", "M4: whether the nonlinear law is proved under every command and load, L*",
             word(nominal.grade == "certificate"), "", "yes", nominal.statement, sense="yes/no", kind="moonshot"),
        said("m4_proof_box", "future work", "M4: the same on all twelve plants of the robustness box",
             word(all_proved), "", "yes", f"inequalities verified in exact arithmetic; slopes up to "
             f"{tightest:.3g} are proved on the tightest plant, the law has 1: so no constant load makes a limit cycle "
             "on any of them", sense="yes/no", kind="moonshot"),
        said("m4_loads", "future work", "M4: largest swing that is left 2.5 s after a constant load was put on",
             swing, "um", STILL_UM, f"loads of {LOADS_MV[0]:g} to {LOADS_MV[-1]:g} mV on the twelve plants, simulated",
             sense="<=", kind="moonshot"),
    ]  # fmt: skip


def _rows(found: Rivals) -> list[Claim]:
    rows = reductions(found.measured)
    ours, theirs = found.measured
    free, still, calm = (
        reductions(found.cut(**options)) for options in ({"spindle": False}, {"amplitude_mm": 0.0},
                                                         {"amplitude_mm": 0.0, "spindle": False})
    )  # fmt: skip
    return [
        said("m4_rows", "future work", "M4: by how much the nonlinear law is below the best linear PID, the smallest "
             "of the fifteen rows of Table II", float(rows.min()), "%", LEAST, f"mean {rows.mean():.1f} %, largest "
             f"{rows.max():.1f} %; 1 mm at 0.7 Hz, {DRAWS} draws of phases a speed, 0.5 um encoder with 0.1 um of "
             "noise, spindle lines of 1 and 2 mV", sense=">=", kind="moonshot"),
        said("m4_rms", "future work", "M4: rms error of the same runs, in parts of the linear PID's",
             float(ours.rms.mean() / theirs.rms.mean()), "1", None,
             f"{ours.rms.mean():.3f} um against {theirs.rms.mean():.3f} um", kind="report"),
        said("m4_rows_disturbed", "future work", "M4: the same without the motion: smallest of the fifteen rows",
             float(still.min()), "%", LEAST, f"mean {still.mean():.1f} %", sense=">=", kind="moonshot"),
        said("m4_rows_no_spindle", "future work", "M4: the same with the motion but without the spindle's lines: "
             "smallest of the fifteen rows", float(free.min()), "%", LEAST, f"mean {free.mean():.1f} %; the law works "
             "by the size of the error, and the spindle's lines are most of it", sense=">=", kind="moonshot"),
        said("m4_rows_calm", "future work", "M4: with neither: smallest of the fifteen rows", float(calm.min()), "%",
             None, f"mean {calm.mean():.1f} %; errors that hardly leave a count of the encoder stay on the quiet path",
             kind="report"),
        said("m4_moving_du", "future work", "M4: change of the output in the runs of the first row, nonlinear law",
             float(ours.chatter.mean()), "mV", None, f"the linear PID has {theirs.chatter.mean():.2f} mV: what is "
             "gained under load is paid for with noise there, none at rest", kind="report"),
    ]  # fmt: skip
