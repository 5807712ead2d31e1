"""Figures 11 to 14 of the paper drawn from our runs: error and control input under three laws, and the reversals."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadscrew.report.style import BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.studies.fsmc_ballscrew.naming import WAY
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.tracking import SECONDS, reversal_time, settled_run, sine_run
from leadscrew.studies.study import Picture

ROWS = ("corrected.smc", "paper.csmc", "corrected.fsmc")
"""The paper's three laws, from the top: panels (a) and (b), (c) and (d), (e) and (f)."""

LOOKS: dict[str, dict[str, Any]] = {
    "corrected.smc": {"color": VERMILION, "label": "SMC, conventional surface"},
    "paper.smc": {"color": ORANGE, "label": "SMC, printed (integral) surface", "linestyle": "--"},
    "paper.csmc": {"color": BLUE, "label": "CSMC"},
    "corrected.fsmc": {"color": GREEN, "label": "FSMC, rules along $s+s_c$"},
    "paper.fsmc": {"color": SKY, "label": "FSMC, printed rules", "linestyle": "--"},
}
BESIDE = {"corrected.smc": "paper.smc", "corrected.fsmc": "paper.fsmc"}
"""The printed law that shares the row of a corrected one."""

NUMBERS = {"sine_slow": 12, "sine_wide": 13, "sine_fast": 14}
NAMES = {"sine_slow": "fig12_slow_sine", "sine_wide": "fig13_wide_sine", "sine_fast": "fig14_fast_sine"}
MOST = 4000
"""Points a curve is drawn with, where it has more: extremes of stretches, so that no peak is lost."""


def tracking_pictures(loops: Loops) -> list[Picture]:
    """Figures 11 to 14, and the errors after a reversal."""
    drawn = [
        Picture(
            "fig11_step",
            "Figure 11 redrawn: 1 mm in 50 ms. Left the error on its way and after it, right the torque. SMC "
            "keeps an error, CSMC one that takes minutes to go, FSMC none; the torque at rest bends the bristles "
            "under all three. Grey: FSMC with f_hat from the measured speed, whose torque has no mean at rest, "
            "and which oscillates.",
            partial(step_figure, loops),
        )
    ]
    for scenario in SINES:
        caption = (
            f"Figure {NUMBERS[scenario]} redrawn: {WAY[scenario]}. Left the true error, right the torque, in "
            "continuous time with the printed gains; dashed a law as printed beside its correction. Each row "
            "has its own scale."
        )
        drawn.append(Picture(NAMES[scenario], caption, partial(sine_figure, loops, scenario)))
    caption = (
        "Errors after a reversal, at time 0. Above, the laws whose switching term has no integral: the error "
        "changes sides with the friction. Below, those with one: the peak is damped in some ms on the two faster "
        "sines, and in a quarter of a second where the stage creeps."
    )
    return [*drawn, Picture("reversal_peaks", caption, partial(reversal_figure, loops))]


def thinned(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At most :data:`MOST` points of a curve, the smallest and the largest of every stretch among them."""
    stretch = -(-2 * len(t) // MOST)
    if stretch <= 2:
        return t, x
    whole = len(t) // stretch * stretch
    blocks = x[:whole].reshape(-1, stretch)
    first = stretch * np.arange(len(blocks))
    chosen = np.unique(np.concatenate([first + blocks.argmin(axis=1), first + blocks.argmax(axis=1), [len(t) - 1]]))
    return t[chosen], x[chosen]


def _grid(title: str) -> tuple[Figure, Any]:
    figure = Figure(figsize=(10.6, 8.0), layout="constrained")
    figure.suptitle(title)
    panels = figure.subplots(3, 2, sharex="col")
    for row, letters in zip(panels, (("a", "b"), ("c", "d"), ("e", "f")), strict=True):
        for axes, letter in zip(row, letters, strict=True):
            axes.set_title(f"({letter})", loc="left", fontsize="medium")
            axes.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
            axes.grid(alpha=0.25)
    return figure, panels


def _legend(axes: Axes) -> None:
    axes.legend(loc="upper left", bbox_to_anchor=(0.04, 1.17), ncols=3, fontsize="x-small", frameon=False)


def sine_figure(loops: Loops, scenario: str) -> Figure:
    """Error and torque on a sine: six panels."""
    figure, panels = _grid(WAY[scenario])
    for law, (left, right) in zip(ROWS, panels, strict=True):
        for name in (law, BESIDE.get(law)):
            if name is None:
                continue
            run = sine_run(loops, name, scenario)
            thin = {"linewidth": 1.8, "zorder": 2} if name == law else {"linewidth": 0.8, "zorder": 3}
            left.plot(*thinned(run["time"], 1e6 * run["true_error"]), **LOOKS[name], **thin)
            right.plot(*thinned(run["time"], run["output"]), **LOOKS[name], **thin)
        left.set_ylabel("error, nm")
        right.set_ylabel("torque, N m")
        _legend(left)
    for axes in panels[-1]:
        axes.set_xlabel("time, s")
        axes.set_xlim(0.0, SECONDS[scenario])
    return figure


def step_figure(loops: Loops) -> Figure:
    """Error and torque of the smooth step: six panels."""
    figure, panels = _grid("1 mm in 50 ms")
    for law, (left, right) in zip(ROWS, panels, strict=True):
        if law == "corrected.fsmc":
            free = settled_run(loops, law)
            look = {"color": "0.55", "linewidth": 0.6, "label": "f_hat from the measured speed"}
            left.plot(*thinned(free["time"], 1e6 * free["true_error"]), **look)
            right.plot(*thinned(free["time"], free["output"]), **look)
        for name in (BESIDE.get(law), law):
            if name is None:
                continue
            run = loops.run(name, "step_quintic")
            left.plot(run["time"], 1e6 * run["true_error"], linewidth=1.1, **LOOKS[name])
            right.plot(run["time"], run["output"], linewidth=1.1, **LOOKS[name])
        run = loops.run(law, "step_quintic")
        left.set_ylabel("error, nm")
        right.set_ylabel("torque, N m")
        end = 1e6 * run["true_error"][-1]
        left.annotate(f"{end:.0f} nm" if abs(end) > 0.5 else "0 nm", (0.58, end), xytext=(0, 6),
                      textcoords="offset points", ha="right", fontsize="small")  # fmt: skip
        right.annotate(f"{run['output'][-1]:.2f} N m", (0.58, run["output"][-1]), xytext=(0, 6),
                       textcoords="offset points", ha="right", fontsize="small")  # fmt: skip
        _legend(left)
    for axes in panels[-1]:
        axes.set_xlabel("time, s")
        axes.set_xlim(0.0, 0.6)
    return figure


def reversal_figure(loops: Loops) -> Figure:
    """Errors of all five laws around one reversal of each sine."""
    figure = Figure(figsize=(10.6, 6.4), layout="constrained")
    panels = figure.subplots(2, len(SINES), sharex="col")
    below = ("paper.smc", "corrected.fsmc", "paper.fsmc")
    spans = {"sine_slow": (0.3, 0.6), "sine_wide": (0.01, 0.05), "sine_fast": (0.004, 0.02)}
    for column, scenario in enumerate(SINES):
        at, (ahead, after) = reversal_time(scenario), spans[scenario]
        top = panels[0, column]
        top.set_title(WAY[scenario], fontsize="medium")
        panels[1, column].set_xlabel("time after the reversal, ms")
        for name, look in LOOKS.items():
            run = sine_run(loops, name, scenario)
            inside = (run["time"] >= at - ahead) & (run["time"] <= at + after)
            axes = panels[1 if name in below else 0, column]
            axes.plot(1e3 * (run["time"][inside] - at), -1e6 * run["true_error"][inside], linewidth=1.2, **look)
        for axes in panels[:, column]:
            axes.axvline(0.0, color="0.8", linewidth=0.8, zorder=0)
            axes.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
            axes.grid(alpha=0.25)
    for axes in panels[:, 0]:
        axes.set_ylabel("error, nm")
    sides = [axes.get_legend_handles_labels() for axes in panels[:, 0]]
    handles, labels = ([x for side in sides for x in side[k]] for k in (0, 1))
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure
