"""The paper's procedure and ours side by side: one axis, one work, what each controller is worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.design.npid import NpidDesign
from leadscrew.design.npid_axis import Case, Gains, block_of
from leadscrew.design.npid_paper import E_MAX, PaperDesign
from leadscrew.design.npid_trial import Bench, Tried

PAPER_X = 1.5
"""``alpha e_max`` of Table I: 0.5 times 3."""


@dataclass(frozen=True)
class Compared:
    """Both controllers tried on the same work."""

    paper: Tried
    ours: Tried
    pid: Tried
    rows: tuple[tuple[str, str, str], ...]
    """What, the paper's, ours."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"rows": [list(r) for r in self.rows]}


def compared(paper: PaperDesign, design: NpidDesign) -> Compared:
    """The table of the paper's controller (error in um) and ours, each beside the PID of Table I."""
    work = design.work
    bench = Bench(design.axis, work, "cosh")
    both = bench.tried(Gains(), [0.0, PAPER_X], [1.0, E_MAX])
    pid, his = _one(both, 0), _one(both, 1)
    mine = Bench(design.axis, work, design.law).tried(design.gains, [design.best.strength], [design.best.scale_um])
    b, limits = design.best, design.limits
    g = design.gains
    rows = (
        ("PID gains", "1.32, 0.000825, 0.006805", f"{g.kp:.4g}, {g.ki:.4g}, {g.kd:.4g}"),
        ("gain bounded by", "the intercept of a plot: 2.5", f"a proof at rest: {limits.rest:.4g} / {limits.m1:g}"),
        ("slope bounded by", "nothing", f"a proof under command and load: {limits.driven:.4g} / {limits.m2:g}"),
        ("chatter bounded by", "retuning by hand", f"the slope, and {limits.budget_mv:.3g} mV of noise at rest"),
        ("law", "cosh, alpha 0.5, e_max 3", _law(design)),
        ("largest gain", f"{np.cosh(PAPER_X):.4g}", f"{b.gain:.4g}"),
        ("largest slope", f"{paper.slope:.4g}", f"{b.slope:.4g}"),
        ("proved under command and load", "no", "yes" if design.driven.proved else "no"),
        ("mean of the force lines, less than PID", _less(his, pid), _less(mine, pid)),
        ("following error, um", f"{his.tracking_um.mean():.3g}", f"{mine.tracking_um.mean():.3g}"),
        ("error rms, um", f"{his.rms_um.mean():.3g}", f"{mine.rms_um.mean():.3g}"),
        ("largest error, um", f"{his.largest_um.max():.3g}", f"{mine.largest_um.max():.3g}"),
        ("drive at work, mV a period", f"{his.work_du_mv.mean():.3g}", f"{mine.work_du_mv.mean():.3g}"),
        ("drive at rest, mV a period", f"{his.rest_du_mv[0]:.3g}", f"{mine.rest_du_mv[0]:.3g}"),
    )  # fmt: skip
    return Compared(his, mine, pid, rows)


def _law(design: NpidDesign) -> str:
    b = design.best
    if design.law == "slope":
        return f"slope-limited, k {b.strength:.4g}, es {b.scale_um:.3g} um"
    return f"cosh, alpha {b.strength / b.scale_um:.3g} 1/um, e_max {b.scale_um:.3g} um"


def _one(tried: Tried, index: int) -> Tried:
    return Tried(*(getattr(tried, name)[index : index + 1] for name in vars(tried)))


def _less(tried: Tried, pid: Tried) -> str:
    used = pid.rows_um > 0.0
    if not used.any():
        return "no force lines"
    return f"{100.0 * (1.0 - float((tried.rows_um[used] / pid.rows_um[used]).mean())):.1f} %"


def spectra(design: NpidDesign, case: Case | None = None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Spectra of the true error in one case: PID, the paper's NPID, ours; frequency in Hz and amplitude in um.

    A Fourier transform of the last half of a run, 10 s, so the lines of the motion and the force stand on bins.
    """
    controllers = {
        "PID, Table I": block_of("slope", Gains()),
        "NPID of the paper, error in um": block_of("cosh", Gains(), PAPER_X, E_MAX),
        "ours": design.controller(),
    }
    from leadscrew.design.npid_axis import RUN_S

    found = {}
    for name, block in controllers.items():
        run = design.axis.loop(block, design.work, case or design.work.cases[0]).run(RUN_S, record=("true_error",))
        error = 1e3 * run["true_error"]
        half = error[len(error) // 2 :]
        lines = 2.0 * np.abs(np.fft.rfft(half - half.mean())) / len(half)
        found[name] = np.fft.rfftfreq(len(half), design.axis.period_s), lines
    return found
