"""Pictures of the universes along a run: the paper's Figures 9 and 10, at more than one instant."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import colour
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.rules import SETS

INSTANTS_S = (0.0, 0.1, 0.2, 0.3, 0.45, 0.6)
"""Instants of the run to -50 mm at which the sets are drawn; 0.6 s is k = 600 of the paper's example."""
WINDOW = 0.6
"""Half the width of what is drawn: at k = 0 the universe is wider."""


def contraction_pictures(run: Any, controller: str) -> list[Picture]:
    """The pictures of one run; ``run`` holds the recorded ``controller.e``, ``alpha_e``, ``ec``, ``alpha_ec``."""
    return [
        Picture("contraction", f"The sets of e and ec along the step to -50 mm under {controller}: at k = 600 they are "
                "those that Figures 9 and 10 mean to show, with the state that the simulation has there.",
                partial(film, run, controller)),
    ]  # fmt: skip


def film(run: Any, controller: str) -> Figure:
    """Sets of e (above) and ec (below) at six instants, all on the same axis, and where the input is among them."""
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    panels = figure.subplots(2, len(INSTANTS_S), sharex=True, sharey=True)
    for column, at in enumerate(INSTANTS_S):
        k = round(at * 1000)
        for axes, name in zip(panels[:, column], ("e", "ec"), strict=True):
            _draw(axes, run[f"controller.{name}"][k] + 0.0, run[f"controller.alpha_{name}"][k], name)
        panels[0, column].set_title(f"k = {k}", fontsize="medium")
    for axes, name in zip(panels[:, 0], ("e", "ec"), strict=True):
        axes.set_ylabel(f"membership of {name} (1)")
    for axes in panels[1]:
        axes.set_xlabel("e, ec (1)", fontsize="small")
    figure.suptitle(f"{controller}: the universes shrink around the state (dotted)", fontsize="medium")
    return figure


def _draw(axes: Any, value: float, alpha: float, name: str) -> None:
    sets = SETS.contracted(alpha)
    reach = float(sets.centres[-1])
    x = np.union1d(np.linspace(-reach, reach, 201), sets.centres)
    for label, mu in zip(sets.labels, sets.memberships(x).T, strict=True):
        axes.plot(x, mu, color=colour(label), linewidth=1.1)
    axes.axvline(value, color="black", linestyle=":", linewidth=1.3)
    axes.set_xlim(-WINDOW, WINDOW)
    axes.set_ylim(0.0, 1.3)
    axes.tick_params(labelsize="x-small")
    axes.text(0.5, 0.97, f"{name} = {value:.2g} in \u00b1{reach:.2g}", transform=axes.transAxes, ha="center", va="top",
              fontsize="x-small")  # fmt: skip
