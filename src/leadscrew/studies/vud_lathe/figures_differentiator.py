"""The picture for Figure 5: what the differentiating circuit reads along a move, beside the curvature itself."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, ORANGE
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.claims_arithmetic import CURVATURES
from leadscrew.studies.vud_lathe.claims_differentiator import EXPONENT, GAIN, original_scope, smooth_scope
from leadscrew.studies.vud_lathe.curvature_trials import TRUE, step_run
from leadscrew.studies.vud_lathe.differentiator import LAG_S, Scope, power_curvature

NEAREST = 0.02
"""Size of e down to which the readings are drawn."""


def differentiator_pictures(loops: Any) -> list[Picture]:
    """The one picture; ``loops`` gives the run of the original controller."""
    caption = "What the circuit of Figure 5 reads along a move, beside the second derivative that it is said to show."
    return [Picture("fig5_differentiator", caption, partial(differentiator, loops))]


def differentiator(loops: Any) -> Figure:
    """Readings of ``(d2u/dt2) / (d2e/dt2)`` and ``|u_ee|`` against the size of e, for a smooth law and our stand-in."""
    figure = Figure(figsize=(8.4, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    sizes = np.geomspace(NEAREST, 1.0, 200)
    _panel(left, smooth_scope(step_run(-190.0, 6.0)), sizes, TRUE[0] * sizes, "cubic, known curvature")
    _panel(right, original_scope(loops), sizes, power_curvature(sizes, GAIN, EXPONENT), "ours.original_fit")
    left.set_ylabel("size of the second derivative (1)")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _panel(axes: Any, seen: Scope, sizes: np.ndarray, true: np.ndarray, title: str) -> None:
    drawn = (np.abs(seen.e) >= NEAREST) & (seen.time > 3.0 * LAG_S)
    axes.plot(np.abs(seen.e)[drawn], seen.over_e[drawn], color=ORANGE, linewidth=1.2,
              label="circuit: (d²u/dt²) / (d²e/dt²)")  # fmt: skip
    axes.plot(sizes, true, color=BLUE, linewidth=1.6, label="|∂²u/∂e²|")
    axes.axhline(CURVATURES[0], color=BLACK, linestyle=":", linewidth=1.2, label="paper, (8): 1.96")
    axes.set(xscale="log", yscale="log", title=title, ylim=(0.02, 300.0))
    axes.invert_xaxis()
    axes.set_xlabel("|e| (1), the move runs to the right")
