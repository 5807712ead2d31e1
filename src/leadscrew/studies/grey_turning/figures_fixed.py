"""Figures 6 and 7 of the paper redrawn, and where its steady errors come back."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, VERMILION
from leadscrew.studies.grey_turning.reproduction import Cuts, Reproduction
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture

LAWS = {"tfc": ("TFC", VERMILION, "--"), "b": ("GPFC (B)", BLUE, "-")}
"""Name, colour and line by law."""


def fixed_pictures(loops: Loops, found: Reproduction | None = None) -> list[Picture]:
    """All of them."""
    found = found or Reproduction(loops)
    return [
        *(
            Picture(f"fig{number}_{name.lower()}_fixed_depth", f"The paper's Fig. {number}: constant force at 1 mm "
                    f"under {name} with S6 (fitted), plant F, 2 N of noise: filtered force, feed, feed voltage.",
                    partial(three_panels, found, law))
            for number, name, law in ((6, "TFC", "tfc"), (7, "GPFC", "b"))
        ),
        Picture("fig6_7_together", "Figs 6a and 7a over each other: the same factors at noise, then without it. "
                "The overshoot shrinks, the rise stays.", partial(together_picture, found)),
        Picture("steady_error_edge", "Where the steady errors of 5.1 come back: plant N at the edge of a limit cycle, "
                "the loop gain 10 % lower, as fitted, and 10 % higher.", partial(edge_picture, found)),
    ]  # fmt: skip


def seconds(cuts: Cuts) -> np.ndarray:
    """Time of the samples, s."""
    return cuts.period * np.arange(cuts.y.shape[1])


def force_axes(axes: Axes, until: float, most: float = 250.0) -> None:
    """The paper's axes of a force, with its command."""
    axes.axhline(150.0, color=BLACK, linestyle=":", linewidth=1.0)
    axes.set(ylabel="force (N)", xlim=(0.0, until), ylim=(0.0, most))
    axes.grid(alpha=0.3)


def three_panels(found: Reproduction, law: str) -> Figure:
    """Force, feed and voltage of one seed, on the paper's axes."""
    figure = Figure(figsize=(6.4, 7.0), layout="constrained")
    force, feed, volts = figure.subplots(3, 1, sharex=True)
    cuts = found.fixed[f"s6_{law}"]
    t, colour = seconds(cuts), LAWS[law][1]
    force.plot(t, cuts.y[0], color=colour)
    force_axes(force, 3.0)
    force.set_title(f"a) force, {LAWS[law][0]}", fontsize="medium")
    feed.plot(t, cuts.feed[0], color=colour)
    feed.set(ylabel="feed (mm/min)", ylim=(0.0, 150.0), title="b) feed")
    volts.plot(t, cuts.u[0], color=colour, drawstyle="steps-post")
    volts.set(ylabel="feed voltage (V)", ylim=(0.0, 1.0), xlabel="time (s)", title="c) voltage")
    for axes in (feed, volts):
        axes.title.set_fontsize("medium")
        axes.grid(alpha=0.3)
    return figure


def together_picture(found: Reproduction) -> Figure:
    """TFC and GPFC with and without noise."""
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, runs, title in zip(panels, (found.fixed, found.quiet), ("2 N of noise, run-out", "noise-free"),
                                 strict=True):  # fmt: skip
        for law, (name, colour, line) in LAWS.items():
            cuts = runs[f"s6_{law}"]
            axes.plot(seconds(cuts), cuts.y[0], color=colour, linestyle=line, label=name)
        force_axes(axes, 3.0, 170.0)
        axes.set(xlabel="time (s)", title=title)
        axes.legend(frameon=False, loc="lower right")
    panels[1].set_ylabel("")
    return figure


def edge_picture(found: Reproduction) -> Figure:
    """Three loop gains."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    for axes, case, title in zip(panels, ("edge_low", "edge", "edge_high"), ("90 %", "100 %", "110 %"), strict=True):
        for law, (name, colour, line) in LAWS.items():
            cuts = found.fixed[f"{case}_{law}"]
            label = f"{name}: {cuts.steady().mean():.2f} %"
            axes.plot(seconds(cuts), cuts.y[0], color=colour, linestyle=line, label=label)
        force_axes(axes, 3.0)
        axes.set(xlabel="time (s)", ylim=(120.0, 180.0), title=f"loop gain {title}")
        axes.legend(frameon=False, loc="upper left", fontsize="small", title="steady error", title_fontsize="small")
    for axes in panels[1:]:
        axes.set_ylabel("")
    return figure
