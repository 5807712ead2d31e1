"""The paper's own way to a nonlinear PID, step by step with its numbers, and where each step breaks.

Source: Abdullah et al., *Design and Analysis of Self-tuned Nonlinear PID Controller for XY Table Ballscrew Drive
System*, sections II.B and II.C, equations (1) to (3), Table I. The steps: PID gains from earlier work; the intercept
of the Popov plot with the negative real axis, (-0.4, j0); K(e_max) = 2.5 from (3); retuned by hand to 2.35 against
chatter; e_max = 3 chosen; alpha from (2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.design.npid import Bench, NpidDesign, Tried
from leadscrew.design.npid_axis import Case, Gains, TableAxis, block_of

if TYPE_CHECKING:
    from leadscrew.analysis.stability.linear import LinearLoop


INTERCEPT = -0.4
K_RETUNED = 2.35
E_MAX = 3.0


@dataclass(frozen=True)
class Step:
    """One step of the procedure."""

    name: str
    paper: str
    """What the paper does or says."""
    found: str
    """What we find when we do it."""
    breaks: str = ""
    """Where it breaks; empty where it does not."""


@dataclass(frozen=True)
class PaperDesign:
    """The procedure walked, with the numbers that came out."""

    steps: tuple[Step, ...]
    k_limit: float
    """``1 / 0.4``."""
    alpha: float
    """From (2) with 2.35 and 3."""
    dead_time_s: float
    """Dead time that puts the intercept at -0.4 in the continuous loop."""
    sampled_dead_time_s: float
    """The same in the loop sampled at 2 kHz with a backward difference."""
    popov_zero: float
    """Largest K of the sector [0, K] by Popov in that loop."""
    popov_one: float
    """Of the sector [1, K]."""
    circle_one: float
    slope: float
    """Steepest slope of phi with alpha 0.5 and e_max 3."""
    nyquist: float
    """Gain limit of the axis' sampled loop."""
    driven: float
    """Largest slope proved there under command and load."""
    linear_fit_r2: float
    """Of a straight line through K(e_max) on [0, 3], which the paper calls linear."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**{k: v for k, v in vars(self).items() if k != "steps"}, "steps": [vars(s) for s in self.steps]}


def paper_design(axis: TableAxis | None = None, gains: Gains | None = None) -> PaperDesign:
    """Walks the procedure with the printed plant and gains.

    Raises:
        ValueRefused: a PID whose loop is unstable on the axis.
    """
    from leadscrew.analysis.stability.criteria import ask
    from leadscrew.analysis.stability.lmi import driven
    from leadscrew.analysis.stability.loop import continuous_loop, pid_polynomials
    from leadscrew.analysis.stability.margins import margins

    axis, g = axis or TableAxis(), gains or Gains()
    num, den = pid_polynomials(g.kp, g.ki, g.kd)

    def model(dead_time: float) -> LinearLoop:
        return continuous_loop(num, den, [axis.gain], [1.0, axis.damping, axis.stiffness], dead_time, "equation (1)")

    printed = margins(model(0.0))
    late = dead_time_for(model)
    loop = model(late)
    certificates = ask("popov", loop, 0.0), ask("popov", loop, 1.0), ask("circle", loop, 1.0)
    zero, one, disc = (float(c.limit or math.nan) for c in certificates)
    sampled = axis.linear(g)
    nyquist = sampled.gain_limit(1.0)
    pushed = driven(sampled, (1.0, 1.0))
    proved = pushed.limit if pushed.limit is not None else math.nan
    k_limit, alpha = -1.0 / INTERCEPT, math.acosh(K_RETUNED) / E_MAX
    x = 0.5 * E_MAX
    slope = math.cosh(x) + x * math.sinh(x)
    fit = _r2(np.linspace(0.0, E_MAX, 301), 0.5)
    sampled_late = _sampled_dead_time(axis, g)
    steps = (
        Step(
            "PID gains (Table I)",
            "Kp 1.32, Ki 0.000825, Kd 0.006805, from earlier work by gain and phase margin",
            f"phase margin {printed.pm_deg:.1f} deg at {printed.w_gc:.0f} rad/s, gain margin "
            f"{'infinite' if math.isinf(printed.gm) else f'{printed.gm:.3g}'}; Ki/Kp = {g.ki / g.kp:.3g} 1/s: a PD",
        ),
        Step(
            "intercept of the plot with the negative real axis",
            "probably at (-0.4, j0)",
            "no crossing without dead time" if math.isinf(printed.gm) else f"crossing at {-1.0 / printed.gm:.4g}",
            f"equation (1) with Table I never crosses; a dead time of {1e3 * late:.4f} ms puts it at -0.4 "
            f"({1e3 * sampled_late:.4f} ms where sampled at {1.0 / axis.period_s:g} Hz with a backward difference)",
        ),
        Step(
            "limit of the gain, equation (3)",
            "K(e_max) = -1/|G| = 2.5, range (0, 2.5)",
            f"1/0.4 = {k_limit:.4g}; with a modulus (3) is negative, -1/Re G is meant",
            f"that is the Nyquist limit of a constant gain; Popov proves [0, {zero:.3f}] in that loop, and "
            f"[1, {one:.3f}] because K is never below 1; the circle [1, {disc:.3f}]",
        ),
        Step(
            "retuned by hand against chatter",
            "K(e_max) = 2.35",
            f"a gain margin of {nyquist / K_RETUNED:.3f} is left in the sampled loop",
            f"chatter follows the slope of K(e) e, up to {slope:.4f}, not K; under command and load the sampled loop "
            f"is proved up to a slope of {proved:.3f}, and oscillates from {nyquist:.3f} on",
        ),
        Step(
            "e_max chosen, alpha from (2)",
            "e_max = 3, alpha = 0.5",
            f"alpha = acosh(2.35)/3 = {alpha:.4f}; cosh(0.5 x 3) = {math.cosh(x):.5f}",
            "the unit of e_max is not said: in mm K(10 um) = 1 + 1.25e-5 and the controller is the PID; "
            f"and K over e_max is no straight line (R^2 = {fit:.3f} on [0, 3])",
        ),
    )
    return PaperDesign(
        steps, k_limit, alpha, late, sampled_late, zero, one, disc, slope, nyquist, proved, fit
    )  # fmt: skip


def dead_time_for(model: Any, intercept: float = INTERCEPT) -> float:
    """Dead time, s, with which the loop of ``model(dead_time)`` first crosses the negative real axis at ``intercept``.

    ``|G|`` does not depend on the dead time, so the frequency where it is ``|intercept|`` does not either; the dead
    time turns the phase there to -180 deg.
    """
    from scipy.optimize import brentq

    free = model(0.0)

    def over(log_w: float) -> float:
        return float(np.abs(free.response(np.array([math.exp(log_w)]))[0])) + intercept

    w = math.exp(float(brentq(over, math.log(1.0), math.log(1e6), xtol=1e-14)))
    phase = float(np.angle(free.response(np.array([w]))[0]))
    return (phase + math.pi) % (2.0 * math.pi) / w


def _sampled_dead_time(axis: TableAxis, gains: Gains) -> float:
    """The same of the sampled loop, by bisection on its gain limit."""
    from dataclasses import replace

    from scipy.optimize import brentq

    def over(dead_time: float) -> float:
        return replace(axis, dead_time_s=dead_time).linear(gains).gain_limit(1.0) + 1.0 / INTERCEPT

    low, high = 0.2 * axis.period_s, 3.0 * axis.period_s
    if over(low) * over(high) > 0.0:
        return math.nan
    return float(brentq(over, low, high, xtol=1e-9))


def _r2(e_max: np.ndarray, alpha: float) -> float:
    """Coefficient of determination of a straight line through ``cosh(alpha e_max)``."""
    k = np.cosh(alpha * e_max)
    line = np.polyval(np.polyfit(e_max, k, 1), e_max)
    return float(1.0 - ((k - line) ** 2).sum() / ((k - k.mean()) ** 2).sum())


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
