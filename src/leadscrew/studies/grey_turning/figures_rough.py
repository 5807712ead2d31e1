"""Figure 11 of the paper redrawn, and all pairs of rough rules and factors with and without prediction."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLUE, VERMILION
from leadscrew.studies.grey_turning.figures_fixed import LAWS, force_axes, seconds
from leadscrew.studies.grey_turning.reproduction import Reproduction
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture

FLOOR = 0.3
"""Least value of an axis that is logarithmic, %."""


def rough_pictures(loops: Loops, found: Reproduction | None = None) -> list[Picture]:
    """Both of them."""
    found = found or Reproduction(loops)
    return [
        Picture("fig11_rough_rules", "The paper's Fig. 11: roughly chosen rules and factors with and without grey "
                "prediction. Left: rules that weigh the error change a third, S9. Right: standard rules, rough "
                "factors.", partial(rough_rules, found)),
        Picture("fig11_grid", "Overshoot and steady error of six rule tables with five factor sets, each under TFC "
                "(cross) and under GPFC with the same rules (dot). Beyond the lines a response is called bad.",
                partial(grid_picture, found)),
    ]  # fmt: skip


def rough_rules(found: Reproduction) -> Figure:
    """One seed each."""
    figure = Figure(figsize=(9.4, 4.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, case, title in zip(panels, ("weak", "rough"), ("rules with a weak error change", "rough factors"),
                                 strict=True):  # fmt: skip
        for law, (name, colour, line) in LAWS.items():
            cuts = found.fixed[f"{case}_{law}"]
            axes.plot(seconds(cuts), cuts.y[0], color=colour, linestyle=line, label=name)
        force_axes(axes, 3.0, 300.0)
        axes.set(xlabel="time (s)", title=title)
        axes.legend(frameon=False, loc="upper right")
    panels[1].set_ylabel("")
    return figure


def grid_picture(found: Reproduction) -> Figure:
    """A line from TFC to GPFC for each pair."""
    figure = Figure(figsize=(6.8, 5.2), layout="constrained")
    axes = figure.subplots()
    grid = found.grid
    x, y = ({law: np.maximum(of[law].ravel(), FLOOR) for law in ("tfc", "b")} for of in (grid.overshoot, grid.steady))
    for i in range(x["tfc"].size):
        axes.plot([x["tfc"][i], x["b"][i]], [y["tfc"][i], y["b"][i]], color="0.7", linewidth=0.8, zorder=1)
    for law, colour, mark, name in (("tfc", VERMILION, "x", "TFC"), ("b", BLUE, "o", "GPFC (B)")):
        axes.plot(x[law], y[law], mark, color=colour, markersize=5, label=f"{name}: {grid.bad(law).sum()} bad")
    axes.axvline(30.0, color="0.3", linestyle=":")
    axes.axhline(5.0, color="0.3", linestyle=":")
    axes.set(xscale="log", yscale="log", xlabel=f"overshoot (%; {FLOOR:g} and less at {FLOOR:g})",
             ylabel="steady error (%)")  # fmt: skip
    axes.legend(frameon=False, loc="upper left")
    axes.grid(alpha=0.3, which="both")
    return figure
