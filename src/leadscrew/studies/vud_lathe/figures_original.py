"""Pictures of the laws fitted to the original servo: errors, what is left of them, and the duty that no fit saw."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLUE, GREEN, ORANGE, VERMILION
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.original import OriginalResults
from leadscrew.studies.vud_lathe.runs import PERIOD_S
from leadscrew.studies.vud_lathe.tables import FULL_SCALE_MM, Move

SHOWN = {
    "p_289": (VERMILION, ":", "P at 289 mm/s"),
    "pid_209": (GREEN, "--", "PID at 209 mm/s"),
    "power_289": (ORANGE, "-", "c |e|^p at 289 mm/s"),
    "power_216": (BLUE, "-.", "c |e|^p at 216 mm/s"),
}
"""Colour, line and name of each law."""
MOVES = ("r=-190", "r=-50")
"""The columns of Table 1 that are drawn; the other two mirror them."""


def original_pictures(found: OriginalResults, moves: Mapping[str, Move]) -> list[Picture]:
    """The fits against Table 1."""
    return [
        Picture("original_fits", "Laws fitted to the errors of Table 1: errors, what is left, and the duty that no fit "
                "saw.", partial(fits_against_table, found, moves)),
    ]  # fmt: skip


def fits_against_table(found: OriginalResults, moves: Mapping[str, Move]) -> Figure:
    """Table 1 as points, the fitted laws as lines; residuals below, duty at the bottom."""
    figure = Figure(figsize=(8.4, 8.0), layout="constrained")
    panels = figure.subplots(3, 2, sharex=True, sharey="row")
    for column, name in enumerate(MOVES):
        move = moves[name]
        top, middle, bottom = panels[:, column]
        way = abs(move.error[0])
        at = np.rint(move.time_s / PERIOD_S).astype(int)
        for law, (colour, line, label) in SHOWN.items():
            played = found.played[law]
            error = played.error_mm(move.target_mm) / FULL_SCALE_MM
            shown = played.time_s <= move.time_s[-1]
            pen = {"color": colour, "linestyle": line, "linewidth": 1.4}
            top.plot(played.time_s[shown], error[shown] / way, label=label, **pen)
            middle.plot(move.time_s, 100.0 * (error[at] - move.error) / way, marker=".", **pen)
            bottom.plot(played.time_s[shown], played.duty[played.row(move.target_mm)][shown], **pen)
        top.plot(move.time_s, move.error / way, "o", color="black", markersize=3.5, label="Table 1")
        bottom.plot(move.time_s[1:], move.duty[1:], "o", color="black", markersize=3.5)
        middle.axhline(0.0, color="0.7", linewidth=0.8, zorder=0)
        top.set_title(f"move {name} mm")
        bottom.set_xlabel("time (s)")
    for panel, label in zip(
        panels[:, 0], ("error over way (1)", "law minus table (% of way)", "duty (1)"), strict=True
    ):
        panel.set_ylabel(label)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure
