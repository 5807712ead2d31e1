"""Pictures of learning from piece to piece: error by piece, what was learned, recall, and a change of material."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION
from leadscrew.studies.sofnn_tangent.comparison import texture_floor
from leadscrew.studies.sofnn_tangent.lines import MATERIAL_NAMES, line
from leadscrew.studies.sofnn_tangent.recall import LINES, recall
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.taught import SWAP_AT, series
from leadscrew.studies.study import Picture

Pen = tuple[str, str, str, str]
"""Series, words, colour, marker."""
PENS: tuple[Pen, ...] = (
    ("table", "table alone", ORANGE, "s"),
    ("net_table", "SOFNN (paper) and table", BLUE, "o"),
    ("net_table_best", "the same, falling gains", BLACK, "D"),
    ("tuned_table", "SOFNN (tuned) and table", PURPLE, "^"),
    ("feed_forward", "adaptive feed-forward", GREEN, "v"),
)
MISMATCH_PENS: tuple[Pen, ...] = (
    ("mismatch_table", "table alone, sigma 4", ORANGE, "s"),
    ("mismatch_net_table", "SOFNN (paper) and table", BLUE, "o"),
    ("mismatch_feed_forward", "adaptive feed-forward", GREEN, "v"),
)
SWAP_PENS: tuple[Pen, ...] = (
    ("swap_table", "table alone", ORANGE, "s"),
    ("swap_tuned_table", "SOFNN (tuned) and table", PURPLE, "^"),
    ("swap_feed_forward", "adaptive feed-forward", GREEN, "v"),
)
TICKS = (0.2, 0.3, 0.5, 1.0, 2.0)


def pieces_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("pieces_error", "RMS deviation of the tangent by piece, mean of three lines in three materials; bars: "
                "standard deviation of five runs. Left the plant as believed, right with softening, a four-fold effect "
                "of the direction, a ripple and a play that no controller knows of. Dotted: what the texture of the "
                "material alone makes.", partial(errors, loops)),
        Picture("pieces_swap", "Flower, cut in fabric and from the fifth piece on in foam: RMS deviation by piece, "
                "mean of five runs.", partial(swap, loops)),
        Picture("pieces_learned", "The table after six flowers, at its places' curvature: what the paper's SOFNN "
                "and the table found to be needed. The loops are the lag of the material and its fibre.",
                partial(learned, loops)),
        Picture("pieces_recall", "Rules of the curvature in fabric: learned on one line, frozen, and asked on each. "
                "Left the digest's form, right with the direction and rules that know of each other; dashed: 0.6 deg, "
                "asked by M4; grey: without compensation.", partial(recalled, loops)),
    ]  # fmt: skip


def errors(loops: Loops) -> Figure:
    """Error by piece."""
    figure = Figure(figsize=(8.6, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    floor = float(np.mean([found.mean for found in texture_floor(loops).values()]))
    for axes, pens, title in ((left, PENS, "plant as believed"), (right, MISMATCH_PENS, "with unknown terms")):
        for name, words, colour, marker in pens:
            found = series(loops, name)
            at = range(1, len(found.rms) + 1)
            mean = [found.mean(j) for j in at]
            axes.errorbar(at, mean, yerr=[found.spread(j) for j in at], color=colour, marker=marker, markersize=4,
                          linewidth=1.2, capsize=2, label=words)  # fmt: skip
        axes.axhline(floor, color="0.4", linestyle=":", linewidth=1.5, label="texture alone")
        axes.set(yscale="log", xlabel="piece", title=title, xticks=range(1, 7))
        axes.set_yticks(TICKS, [f"{v:g}" for v in TICKS])
        axes.minorticks_off()
        axes.legend(fontsize="x-small", loc="upper right")
    left.set(ylabel="RMS deviation (deg)", ylim=(0.15, 3.0))
    return figure


def swap(loops: Loops) -> Figure:
    """Error by piece with a change of the material."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    for name, words, colour, marker in SWAP_PENS:
        runs = series(loops, name).rms[:, 0, 0]
        at = np.arange(1, len(runs) + 1)
        axes.errorbar(at, runs.mean(axis=1), yerr=runs.std(axis=1, ddof=1), color=colour, marker=marker, markersize=4,
                      linewidth=1.2, capsize=2, label=words)  # fmt: skip
    axes.axvline(SWAP_AT - 0.5, color="0.5", linewidth=0.8)
    axes.text(SWAP_AT - 0.6, 3.1, "fabric", ha="right", va="top", fontsize="small")
    axes.text(SWAP_AT - 0.4, 3.1, "foam", ha="left", va="top", fontsize="small")
    axes.set(yscale="log", xlabel="piece", ylabel="RMS deviation (deg)", ylim=(0.1, 3.5))
    axes.set_yticks(TICKS, [f"{v:g}" for v in TICKS])
    axes.minorticks_off()
    axes.legend(fontsize="x-small", loc="lower left", ncols=3)
    return figure


def learned(loops: Loops) -> Figure:
    """The table against the curvature."""
    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    axes = figure.subplots()
    curvature = line("flower").curvature
    table = series(loops, "net_table").tables["flower"].mean(axis=1)
    for row, material, colour in zip(table, MATERIAL_NAMES, (BLUE, ORANGE, VERMILION), strict=True):
        axes.plot(1e3 * curvature, row[: len(curvature)], color=colour, linewidth=0.7, label=material)
    axes.axhline(0.0, color="0.7", linewidth=0.6)
    axes.set(xlabel="curvature of the line (1/m)", ylabel="offset in the table (deg)")
    axes.legend(fontsize="small")
    return figure


def recalled(loops: Loops) -> Figure:
    """Recall and transfer of the rules of the curvature."""
    figure = Figure(figsize=(8.6, 3.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, form, title in zip(panels, ("digest", "ours"), ("every rule for itself", "ours"), strict=True):
        found = recall(loops, form)
        frozen = found.frozen[:, :, 0].mean(axis=-1)
        at = np.arange(len(LINES))
        axes.bar(at, found.none[:, 0].mean(axis=-1), 0.9, color="0.88", label="no compensation")
        for i, (name, colour, hatch) in enumerate(zip(LINES, (BLUE, ORANGE, GREEN), ("", "//", ".."), strict=True)):
            axes.bar(at + 0.27 * (i - 1), frozen[i], 0.25, color=colour, hatch=hatch, label=f"learned on {name}")
        axes.axhline(0.6, color="0.3", linestyle="--", linewidth=0.9)
        axes.set_xticks(at, LINES)
        axes.set(xlabel="line that is cut", title=title)
    panels[0].set(ylabel="RMS deviation, rules frozen (deg)")
    panels[1].legend(fontsize="x-small", loc="upper left")
    return figure
