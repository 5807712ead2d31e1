"""The figures of the paper redrawn, and the surface of the rules before and after learning."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.neural.inference_net import LABELS, SETS
from leadscrew.report.style import BLACK, GREEN, ORANGE, SKY, VERMILION, pen
from leadscrew.studies.sofnn_tangent.lines import PERIOD_S, line
from leadscrew.studies.sofnn_tangent.online import PNN, TABLE, TUNED, first_rules, loop_of, pieces, to_the_end
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NONE, PID = "paper.uncompensated", "ours.pid"
CUT = "wave_fabric"
AREA_COLOURS = {"I": SKY, "II": ORANGE, "III": GREEN}
PIECES = 5
WIDTHS = {PNN: 1.4, TUNED: 2.0, PID: 0.8}


def paper_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("fig4_step_areas", "Answer to a step of the shear of -5 degrees. The areas are those of the paper's "
                "Figure 4, by the signs of deviation and rate: I too low and rising, II above and rising, III above "
                "and falling. The paper's network reaches zero without overshoot and passes area I alone.",
                partial(step_areas, loops)),
        Picture("fig5_trajectory", "The line to be cut, a cubic B-spline, with its control polygon. It stands in for "
                "the paper's Figure 5, whose points are not printed.", trajectory),
        Picture("fig6_without_compensation", "Tangential angle along the wave in fabric without compensation: the "
                "programmed tangent, that of the cut, and the difference.", partial(without, loops)),
        Picture("fig7_with_compensation", "The same with compensation: deviation of the cut under the paper's network, "
                "under the tuned one and under a PID, and the offset angles that they send.", partial(with_it, loops)),
        Picture("rule_surface", f"The 49 rules of the paper's controller (table between its cells) before learning, "
                f"after {PIECES} pieces of the flower in fabric, and the difference, in levels. Read per sample EC "
                "stays at zero: the rules around ZO are used, their neighbours, of which little is known, drift along, "
                "and forty and more never change.",
                partial(rule_surface, loops)),
    ]  # fmt: skip


def step_areas(loops: Loops) -> Figure:
    """Deviation after a step, the areas of the tuned network shaded."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.8), layout="constrained")
    axes = figure.subplots()
    for name in (PNN, TABLE, TUNED):
        run = loop_of(loops, name, "step").run(3.0, record=("actual.deviation",))
        axes.plot(run["time"] - 1.0, run["actual.deviation"], **pen(name))  # type: ignore[arg-type]
    run = loop_of(loops, TUNED, "step").run(3.0, record=("actual.deviation",))
    t, e = run["time"] - 1.0, np.asarray(run["actual.deviation"])
    shade_areas(axes, t, e)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    axes.set(xlabel="time since the step, s", ylabel="deviation of the cut, deg", xlim=(-0.1, 1.5), ylim=(-5.0, 1.6))
    axes.legend(loc="lower right")
    axes.grid(alpha=0.3)
    return figure


def shade_areas(axes: Axes, t: np.ndarray, e: np.ndarray) -> None:
    """Shades the first spell of each area, from where the deviation is largest on; its number above."""
    first = int(np.argmin(e))
    rising = np.diff(e, prepend=e[0]) > 0.0
    area = np.where(e < 0.0, np.where(rising, "I", ""), np.where(rising, "II", "III"))
    for name, hue in AREA_COLOURS.items():
        at = np.flatnonzero(area[first:] == name)
        if not at.size:
            continue
        begin = first + int(at[0])
        inside = np.flatnonzero(area[begin:] != name)
        end = begin + (int(inside[0]) if inside.size else 1)
        axes.axvspan(t[begin], t[end], color=hue, alpha=0.35, linewidth=0.0)
        axes.annotate(name, (0.5 * (t[begin] + t[end]), 1.15), ha="center")


def trajectory() -> Figure:
    """The wave and its control polygon."""
    from matplotlib.figure import Figure

    from leadscrew.paths.shapes import WAVE

    figure = Figure(figsize=(7.2, 3.4), layout="constrained")
    axes = figure.subplots()
    found = line("wave")
    polygon = np.asarray(WAVE, dtype=float)
    axes.plot(
        polygon[:, 0], polygon[:, 1], "o--", color=VERMILION, markersize=4, linewidth=1.0, label="control polygon"
    )
    axes.plot(found.x, found.y, color=BLACK, label="line to be cut")
    axes.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")
    axes.legend(loc="lower left")
    axes.grid(alpha=0.3)
    return figure


def without(loops: Loops) -> Figure:
    """Programmed and cut tangent, and the difference."""
    from matplotlib.figure import Figure

    heading = line("wave").heading
    e = to_the_end(loops, loop_of(loops, NONE, CUT).start(), CUT)[: len(heading)]
    way = 0.5 * np.arange(len(heading))
    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    upper.plot(way, heading, color=BLACK, linestyle=":", label="programmed")
    upper.plot(way, heading + e, color=VERMILION, label="cut, without compensation")
    upper.set(ylabel="tangential angle, deg")
    upper.legend(loc="upper right")
    lower.plot(way, e, color=VERMILION)
    lower.axhline(0.0, color=BLACK, linewidth=0.8)
    lower.set(xlabel="way along the line, mm", ylabel="deviation, deg")
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return figure


def with_it(loops: Loops) -> Figure:
    """Tangent, deviation and offset under three controllers."""
    from matplotlib.figure import Figure

    heading = line("wave").heading
    way = 0.5 * np.arange(len(heading))
    figure = Figure(figsize=(7.2, 6.4), layout="constrained")
    upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=(2, 2, 2))
    upper.plot(way, heading, color=BLACK, linestyle=":", label="programmed")
    for name in (PNN, TUNED, PID):
        run = loop_of(loops, name, CUT).run(PERIOD_S * (len(heading) + 1), record=("actual.deviation", "output"))
        e, d = np.asarray(run["actual.deviation"])[1:], np.asarray(run["output"])[:-1]
        if name == PNN:
            upper.plot(way, heading + e, **pen(name, "cut, " + name))
        width = WIDTHS[name]
        middle.plot(way, e, **pen(name), linewidth=width)
        lower.plot(way, d, **pen(name), linewidth=width)
    bare = to_the_end(loops, loop_of(loops, NONE, CUT).start(), CUT)[: len(heading)]
    middle.plot(way, bare, color=BLACK, linewidth=0.8, alpha=0.6, label="without compensation")
    upper.set(ylabel="tangential angle, deg")
    middle.set(ylabel="deviation, deg", ylim=(-4.4, 3.4))
    lower.set(xlabel="way along the line, mm", ylabel="offset angle, deg")
    upper.legend(loc="upper right")
    handles, labels = middle.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4, fontsize="small")
    for axes in (upper, middle, lower):
        axes.grid(alpha=0.3)
    return figure


def rule_surface(loops: Loops) -> Figure:
    """Three maps of 7 x 7 rules."""
    from matplotlib.figure import Figure

    found = pieces(loops, TABLE, "flower_fabric", PIECES)
    before = first_rules(loops, TABLE).reshape(SETS, SETS)
    after = found.weights[-1].reshape(SETS, SETS)
    figure = Figure(figsize=(10.0, 3.9), layout="constrained")
    image: Any = None
    for axes, values, title in zip(
        figure.subplots(1, 3), (before, after, after - before), ("before", f"after {PIECES} pieces", "difference"),
        strict=True,
    ):  # fmt: skip
        image = axes.imshow(values, cmap="PuOr", vmin=-8.0, vmax=8.0, origin="lower")
        axes.set(title=title, xlabel="E", xticks=range(SETS), yticks=range(SETS))
        axes.set_xticklabels(LABELS)
        axes.set_yticklabels(LABELS)
        for (j, i), value in np.ndenumerate(values):
            if abs(value) > 0.005:
                axes.annotate(f"{value:.1f}", (i, j), ha="center", va="center", fontsize=7,
                              color="white" if abs(value) > 5.5 else BLACK)  # fmt: skip
    figure.axes[0].set_ylabel("EC")
    figure.colorbar(image, ax=figure.axes, label="consequent, levels", shrink=0.8)
    return figure
