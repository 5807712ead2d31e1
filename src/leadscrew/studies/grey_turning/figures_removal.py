"""Pictures of the two bars: time against peak force, and the cut along the falling one."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.grey_turning.removal import (
    DEPTHS,
    FEEDS,
    FUZZY,
    LENGTH_MM,
    OURS,
    REGULATED,
    SEEDS,
    Removal,
    counted,
)
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PENS = {
    "corrected.tfc_s9": ("TFC, S9", VERMILION, "o"),
    "corrected.gpfc_b_s9": ("GPFC, S9", BLUE, "s"),
    "corrected.tfc_stfc": ("TFC, tuned", ORANGE, "^"),
    "corrected.gpfc_b_sg": ("GPFC, tuned", SKY, "v"),
    REGULATED: ("fixed removal rate", PURPLE, "P"),
    OURS: ("ours.constant_force", GREEN, "D"),
}


def removal_pictures(found: Removal) -> list[Picture]:
    """Two pictures."""
    return [
        Picture(
            "removal_time_and_peak",
            "Time for a bar of 40 mm over the peak force, entry and runout included. Line: constant feeds; below it a "
            "controller is sooner done. Left: falling depth; right: rising shoulders and a hard stretch",
            partial(time_and_peak, found),
        ),
        Picture(
            "removal_along_the_bar",
            "Force and feed along the falling bar: the constant feed of equal peak, and the TFC of Figure 9 and of a "
            "sound tuning",
            partial(along, found),
        ),
    ]


def time_and_peak(found: Removal) -> Figure:
    """A panel a bar."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 4.2), layout="constrained")
    first = SEEDS * (len(FUZZY) + 1)
    for axes, bar in zip(figure.subplots(1, 2, sharey=True), DEPTHS, strict=True):
        accounts = found.accounts(bar)
        run = found.runs[bar, "batch"]
        feeds = [counted(run, slice(first + i, first + i + 1)) for i in range(len(FEEDS))]
        axes.plot([a.peak_n for a in feeds], [a.time_s for a in feeds], color=BLACK, label="constant feed")
        for name, (label, shade, mark) in PENS.items():
            a = accounts[name]
            axes.plot(a.peak_n, a.time_s, mark, color=shade, label=label, markersize=7)
        axes.set(xlabel="peak of the true force (N)", title=" / ".join(f"{b:g}" for b in DEPTHS[bar]) + " mm")
        axes.set(xlim=(130.0, 470.0), ylim=(0.0, 75.0))
        axes.grid(color="0.92", linewidth=0.6)
    figure.axes[0].set(ylabel="time for 40 mm (s)")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    return figure


def along(found: Removal) -> Figure:
    """Force and feed over the way."""
    from matplotlib.figure import Figure

    accounts = found.accounts("falling")
    run = found.runs["falling", "batch"]
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    force, feed = figure.subplots(2, 1, sharex=True)
    for name in ("corrected.tfc_s9", "corrected.tfc_stfc"):
        label, shade, _ = PENS[name]
        row = SEEDS * FUZZY.index(name)
        part = run["actual.travel"][row] < LENGTH_MM
        way = run["actual.travel"][row][part]
        force.plot(way, run["actual.force"][row][part], color=shade, label=label)
        feed.plot(way, run["actual.feed"][row][part], color=shade, label=label)
        same = accounts[name].feed_same_peak
        text = f"constant feed of the peak of {label}"
        feed.plot([0.0, LENGTH_MM], [same, same], color=shade, linestyle="--", label=text)
    force.axhline(150.0, color=BLACK, linestyle=":", linewidth=0.9)
    force.set(ylabel="true force (N)", ylim=(0.0, 320.0))
    feed.set(ylabel="feed (mm/min)", xlabel="way along the bar (mm)", ylim=(0.0, 160.0), xlim=(-0.5, LENGTH_MM))
    for x in np.arange(10.0, 40.0, 10.0):
        force.axvline(x, color="0.85", linewidth=0.8)
    force.legend(frameon=False, loc="upper right")
    feed.legend(frameon=False, loc="upper left", fontsize="small")
    for axes in (force, feed):
        axes.grid(color="0.92", linewidth=0.6)
    return figure
