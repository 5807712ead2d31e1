"""Figures about absolute stability: the Popov plot of the paper for a loop that has it, and the margins of L*."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.analysis.stability.circle import circle
from leadscrew.analysis.stability.loop import reference_loops
from leadscrew.analysis.stability.margins import margins
from leadscrew.analysis.stability.plot import draw_nyquist, draw_popov, draw_sector, finish
from leadscrew.analysis.stability.popov import popov
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable.intercept import PRINTED
from leadscrew.studies.study import Picture

SATURATED = 2.352
"""K(e_max) of Table I."""


def stability_pictures() -> list[Picture]:
    """The paper's Popov plot, and the Nyquist curve of L* with its circles."""
    return [
        Picture("popov_paper", "The paper's Popov plot, redrawn. As printed the loop never reaches the axis; with "
                "1.2888 ms of dead time it crosses at -0.4. The best line of slope 1/q proves [0, 1.41] only; with "
                "1 taken into the loop, as K >= 1 allows, it proves [1, 2.5).", popov_paper),
        Picture("nyquist_margins", "Nyquist curve of L*: as it is, and with K at 2.352. The circle of the sector "
                "[1, 2.265] is the largest that it keeps out of.", partial(nyquist_margins, SATURATED)),
    ]  # fmt: skip


def popov_paper() -> Figure:
    """Two Popov plots of Lc: of ``G`` for sectors from 0, of ``G/(1 + G)`` for sectors from 1."""
    loops = reference_loops()
    loop = loops["Lc"]
    figure = Figure(figsize=(8.6, 4.6), layout="constrained")
    panels: Any = figure.subplots(1, 2)
    left, right = panels
    plain = loops["no_delay"]
    w = np.geomspace(1.0, 1e5, 2000)
    g = plain.response(w)
    draw_popov(left, popov(loop, 0.0), BLUE, VERMILION, "G with 1.2888 ms of dead time")
    bounds = left.get_xlim(), left.get_ylim()
    left.plot(g.real, w * g.imag, color=SKY, linewidth=1.1, label="G as printed")
    left.plot([PRINTED], [0.0], "x", color=BLACK, markersize=8, label="paper: (-0.4, j0)")
    left.set_xlim(*bounds[0])
    left.set_ylim(*bounds[1])
    left.set_title("sector [0, K]: the best line proves K = 1.408", fontsize="medium", loc="left")
    draw_popov(right, popov(loop, 1.0), PURPLE, GREEN)
    right.set_title("sector [1, K]: the best line proves K = 2.500", fontsize="medium", loc="left")
    for axes in panels:
        finish(axes, columns=1)
    return figure


def nyquist_margins(gain: float) -> Figure:
    """Nyquist curve of L* at gain 1 and at the saturated gain, with the circles of Ms and of the sector."""
    loop = reference_loops()["L_star"]
    figure = Figure(figsize=(6.4, 5.6), layout="constrained")
    axes: Any = figure.subplots()
    draw_nyquist(axes, loop, 1.0, BLUE, "L*")
    draw_nyquist(axes, loop, gain, ORANGE, f"{gain:g} L*", marker="s")
    turn = np.linspace(0.0, 2.0 * math.pi, 361)
    for k, ink in ((1.0, BLUE), (gain, ORANGE)):
        found = margins(loop, k)
        axes.plot(-1.0 + np.cos(turn) / found.ms, np.sin(turn) / found.ms, color=ink, linewidth=0.8, linestyle=":",
                  label=f"Ms = {found.ms:.3g}, GM = {found.gm:.3f}")  # fmt: skip
    largest = circle(loop, 1.0).limit or math.nan
    draw_sector(axes, 1.0, largest, GREEN, f"circle of the sector [1, {largest:.3f}]")
    axes.set_aspect("equal")
    axes.set_xlim(-1.9, 0.5)
    axes.set_ylim(-1.3, 0.7)
    axes.set_xlabel("Re G")
    axes.set_ylabel("Im G")
    finish(axes)
    return figure
