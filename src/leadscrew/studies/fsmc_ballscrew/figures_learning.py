"""Figure about learning from pass to pass."""

from __future__ import annotations

from functools import partial
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import StrMethodFormatter

from leadscrew.report.style import BLUE, GREEN, VERMILION
from leadscrew.studies.fsmc_ballscrew.claims_learning import PASSES
from leadscrew.studies.fsmc_ballscrew.learning import FIXED, NO_DAMPING, SCHEDULED, passes
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.study import Picture

SHOWN = (
    ("sine_slow", "0.01 sin t mm", BLUE, "o"),
    ("sine_wide", "5 sin t mm", GREEN, "s"),
    ("sine_fast", "sin 2 pi t mm", VERMILION, "^"),
)

SHOWN_SLOW = 6
"""Passes on the slow sine: each takes ten times as long as one on the fast."""


def learning_pictures(loops: Loops) -> list[Picture]:
    """The error from pass to pass."""
    return [
        Picture("learning_passes", "Largest error from pass to pass, while the observer's torque becomes feed-forward: "
                "fixed gains (on 5 sin t without a believed sigma_1) and gains that rise at low speed.",
                partial(learning_passes, loops)),
    ]  # fmt: skip


def learning_passes(loops: Loops) -> Figure:
    """Largest error over the number of passes, on the three sines: fixed and scheduled gains."""
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    panels: Any = figure.subplots(1, 2, sharey=True)
    for axes, base in zip(panels, (FIXED, SCHEDULED), strict=True):
        for scenario, said, ink, mark in SHOWN:
            count = SHOWN_SLOW if scenario == "sine_slow" else PASSES
            changes = NO_DAMPING if base == FIXED and scenario == "sine_wide" else None
            found = passes(loops, base, scenario, count, changes)
            axes.semilogy(range(len(found)), found, color=ink, marker=mark, markersize=4, linewidth=1.0, label=said)
        axes.set(xlabel="passes learned", title=base)
        axes.set_xticks(range(0, PASSES + 1, 3))
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.grid(alpha=0.3, which="both")
    panels[0].set_ylabel("largest error (µm)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure
