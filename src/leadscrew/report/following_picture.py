"""The picture of following errors: lag by axis and phase with intervals, root mean square and largest error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew import escape
from leadscrew.analysis.following import Following
from leadscrew.report.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)


def picture(found: Following, title: str = "") -> Figure:
    """Left the lag of each axis in each phase, right its errors; positions in the unit of the log."""
    from matplotlib.figure import Figure

    axes_names = list(dict.fromkeys(r.axis for r in found.together))
    phases = list(dict.fromkeys(r.phase for r in found.together))
    figure = Figure(figsize=(10.0, 1.6 + 0.36 * max(len(phases), 4)), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for k, name in enumerate(axes_names):
        rows = [r for r in found.together if r.axis == name]
        at = np.array([phases.index(r.phase) for r in rows]) + 0.7 * ((k + 0.5) / len(axes_names) - 0.5)
        colour = COLOURS[k % len(COLOURS)]
        lags = 1e3 * np.array([r.lag.value for r in rows])
        halves = 1e3 * np.array([r.lag.half for r in rows])
        told = np.isfinite(halves)
        left.errorbar(lags[told], at[told], xerr=halves[told], fmt="o", markersize=3.5, capsize=2, color=colour,
                      label=name)  # fmt: skip
        right.plot([r.rms for r in rows], at, "o", markersize=4, color=colour, label=f"{name}, rms")
        right.plot([r.worst for r in rows], at, "|", markersize=8, color=colour, label=f"{name}, max")
    left.set_yticks(range(len(phases)), phases)
    left.invert_yaxis()
    left.set(xlabel="lag from error at speed, 95 % (ms)")
    spread = [1e3 * x for r in found.together for x in (r.lag.low, r.lag.high) if np.isfinite(x)]
    if spread:
        low, high = np.percentile(spread, [5, 95])
        left.set_xlim(min(0.0, low - 0.2 * (high - low)), high + 0.4 * (high - low) + 1e-9)
    units = sorted({r.unit for r in found.together if r.unit})
    right.set(xscale="symlog", xlabel=f"error ({', '.join(units)})" if units else "error, unit of the log")
    smallest = min((r.rms for r in found.together if r.rms > 0.0), default=1.0)
    right.set_xscale("symlog", linthresh=0.5 * smallest)
    right.set_xlim(0.0, 1.5 * max((r.worst for r in found.together), default=1.0) or 1.0)
    for ax in (left, right):
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=2 * len(axes_names), frameon=False, fontsize="small"
    )
    return figure
