"""Pictures of the comparison: nine cells by controller, contour, tuning with equal effort, change, step, feed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.report.style import BLACK, BLUE, GREEN, VERMILION, pen
from leadscrew.studies.sofnn_tangent.changing import FEED_ROWS, FEEDS, REPEATS, STEP_AT_S, STEP_CONTROLLERS, changes_of
from leadscrew.studies.sofnn_tangent.claims_change import FED
from leadscrew.studies.sofnn_tangent.claims_contour import ASIDE
from leadscrew.studies.sofnn_tangent.comparison import (
    DIGEST,
    FIXED,
    MAMDANI,
    PAPER,
    PID,
    TUNED,
    comparison_of,
)
from leadscrew.studies.sofnn_tangent.lines import FEED, LAPS, MATERIAL_NAMES, PERIOD_S, samples_of
from leadscrew.studies.sofnn_tangent.runs import CELLS, Loops
from leadscrew.studies.sofnn_tangent.tuning import LAWS, kept
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKS = {"wave": "o", "flower": "^", "rrect": "s"}
HUES = {"fabric": BLUE, "leather": GREEN, "foam": VERMILION}


def comparison_pictures(loops: Loops) -> list[Picture]:
    """Six pictures."""
    return [
        Picture(
            "comparison_cells",
            "RMS deviation of every controller on three lines in three materials, mean of five textures and noises; "
            "the bar is the mean of the nine cells, the open diamond that of the digest",
            lambda: _cells(loops),
        ),
        Picture(
            "comparison_contour",
            "Largest distance of the cut from its line: mean of nine cells (dot) and worst cell (triangle); open marks "
            "are the digest's",
            lambda: _contour(loops),
        ),
        Picture(
            "comparison_equal",
            "Controllers tuned with the same effort, in fabric under two textures: cost of each search (cross), and "
            "RMS deviation on textures that no search has seen, in fabric (square) and on all nine cells (dot)",
            lambda: _equal(loops),
        ),
        Picture(
            "comparison_change",
            "Deviation on three lines; from the dotted line on the material is foam in place of fabric. One texture "
            "and noise, a mean over 10 mm",
            lambda: _change(loops),
        ),
        Picture(
            "comparison_step",
            "A step of the shear by -5 deg, like the paper's Figure 4: the first time, and the fourth time with the "
            "rules that are left from the third",
            lambda: _step(loops),
        ),
        Picture(
            "comparison_feed",
            "RMS deviation of the flower in fabric by feed; open marks are the digest's",
            lambda: _feed(loops),
        ),
    ]


def _words(name: str) -> str:
    if name.startswith("equal."):
        return f"tuned alike: {LAWS[name.removeprefix('equal.')].words}"
    return "fixed rules, Mamdani's inference" if name == MAMDANI else name


def _cells(loops: Loops) -> Figure:
    from matplotlib.figure import Figure

    made = comparison_of(loops)
    names = sorted(made.cells, key=made.mean, reverse=True)
    figure = Figure(figsize=(9.0, 0.9 + 0.3 * len(names)), layout="constrained")
    axes = figure.subplots()
    for row, name in enumerate(names):
        rms = made.cells[name].rms.mean(axis=-1)
        for i, line in enumerate(LAPS):
            for j, material in enumerate(MATERIAL_NAMES):
                axes.plot(
                    rms[i, j], row, MARKS[line], color=HUES[material], markersize=5, alpha=0.8,
                    label=f"{line}, {material}" if row == 0 else None,
                )  # fmt: skip
        axes.plot(rms.mean(), row, "|", color=BLACK, markersize=15, markeredgewidth=2.5)
        if name in DIGEST:
            axes.plot(DIGEST[name].mean, row, "D", color=BLACK, markersize=6, fillstyle="none")
    axes.set_yticks(range(len(names)), [_words(name) for name in names])
    axes.set_xscale("log")
    _plain_ticks(axes, (0.2, 0.5, 1.0, 2.0, 5.0, 10.0))
    axes.set_xlabel("RMS deviation (deg)")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside upper center", ncols=3, fontsize="small")
    return figure


def _plain_ticks(axes: Axes, at: tuple[float, ...]) -> None:
    from matplotlib.ticker import NullFormatter

    axes.set_xticks(at, [f"{x:g}" for x in at])
    axes.xaxis.set_minor_formatter(NullFormatter())


def _contour(loops: Loops) -> Figure:
    from matplotlib.figure import Figure

    made = comparison_of(loops)
    names = sorted(made.cells, key=lambda name: float(made.cells[name].lateral.mean()), reverse=True)
    figure = Figure(figsize=(9.0, 0.9 + 0.26 * len(names)), layout="constrained")
    axes = figure.subplots()
    for row, name in enumerate(names):
        by_cell = made.cells[name].lateral.mean(axis=-1)
        mean, worst = float(by_cell.mean()), float(by_cell.max())
        axes.plot([mean, worst], [row, row], color=BLUE, linewidth=1.0)
        axes.plot(mean, row, "o", color=BLUE, label="mean of nine cells" if row == 0 else None)
        axes.plot(worst, row, "^", color=VERMILION, label="worst cell" if row == 0 else None)
        if name in ASIDE:
            first = name == next(n for n in names if n in ASIDE)
            for value, mark in zip(ASIDE[name], ("o", "^"), strict=True):
                axes.plot(
                    value, row, mark, color=BLACK, fillstyle="none", markersize=9,
                    label="digest" if first and mark == "o" else None,
                )  # fmt: skip
    axes.set_yticks(range(len(names)), [_words(name) for name in names])
    axes.set_xscale("log")
    _plain_ticks(axes, (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0))
    axes.set_xlabel("largest distance of the cut from its line (mm)")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="upper right")
    return figure


def _equal(loops: Loops) -> Figure:
    from matplotlib.figure import Figure

    made = comparison_of(loops)
    laws = sorted(LAWS, key=lambda law: made.mean(f"equal.{law}"), reverse=True)
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for row, law in enumerate(laws):
        costs = [each.cost for each in kept() if each.law == law]
        rms = made.cells[f"equal.{law}"].rms
        for x, mark, hue, size, words in (
            (costs, "x", BLACK, 6, "cost of a search"), ([rms[:, 0].mean()], "s", VERMILION, 6, "fabric, unseen"),
            ([rms.mean()], "o", BLUE, 8, "nine cells, unseen"),
        ):  # fmt: skip
            axes.plot(
                x, [row] * len(x), mark, color=hue, markersize=size, zorder=4 if mark == "x" else 3,
                label=words if row == 0 else None,
            )  # fmt: skip
    axes.set_yticks(range(len(laws)), [LAWS[law].words for law in laws])
    axes.set_xlabel("RMS deviation (deg)")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="upper right")
    return figure


def _change(loops: Loops) -> Figure:
    from matplotlib.figure import Figure

    width = round(10.0 / (FEED * PERIOD_S))
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    for axes, line in zip(figure.subplots(len(LAPS), 1), LAPS, strict=True):
        samples = samples_of(f"{line}_change")
        travel = FEED * PERIOD_S * np.arange(samples)
        for name in (FIXED, PAPER, TUNED, PID):
            e = loops.run(name, f"{line}_change")["actual.deviation"][1 : samples + 1]
            smooth = np.convolve(e, np.full(width, 1.0 / width), mode="valid")
            axes.plot(travel[width // 2 :][: len(smooth)], smooth, linewidth=1.2, **pen(name))
        axes.axvline(travel[-1] / 2.0, color=BLACK, linestyle=":", linewidth=1.2)
        axes.axhline(0.0, color=BLACK, linewidth=0.6)
        axes.set_ylabel(f"{line}: e (deg)")
        axes.set_xlim(0.0, travel[-1])
        axes.grid(alpha=0.3)
    axes.set_xlabel("way along the line (mm)")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4, fontsize="small")
    return figure


def _step(loops: Loops) -> Figure:
    from matplotlib.figure import Figure

    made = changes_of(loops).step
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    for axes, which, words in zip(
        figure.subplots(1, 2, sharey=True), (0, REPEATS - 1), ("first time", "fourth time"), strict=True
    ):
        for short, name in STEP_CONTROLLERS.items():
            e = made[short][which].e
            axes.plot(PERIOD_S * np.arange(1, len(e) + 1) - STEP_AT_S, e, linewidth=1.4, **pen(name))
        axes.set_xlim(-STEP_AT_S, 3.0)
        axes.set_title(words, fontsize="medium", loc="left")
        axes.set_xlabel("time after the step (s)")
        axes.axhline(0.0, color=BLACK, linewidth=0.6)
        axes.grid(alpha=0.3)
        if which == 0:
            axes.set_ylabel("deviation (deg)")
            axes.legend(fontsize="small", loc="upper right")
    return figure


def _feed(loops: Loops) -> Figure:
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter

    made = changes_of(loops).feed
    figure = Figure(figsize=(6.5, 4.2), layout="constrained")
    axes = figure.subplots()
    for name in FEED_ROWS:
        drawn: dict[str, Any] = pen(name)
        found = np.array([made[name, feed][:CELLS] for feed in FEEDS])
        axes.plot(FEEDS, found.mean(axis=1), marker="o", markersize=5, **drawn)
        axes.plot(FEEDS, FED[name], "D", color=drawn["color"], fillstyle="none", markersize=9)
    axes.set(xscale="log", yscale="log", xlabel="feed (mm/s)", ylabel="RMS deviation (deg)")
    _plain_ticks(axes, FEEDS)
    ticks = (0.4, 0.6, 1.0, 2.0, 3.0)
    axes.set_yticks(ticks, [f"{y:g}" for y in ticks])
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="lower right")
    return figure
