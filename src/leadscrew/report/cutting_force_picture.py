"""The picture of force laws: force and specific force against feed, and what the law leaves in each row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew import escape
from leadscrew.analysis.cutting_force import ChipAndEdge, Kienzle, PowerLaw, specific_force
from leadscrew.identify.cutting_force import ForceFit
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKS = "osD^vP*X"
MOST_DEPTHS = len(MARKS)
"""Depths that have a mark each; of more, the laws are drawn for the least, the middle and the largest."""
MOST_BARS = 60


def picture(fit: ForceFit, title: str = "", beside: Kienzle | None = None) -> Figure:
    """Force and specific force against feed, measured and by the laws, and what is left in each row."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    t = fit.table
    low, high = float(t.feed.min()) / 1.3, float(t.feed.max()) * 1.3
    f = np.geomspace(low, high, 80)
    laws: list[tuple[str, Any, str, Any]] = [("power law", fit.law, BLUE, "-")]
    for name, other in fit.others.items():
        if isinstance(other.law, ChipAndEdge):
            laws.append(("chip and edge", other.law, GREEN, "-."))
        elif "depth_exponent" in other.parameters and name:
            laws.append(("with depth exponent", other.law, VERMILION, "--"))
    if beside is not None:
        laws.append((f"given: {beside.kc11:g}, {beside.mc:g}", beside, ORANGE, ":"))
    shade = np.unique(t.depth)
    kind: dict[str, Any] = {"linestyle": "none", "color": BLACK, "fillstyle": "none"}
    if len(shade) > MOST_DEPTHS:
        left.plot(t.feed, t.force, marker=".", markersize=3, alpha=0.5, **kind, label="cuts", rasterized=True)
        kc = specific_force(t.force, t.feed, t.depth)
        middle.plot(t.feed, kc, marker=".", markersize=3, alpha=0.5, **kind, rasterized=True)
        shade = shade[[0, len(shade) // 2, -1]]
    else:
        for k, depth in enumerate(shade):
            rows = t.depth == depth
            left.plot(t.feed[rows], t.force[rows], marker=MARKS[k], **kind, label=f"depth {depth:g} mm")
            kc = specific_force(t.force[rows], t.feed[rows], t.depth[rows])
            middle.plot(t.feed[rows], kc, marker=MARKS[k], **kind)
    for name, law, colour, line in laws:
        for depth in shade:
            shown = name if depth == shade[0] else None
            left.plot(f, law.force(f, depth), color=colour, linestyle=line, linewidth=1.1, label=shown)
        # laws in proportion to the depth have one specific force for all depths
        for depth in shade if isinstance(law, PowerLaw) and law.depth_exponent != 1.0 else shade[-1:]:
            middle.plot(f, specific_force(law.force(f, depth), f, depth), color=colour, linestyle=line, linewidth=1.1)
    for ax in (left, middle):
        ax.set(xscale="log", yscale="log", xlabel="feed (mm/rev)")
        _plain_ticks(ax)
    left.set_ylabel("main cutting force (N)")
    middle.set_ylabel("specific cutting force (N/mm²)")
    at = np.arange(len(t.force))
    if len(at) > MOST_BARS:
        right.plot(t.rows, fit.chosen.left_out_percent, ".", color=ORANGE, markersize=3, label="row left out",
                   rasterized=True)  # fmt: skip
    else:
        right.bar(at - 0.2, fit.chosen.residual_percent, 0.4, color=BLUE, label="row in the fit")
        right.bar(at + 0.2, np.nan_to_num(fit.chosen.left_out_percent), 0.4, color=ORANGE, label="row left out")
        ticks = at if len(at) <= 20 else at[:: len(at) // 10]
        right.set_xticks(ticks, [str(t.rows[int(i)]) for i in ticks])
    right.axhline(0.0, color=BLACK, linewidth=0.6)
    right.set(xlabel="row of the table", ylabel="measured over power law, minus 1 (%)")
    for ax in (left, middle, right):
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    figure.legend(loc="outside lower center", ncols=6, frameon=False, fontsize="small")
    return figure


def _plain_ticks(ax: Any) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())
