"""Claims about design: our procedure on L*, what binds, beside the paper's, and the law on top of a retuned PID.

M4, with its stricter rule of comparison, is in :mod:`leadscrew.studies.npid_xytable.claims_certified`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.stability.lmi import lmi_circle
from leadscrew.analysis.stability.margins import margins
from leadscrew.controllers.npid_slope import npid_slope
from leadscrew.design.npid import NpidDesign, design_npid
from leadscrew.design.npid_axis import Case, TableAxis, Work, strength_for
from leadscrew.design.npid_retune import Retuned, retuned
from leadscrew.design.npid_trial import Bench, Tried
from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, LINES_HZ, volts
from leadscrew.studies.npid_xytable.columns import PID_UM
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said, word
from leadscrew.studies.npid_xytable.trials import BOX

MS = 1.6
LEAST_MARGIN = 2.0
"""Gain margin that the steepest slope of the certified law leaves."""
ES_UM = 1.5
"""Where its slope is half-way; the smallest of those tried that a drive at rest does not hear."""
REPEATS = 6
"""Runs with other noise, whose mean counts."""
LOADS_UM = np.array([0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0])
LOAD_S = 4.0


def table_2_work() -> Work:
    """The motion under the force lines of Table II, at its three spindle speeds, through the encoder."""
    cases = tuple(Case(f"{rpm} 1/min", volts(um), rpm / 60.0) for rpm, um in PID_UM.items())
    return Work(cases, LINES_HZ, frequency_hz=BASE_HZ)


class Certified(NamedTuple):
    """A nonlinear law on the retuned PID, beside that PID."""

    pid: Retuned
    nyquist: float
    k: float
    ms: float
    base: Tried
    law: Tried
    plants: int
    """Plants of the box on which its slope sector is proved."""
    swing_um: float
    """Largest swing under constant loads on all plants of the box."""


@lru_cache(maxsize=2)
def designed(loops: Loops) -> NpidDesign:
    """Our procedure on L* with Table I."""
    return design_npid(TableAxis(), table_2_work())


@lru_cache(maxsize=2)
def certified(loops: Loops) -> Certified:
    """The best linear PID of Ms 1.6, and a slope-limited law on it with a gain margin of 2 where it is steepest."""
    axis, work = TableAxis(), table_2_work()
    pid = retuned(axis, LINES_HZ, MS)
    linear = axis.linear(pid.gains)
    nyquist = linear.gain_limit(1.0)
    k = nyquist / LEAST_MARGIN
    both = Bench(axis, work, "slope").tried(pid.gains, [1.0] * REPEATS + [k] * REPEATS, [ES_UM] * (2 * REPEATS))
    base, law = (Tried(*(v[i : i + REPEATS] for v in vars(both).values())) for i in (0, REPEATS))
    plants = [dict(zip(BOX, values, strict=True)) for values in zip(*BOX.values(), strict=True)]
    proved = sum(
        lmi_circle(
            TableAxis(p["plant.gain"], p["plant.damping"], dead_time_s=p["plant.dead_time_s"]).linear(pid.gains), 1.0, k
        ).grade
        == "certificate"
        for p in plants
    )
    many = {key: np.repeat(values, LOADS_UM.size) for key, values in BOX.items()}
    many["disturbance.first.amplitude"] = np.tile(1.32e-3 * LOADS_UM, len(plants))
    block = npid_slope(**pid.gains.as_dict(), k=k, es_um=ES_UM)
    run = loops.get(block, "constant_load").batch(LOAD_S, many, record="true_error")
    swing = float(np.ptp(1e3 * run["true_error"][:, -1000:], axis=1).max())
    return Certified(pid, nyquist, k, margins(linear).ms, base, law, proved, swing)


def design_claims(loops: Loops) -> list[Claim]:
    """Digest section 8: 8.1 to 8.3, 8.5 and 8.6."""
    return [*_ours(loops), *_beside(loops), *_certified(loops)]


# fmt: off
def _ours(loops: Loops) -> Iterator[Claim]:
    d = designed(loops)
    b, limits = d.best, d.limits
    source = "section II.B, II.C"
    yield said("design_rest_limit", source, "L*: largest gain proved at rest for a sector from 1", limits.rest, "1",
               None, f"by {limits.rest_by}, a verified matrix inequality; the paper's 2.5 is the Nyquist limit",
               kind="report")
    yield said("design_slope_bound", source, "largest slope of the designed law", b.slope, "1", 2.265 / 1.1,
               f"the driven limit {limits.driven:.4f} over m2 = 1.1", tolerance=5e-3 * 2.265 / 1.1)
    yield said("design_binding", source, "whether the slope and the noise of the drive bind the design, not the gain",
               word(d.binding == ("stability under command and load", "noise budget")), "", "yes",
               f"binding: {', '.join(d.binding) or 'nothing'}; gain {b.gain:.3f} of {limits.gain:.3f} allowed at rest",
               sense="yes/no")
    yield said("design_es", source, "es of the designed law: far from 0, because of the noise", b.scale_um, "um", 0.1,
               f"the digest took 0.5 um by hand; the budget is {limits.budget_mv:.2f} mV a period at "
               f"rest, 1.2 times the PID's {d.base.rest_du_mv:.2f}", sense=">=")
    yield said("design_degenerate", source, "es of the best candidate where noise is not counted: towards 0",
               d.free.scale_um, "um", 0.01, f"a constant gain of {d.free.gain:.3f}, as loud as "
               f"{d.free.rest_du_mv:.1f} mV a period at rest; score {d.free.score:.3f} against {b.score:.3f}",
               sense="<=")
    yield said("design_reduction", source, "mean reduction of following error and fifteen lines by the designed law",
               100.0 * (1.0 - b.score), "%", 45.0, f"npid_slope, k = {b.strength:.4g}, es = {b.scale_um:.3g} um; "
               f"errors {b.rms_um:.2f} um rms, PID {d.base.rms_um:.2f}", sense=">=")
    yield said("design_beats_scaled", source, "the same against Table I's PID with gains as large as the limits allow",
               100.0 * (1.0 - b.score / d.linear.score), "%", 15.0, f"noise at rest holds the linear PID to "
               f"{d.linear.strength:.3f} times Table I", sense=">=")
    run = loops.get(d.controller(), "constant_load").batch(
        LOAD_S, {"disturbance.first.amplitude": 1.32e-3 * LOADS_UM}, record="true_error")
    swing = float(np.ptp(1e3 * run["true_error"][:, -1000:], axis=1).max())
    yield said("design_quiet", source, "largest swing of the designed law under constant loads of 0.5 to 20 um", swing,
               "um", 0.01, "what is left is the drift of Table I's slow integral; Table I's NPID swings by 9 um",
               sense="<=")


def _beside(loops: Loops) -> Iterator[Claim]:
    d = designed(loops)
    bench = Bench(d.axis, d.work, "cosh")
    x = strength_for("cosh", d.limits.gain, d.limits.slope)
    e_max = np.geomspace(0.5, 12.0, 12)
    found = bench.tried(d.gains, [0.0, 1.5, *[x] * e_max.size], [3.0, 3.0, *e_max])
    pid = Tried(*(v[:1] for v in vars(found).values()))
    score = found.score(pid, d.work.tracking_weight)
    ours, theirs = d.best, float(found.rms_um[1].mean())
    quiet = np.where(found.rest_du_mv[2:] <= d.limits.budget_mv, score[2:], np.inf)
    best = int(np.argmin(quiet))
    yield said("design_cosh", "(2)", "mean reduction by the best cosh within the same limits",
               100.0 * (1.0 - quiet[best]), "%", None, f"alpha e_max = {x:.3f}, e_max = {e_max[best]:.2g} um, gain "
               f"up to {np.cosh(x):.3f}; the slope-limited law gives {100.0 * (1.0 - ours.score):.1f} %", kind="report")
    yield said("design_paper_error", "Table I", "rms error of our law over that of the paper's NPID (um)",
               ours.rms_um / theirs, "1", 1.0, f"{ours.rms_um:.2f} and {theirs:.2f} um; ours is proved under every "
               f"load; the paper's amplitudes are {100.0 * (1.0 - score[1]):.0f} % lower than the PID's, ours "
               f"{100.0 * (1.0 - ours.score):.0f} %", sense="<=")
    drive = float(found.work_du_mv[1].mean())
    yield said("design_paper_drive", "Table I", "change of the voltage from period to period at work, ours over the "
               "paper's NPID (um)", ours.work_du_mv / drive, "1", 0.5, f"{ours.work_du_mv:.1f} and {drive:.1f} mV: the "
               "paper's law chatters at 190 Hz", sense="<=")


def _certified(loops: Loops) -> Iterator[Claim]:
    c = certified(loops)
    source, g = "section IV", c.pid.gains
    rows = c.law.rows_um.mean(axis=0) / c.base.rows_um.mean(axis=0)
    louder = 100.0 * (float(c.law.rest_du_mv.mean() / c.base.rest_du_mv.mean()) - 1.0)
    yield said("design_retuned_rows", source, "mean reduction of the fifteen lines by a law on the retuned PID of Ms "
               f"{MS:g}, against that PID, as loud at rest", 100.0 * (1.0 - float(rows.mean())), "%", 15.0,
               f"PID {g.kp:.3f}, {g.ki:.1f}, {g.kd:.5f}; npid_slope on it, k = {c.k:.3f}, es = {ES_UM:g} um; by line "
               f"{100.0 * (1.0 - rows.max()):.0f} to {100.0 * (1.0 - rows.min()):.0f} %. For small errors both have "
               f"the same Ms {c.ms:.2f}; the steep part of the law has a larger one", sense=">=")
    yield said("design_retuned_noise", source, "how much louder its drive is at rest, encoder 0.5 um, noise 0.1 um",
               louder, "%", 3.0, f"change of the voltage a period, creeping over two counts; mean of {REPEATS} runs",
               sense="<=")
    yield said("design_retuned_proved", source, "plants of the robustness box, of 12, on which a matrix inequality "
               "verified in exact arithmetic proves it under every command and load", float(c.plants), "1", 12.0,
               f"gain +-20 %, damping +-20 %, dead time 0.70 and 0.85 ms, each corner by itself; slopes up to "
               f"{c.k:.3f}, half the Nyquist limit {c.nyquist:.3f} of the nominal loop")
    yield said("design_retuned_quiet", source, "its largest swing under constant loads on these 12 plants", c.swing_um,
               "um", 0.01, f"loads of {LOADS_UM[0]:g} to {LOADS_UM[-1]:g} um under Table I's PID, {LOAD_S:g} s",
               sense="<=")
# fmt: on
