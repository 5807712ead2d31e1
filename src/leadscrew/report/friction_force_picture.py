"""The picture of a measured friction force: loops on the hold-out, force against speed, what each model leaves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew import escape
from leadscrew.analysis.friction import friction_velocity
from leadscrew.friction.static_map import TwoSided
from leadscrew.identify.friction_force.result import DAHL, LUGRE, MAP, SLIP, STRIBECK, FrictionForceFit, map_of
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PENS = {MAP: (ORANGE, ":"), STRIBECK: (SKY, "--"), DAHL: (GREEN, "-."), LUGRE: (BLUE, "-"), SLIP: (VERMILION, "--")}
MOST = 6000
"""Points of a line."""


def picture(fit: FrictionForceFit, title: str = "") -> Figure:
    """Force against position and against speed, and residuals; measured and by the models."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 8.6), layout="constrained")
    panels = figure.subplot_mosaic([["loops", "speeds"], ["left", "left"]], height_ratios=[1.35, 1.0])
    loops, speeds, left = (panels[name] for name in ("loops", "speeds", "left"))
    r = fit.record
    held = fit.training < len(r.time)
    rows = np.arange(fit.training if held else 0, len(r.time))
    rows = rows[:: max(1, len(rows) // MOST)]
    unit = r.force_unit
    um = 1e6 if r.unit == "m" else 1e3
    way = "um" if r.unit == "m" else "mrad"
    loops.plot(um * r.position[rows], r.force[rows], color=BLACK, linewidth=1.0, label="measured")
    for name in (MAP, LUGRE, SLIP):
        colour, line = PENS[name]
        loops.plot(um * r.position[rows], fit.models[name].simulated[rows], color=colour, linestyle=line,
                   linewidth=0.9, label=name)  # fmt: skip
    loops.set(xlabel=f"position ({way})", ylabel=f"friction ({unit})",
              title="hold-out: not seen by any fit" if held else "fitted samples")  # fmt: skip
    _against_speed(fit, speeds, um, way)
    for name in (MAP, LUGRE, SLIP):
        colour, line = PENS[name]
        every = slice(None, None, max(1, len(r.time) // MOST))
        left.plot(r.time[every], (r.force - fit.models[name].simulated)[every], color=colour, linewidth=0.6, label=name)
    if held:
        left.axvline(r.time[fit.training], color=BLACK, linewidth=1.0, linestyle="--")
    left.set(xlabel="time (s)", ylabel=f"measured minus model ({unit})",
             title="residual; hold-out right of the line" if held else "residual")  # fmt: skip
    for ax in (loops, speeds, left):
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
        columns = 3 if ax is left else 2
        ax.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=columns)
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    return figure


def _against_speed(fit: FrictionForceFit, ax: Any, um: float, way: str) -> None:
    r = fit.record
    n = fit.training
    some = np.flatnonzero(r.travel[:n])
    some = some[:: max(1, len(some) // MOST)]
    ax.plot(um * r.speed[some], r.force[some], ",", color="0.6", label="measured, moving", rasterized=True)
    scale = fit.normal_mean if fit.load == "coefficient" else 1.0
    reach = np.nan_to_num([max(scale * (b.force - b.low), 0.0) for b in fit.bins])
    ax.errorbar([um * b.speed for b in fit.bins], [scale * b.force for b in fit.bins],
                yerr=reach, fmt="o", color=BLACK, markersize=4, label="sliding, 95 %")  # fmt: skip
    fast = 1.1 * float(np.abs(r.speed[:n]).max())
    v = np.concatenate([-np.geomspace(fast, 1e-4 * fast, 200), np.geomspace(1e-4 * fast, fast, 200)])
    ax.plot(um * v, friction_velocity(map_of(fit), v), color=PENS[LUGRE][0], label="LuGre, steady")
    if STRIBECK in fit.models:
        f = fit.models[STRIBECK].friction
        assert isinstance(f, TwoSided)
        ax.plot(um * v, scale * friction_velocity(f, v), color=PENS[STRIBECK][0], linestyle="--", label=STRIBECK)
    ax.set(xlabel=f"speed ({way}/s)", ylabel=f"friction ({r.force_unit})", title="fitted samples")
