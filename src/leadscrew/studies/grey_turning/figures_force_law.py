"""Pictures of the force law: published forces with the fits, and the simulated entry of one published cut."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, ORANGE, SKY, VERMILION
from leadscrew.studies.grey_turning.force_facts import DISTINCT, ENTRY, FEED_SERIES, PUBLISHED, cuts
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadscrew.studies.grey_turning.entry import Entries


def force_law_pictures(entered: Entries | None = None) -> list[Picture]:
    """Two pictures; ``entered`` are the runs of the claims, made here unless given."""
    return [
        Picture(
            "force_law_fits",
            "Seven published cuts, the laws fitted to them, and the published law (1609.5 N/mm2, 0.136). The specific "
            "force falls with the depth: no law in proportion to the depth meets all cuts. Right: what the power law "
            "leaves, in the fit and left out of it",
            fits_figure,
        ),
        Picture(
            "tool_entry_published_cut",
            "The published cut at 0.416 mm/rev, simulated at 10 kHz: readings, main force, and its mean over a "
            "revolution, for a depth that grows evenly in 0.4 s, or at once to 79 % and evenly from there; dotted: the "
            "published level and scatter",
            lambda: entry_figure(entered),
        ),
    ]


def fits_figure() -> Figure:
    """Published cuts and laws."""
    from leadscrew.identify.cutting_force import fit_forces
    from leadscrew.report.cutting_force_picture import picture

    return picture(fit_forces(cuts(DISTINCT)), beside=PUBLISHED)


def entry_figure(entered: Entries | None = None) -> Figure:
    """Two simulated entries, and that of the chip alone."""
    from matplotlib.figure import Figure

    from leadscrew.identify.cutting_force import fit_forces
    from leadscrew.studies.grey_turning.entry import entries

    found = entered or entries(fit_forces(cuts(FEED_SERIES)).law)
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for ax, run, title in (
        (axes[0], found.even, "depth grows evenly in 0.4 s"),
        (axes[1], found.sudden, "79 % of it at once"),
    ):
        shown = run.time <= 0.8
        t = run.time[shown]
        ax.plot(t, run.raw[shown], color=SKY, linewidth=0.3, label="reading, 10 kHz", rasterized=True)
        ax.plot(t, found.none.force[shown], color=ORANGE, linewidth=1.0, label="force, whole depth at once")
        ax.plot(t, run.force[shown], color=BLUE, linewidth=1.1, label="main force")
        turn = round(60.0 / ENTRY.spindle_rpm / (t[1] - t[0]))
        mean = np.convolve(run.force, np.full(turn, 1.0 / turn))[: len(t)]
        ax.plot(t, mean, color=VERMILION, linewidth=1.1, linestyle="--", label="its mean over a revolution")
        for level in (-1.0, 0.0, 1.0):
            ax.axhline(
                ENTRY.level_n + level * ENTRY.scatter_n, color=BLACK, linestyle=":", linewidth=0.8,
                label="published level and scatter" if level == 0.0 else None,
            )  # fmt: skip
        ax.set(xlabel="time (s)", xlim=(0.0, 0.8), title=f"{title}: {run.level:.0f} N, {run.scatter:.1f} N")
        ax.grid(color="0.92", linewidth=0.6)
    axes[0].set_ylabel("main cutting force (N)")
    handles, labels = axes[0].get_legend_handles_labels()
    legend = figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize="small")
    legend.get_lines()[0].set_linewidth(1.5)
    return figure
