"""Pictures of the performance measurement: Table 1 and its network, what makes a network unsafe, training, size."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.neural.performance import GOLDEN, LEVELS, TABLE
from leadscrew.neural.performance_shape import surface
from leadscrew.neural.safety import FLATTEST, NEAR, STEEPEST, safety
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.sofnn_tangent.performance_facts import even_part
from leadscrew.studies.sofnn_tangent.performance_runs import SIZES, histories, nets, of
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.study import Picture

MAP = "RdBu"
DOTS = {
    "lm": ("least squares", BLUE, "o"),
    "ga+lm": ("genetic algorithm, then least squares", SKY, "s"),
    "cma_48k": ("CMA-ES", GREEN, "^"),
    "ga_80x600": ("genetic algorithm alone", ORANGE, "v"),
}
CURVES = {
    "min_rmse": ("18 weights, smallest RMSE", VERMILION, "--"),
    "biased_up": ("25 weights, P(0, 0) > 0", ORANGE, "-."),
    "biased_down": ("25 weights, P(0, 0) < 0", PURPLE, ":"),
}
SEARCHES = {
    "ga": ("genetic algorithm, 80 x 600", ORANGE, "-"),
    "pymoo": ("pymoo's genetic algorithm", PURPLE, ":"),
    "cma": ("CMA-ES", GREEN, "--"),
}


def performance_pictures(loops: Loops | None = None) -> list[Picture]:
    """All of them."""
    return [
        Picture("performance_table", "Left: Table 1 of the paper, the correction in levels by deviation E and its rate "
                "EC. Middle: the network of 18 weights that stands for it. Right: what the network adds. Framed "
                "cells correct more than their mirror image: the table is not odd, the network is.", table_and_network),
        Picture("performance_safety", "Left: the correction along EC = 0. All four networks meet the cells about as "
                "well; the dashed one has the wrong sign around 0, the other two do not pass through 0. Right: every "
                "training of 18 weights by RMSE and slope at the origin; only the shaded slopes are safe.", unsafe),
        Picture("performance_training", "RMSE of the best network so far against networks tried, 18 weights, three "
                "seeds each. Dotted: the floor of an odd network. The polish that follows takes below a second.",
                training),
        Picture("performance_size", "RMSE against hidden neurons, all biases, ten starts of least squares each: what "
                "the paper calls memory takes thirty neurons, not six.", sizes),
    ]  # fmt: skip


def table_and_network() -> Figure:
    """Three maps beside each other."""
    e, ec = np.meshgrid(LEVELS, LEVELS)
    known = surface(GOLDEN, e, ec)
    figure = Figure(figsize=(11.6, 4.0), layout="constrained")
    panes = figure.subplots(1, 3)
    uneven = (TABLE + TABLE[::-1, ::-1] != 0.0) & (np.abs(TABLE) >= np.abs(TABLE[::-1, ::-1]))
    drawn = (("Table 1", TABLE, 6.0), ("network, 18 weights", known, 6.0), ("network less table", known - TABLE, 2.0))
    for axes, (title, values, most) in zip(panes, drawn, strict=True):
        image = axes.imshow(values, origin="lower", extent=(-6.5, 6.5, -6.5, 6.5), cmap=MAP, vmin=-most, vmax=most)
        figure.colorbar(image, ax=axes, label="P (levels)", shrink=0.8)
        axes.set(xlabel="E (levels)", title=title)
        axes.set_xticks(np.arange(-6, 7, 2))
        axes.set_yticks(np.arange(-6, 7, 2))
    panes[0].set_ylabel("EC (levels)")
    for i in range(13):
        for j in range(13):
            strong = abs(TABLE[i, j]) > 4.0
            panes[0].text(j - 6, i - 6, f"{TABLE[i, j]:g}", ha="center", va="center", fontsize=6.5,
                          color="white" if strong else BLACK)  # fmt: skip
            if uneven[i, j]:
                panes[0].add_patch(_frame(j - 6.5, i - 6.5))
    return figure


def _frame(x: float, y: float) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x + 0.04, y + 0.04), 0.92, 0.92, fill=False, edgecolor=BLACK, linewidth=1.0)


def unsafe() -> Figure:
    """P along E of four networks, and slope against RMSE of the trainings."""
    figure = Figure(figsize=(11.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    e = np.linspace(-3.0, 3.0, 601)
    left.axvspan(-NEAR, NEAR, color=BLACK, alpha=0.06)
    left.axhline(0.0, color=BLACK, linewidth=0.6)
    left.axvline(0.0, color=BLACK, linewidth=0.6)
    left.plot(LEVELS[3:10], TABLE[6, 3:10], "o", color=BLACK, label="Table 1")
    left.plot(e, surface(GOLDEN, e, 0.0), color=BLUE, label="golden, 18 weights")
    for name, (label, colour, style) in CURVES.items():
        left.plot(e, surface(nets()[name], e, 0.0), color=colour, linestyle=style, label=label)
    left.set(xlabel="E (levels), EC = 0", ylabel="P (levels)", xlim=(-3.0, 3.0), ylim=(-4.5, 4.5))
    left.legend(fontsize="small", loc="lower left")
    left.grid(alpha=0.3)
    right.axhspan(-STEEPEST, -FLATTEST, color=GREEN, alpha=0.12)
    right.axhline(0.0, color=BLACK, linewidth=0.6)
    for method, (label, colour, mark) in DOTS.items():
        rows = of("18", method)
        right.plot([r.rmse for r in rows], [r.slope for r in rows], mark, color=colour, markersize=5, alpha=0.75,
                   label=label, linestyle="none")  # fmt: skip
    golden = safety(GOLDEN)
    right.plot([golden.rmse], [golden.slope], "*", color=BLACK, markersize=12, linestyle="none", label="golden network")
    right.set(xlabel="RMSE (levels)", ylabel="slope dP/dE at the origin", ylim=(-3.6, 1.0))
    right.legend(fontsize="small", loc="lower right")
    right.grid(alpha=0.3)
    return figure


def training() -> Figure:
    """Best RMSE against networks tried."""
    figure = Figure(figsize=(7.4, 4.0), layout="constrained")
    axes = figure.subplots()
    for (method, seed), rows in histories().items():
        label, colour, style = SEARCHES[method]
        axes.plot(rows[:, 0], rows[:, 1], color=colour, linestyle=style, label=label if seed == 0 else None)
    axes.axhline(float(np.sqrt(np.mean(even_part(TABLE) ** 2))), color=BLACK, linestyle=":", linewidth=1.0)
    axes.set(xlabel="networks tried", ylabel="RMSE (levels)", xscale="log", ylim=(0.2, 2.2))
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    return figure


def sizes() -> Figure:
    """RMSE against hidden neurons."""
    figure = Figure(figsize=(7.0, 3.8), layout="constrained")
    axes = figure.subplots()
    best = []
    for size in SIZES:
        rmse = [r.rmse for r in of(f"hidden_{size}", "lm")]
        axes.plot([size] * len(rmse), rmse, "o", color=SKY, markersize=4, label="a start" if size == SIZES[0] else None)
        best.append(min(rmse))
    axes.plot(SIZES, best, "-s", color=BLUE, label="the best")
    axes.set(xlabel="hidden neurons", ylabel="RMSE (levels)", ylim=(0.0, None), xlim=(0.0, 42.0))
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    return figure
