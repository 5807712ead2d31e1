"""The design of a nonlinear PID: its steps, and pictures: the map with its limits, the paper's K(e_max), spectra."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.design.npid_paper import PaperDesign, Step, compared, spectra
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.report.report import File, Part, Report, TextTable, head
from leadscrew.report.text import steps

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from rich.text import Text

    from leadscrew.design.npid import Candidate, NpidDesign
    from leadscrew.figures.figure import Figure

PAPER_K = 2.35
HIGHEST_HZ = 12.0


def design_map(design: NpidDesign) -> Figure:
    """Score over scale and strength, the limits that apply, the result."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    draw_map(figure.subplots(), design)
    return figure


def draw_map(axes: Axes, design: NpidDesign) -> None:
    """The map into axes."""
    cosh = design.law == "cosh"
    strengths = np.unique([c.strength for c in design.grid])
    scales = np.unique([c.scale_um for c in design.grid])
    shape = len(strengths), len(scales)
    order = sorted(design.grid, key=lambda c: (c.strength, c.scale_um))
    score = np.array([c.score for c in order]).reshape(shape)
    noise = np.array([c.rest_du_mv for c in order]).reshape(shape)
    seen = np.where(np.isfinite(score), score, np.nan)
    filled = axes.contourf(scales, strengths, seen, levels=12, cmap="cividis")
    bar = axes.figure.colorbar(filled, ax=axes)
    bar.set_label("error against the PID")
    budget = design.limits.budget_mv
    if noise.min() < budget < noise.max():
        axes.contour(scales, strengths, noise, levels=[budget], colors=[VERMILION], linewidths=1.6)
        axes.plot([], [], color=VERMILION, label=f"noise budget {budget:.3g} mV; left of it louder")
    axes.axhline(strengths[-1], color=BLACK, linestyle="--", label=f"slope {design.limits.slope:.4g}: limit under load")
    axes.plot([design.best.scale_um], [design.best.strength], "o", color=ORANGE, markeredgecolor=BLACK, markersize=9,
              label=f"result, score {design.best.score:.3f}", clip_on=False)  # fmt: skip
    axes.set_xscale("log")
    axes.set_ylim(strengths[0], strengths[-1] + 0.06 * (strengths[-1] - strengths[0]))
    axes.set_xlabel("e_max (um)" if cosh else "es (um)")
    axes.set_ylabel("alpha e_max" if cosh else "k")
    axes.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)


def draw_gain(axes: Axes, alpha: float = 0.5) -> None:
    """``K(e_max) = cosh(alpha e_max)``, the slope of the curve there, and a straight line."""
    e_max = np.linspace(0.0, 3.6, 400)
    k = np.cosh(alpha * e_max)
    axes.plot(e_max, k, color=BLUE, label="K(e_max)")
    axes.plot(e_max, k + alpha * e_max * np.sinh(alpha * e_max), color=VERMILION, label="slope of K(e) e at e_max")
    inside = e_max <= 3.0
    line = np.polyval(np.polyfit(e_max[inside], k[inside], 1), e_max)
    axes.plot(e_max, line, color=BLUE, linestyle=":", label="straight line through K")
    axes.axhline(2.5, color=BLACK, linewidth=0.8, linestyle="--", label="2.5, Nyquist limit")
    axes.plot([3.0], [PAPER_K], "s", color=ORANGE, markeredgecolor=BLACK, label="chosen: 2.35 at 3")
    axes.set_xlabel("e_max")
    axes.set_ylabel("gain")
    axes.set_ylim(0.5, 6.0)
    axes.legend(fontsize="small", frameon=False)
    axes.grid(alpha=0.3)


def draw_spectra(axes: Any, spectra: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """Amplitude of the error over frequency, one pair of axes a controller."""
    for ax, (name, (hz, um)), colour in zip(axes, spectra.items(), (BLACK, VERMILION, GREEN), strict=True):
        here = (hz > 0.0) & (hz <= HIGHEST_HZ)
        strong = here & (um > 2e-3)
        ax.vlines(hz[strong], 1e-3, um[strong], color=colour, linewidth=1.4)
        ax.set_yscale("log")
        ax.set_ylim(2e-3, 20.0)
        ax.set_xlim(0.0, HIGHEST_HZ)
        ax.set_title(name, fontsize="medium", loc="left")
        ax.set_ylabel("um")
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("frequency (Hz)")


def as_paper(design: NpidDesign, spectra: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> Figure:
    """The paper's figures and ours: K(e_max), the design map, the spectra of one spindle speed."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.15))
    left = [figure.add_subplot(grid[i, 0]) for i in range(3)]
    draw_spectra(left, spectra)
    draw_gain(figure.add_subplot(grid[0:1, 1]))
    draw_map(figure.add_subplot(grid[1:3, 1]), design)
    return figure


# ---- in words
def report_of(design: NpidDesign, paper: PaperDesign | None, files: Sequence[File]) -> Report:
    """The report of ``leadscrew design npid``; ``paper`` is the paper's procedure, to stand beside it."""
    ours = steps(
        ("axis", axis_lines(design)),
        ("PID", pid_lines(design)),
        ("limits", limit_lines(design)),
        ("search", search_lines(design)),
        ("result", result_lines(design)),
    )
    data = {**head("design npid"), **design.as_dict()}
    if paper is None:
        return Report({**data, "paper": None}, [ours], files=files, figure=lambda: design_map(design))
    rows = [list(r) for r in compared(paper, design).rows]
    parts: list[Part] = ["THE PAPER'S PROCEDURE", paper_steps(paper), "OURS", ours]
    return Report(
        {**data, "paper": {**paper.as_dict(), "compared": rows}},
        parts=[*parts, TextTable(["", "the paper's, error in µm", "ours"], rows)],
        files=files,
        figure=lambda: as_paper(design, spectra(design)),
    )


def paper_steps(paper: PaperDesign) -> Callable[[int], Iterator[Text]]:
    """The paper's procedure: what it does, what comes of it here, and where it breaks."""

    def body(step: Step) -> Iterator[str]:
        yield from (f"paper: {step.paper}", f"here: {step.found}")
        if step.breaks:
            yield f"breaks: {step.breaks}"

    return steps(*((step.name, body(step)) for step in paper.steps))


WHERE = {
    "stability at rest": "the gain stands at its limit of stability at rest",
    "stability under command and load": "the slope stands at its limit of stability under command and load",
    "noise budget": "the noise of the drive at rest stands at its budget",
}


def axis_lines(d: NpidDesign) -> list[str]:
    """The axis and its work."""
    a, w = d.axis, d.work
    cases = ", ".join(c.name for c in w.cases)
    return [
        f"{a.gain:g} / (s^2 + {a.damping:g} s + {a.stiffness:g}) mm/V, dead time {1e3 * a.dead_time_s:g} ms, "
        f"sampled at {1.0 / a.period_s:g} Hz",
        f"{w.amplitude_mm:g} mm at {w.frequency_hz:g} Hz; force lines at {', '.join(f'{f:g}' for f in w.lines_hz)} Hz; "
        f"cases: {cases}",
        f"encoder {w.encoder_um:g} µm, noise {w.noise_um:g} µm",
    ]


def pid_lines(d: NpidDesign) -> list[str]:
    """The linear loop."""
    g = d.gains
    said = [f"kp {g.kp:.6g} V/mm, ki {g.ki:.6g} V/(mm s), kd {g.kd:.6g} V s/mm"]
    if d.retuned is not None:
        said.append(
            f"retuned for Ms {d.retuned.asked:g}: the response to force at the lines is {d.retuned.ratio:.3f} of what "
            f"it was, Ms {d.retuned.ms:.4g}"
        )
    b = d.base
    return [*said, f"error {b.rms_um:.3g} µm rms, drive at rest {b.rest_du_mv:.3g} mV from period to period"]


def limit_lines(d: NpidDesign) -> list[str]:
    """What bounds the nonlinear gain."""
    m = d.limits
    return [
        f"at rest: gain up to {m.rest:.4g} ({m.rest_by}, a verified matrix inequality), / m1 = {m.m1:g}: {m.gain:.4g}",
        f"driven: slope up to {m.driven:.4g} (incremental circle, a verified matrix inequality), / m2 = {m.m2:g}: "
        f"{m.slope:.4g}",
        f"noise: at most {m.budget_mv:.3g} mV from period to period at rest",
        f"for comparison, the Nyquist limit of a constant gain: {m.nyquist:.4g}",
    ]


def search_lines(d: NpidDesign) -> list[str]:
    """What was tried, and the degenerate optimum."""
    return [
        f"{len(d.grid)} candidates of the law {d.law}, then two finer grids; score: mean of all amplitudes against the "
        "PID's",
        f"without the noise budget the best of them is {named(d, d.free)}: score {d.free.score:.3f} at "
        f"{d.free.rest_du_mv:.3g} mV",
        f"a linear PID within the same limits: gains x {d.linear.strength:.3f}, score {d.linear.score:.3f} at "
        f"{d.linear.rest_du_mv:.3g} mV",
    ]


def result_lines(d: NpidDesign) -> list[str]:
    """The controller, and what binds."""
    b = d.best
    binding = "; ".join(WHERE[name] for name in d.binding) or "nothing: the optimum lies inside all limits"
    return [
        f"{d.block_name} with {named(d, b)}: gain up to {b.gain:.4g}, slope up to {b.slope:.4g}",
        f"score {b.score:.3f}: {100.0 * (1.0 - b.score):.1f} % less than the PID, "
        f"{100.0 * (1.0 - b.score / d.linear.score):.1f} % less than the linear PID within the same limits",
        f"error {b.rms_um:.3g} µm rms, {b.largest_um:.3g} µm at most; drive at rest {b.rest_du_mv:.3g} mV, at work "
        f"{b.work_du_mv:.3g} mV",
        f"what binds: {binding}",
        f"{d.driven.grade}: {d.driven.statement}",
    ]


def named(d: NpidDesign, c: Candidate) -> str:
    """A candidate by its parameters."""
    if d.law == "slope":
        return f"k = {c.strength:.4g}, es = {c.scale_um:.3g} µm"
    return f"alpha = {c.strength / c.scale_um:.4g} 1/µm, e_max = {c.scale_um:.3g} µm"
