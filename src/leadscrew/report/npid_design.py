"""Pictures of the design of a nonlinear PID: the map with its limits, the paper's K(e_max), spectra."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from leadscrew.design.npid import NpidDesign
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
