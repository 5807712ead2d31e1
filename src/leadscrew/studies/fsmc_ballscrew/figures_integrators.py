"""Pictures of the integrators: the error of each scheme along a run, and error against speed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.fsmc_ballscrew.integrators import (
    NM,
    PERIOD_S,
    SMOOTH,
    TRUTH,
    angles,
    every,
    rodas,
)
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadscrew.studies.fsmc_ballscrew.runs import Loops

SHOWN = (
    (every("rk4", 2.0), ORANGE, "--"),
    (rodas(1e-3), SKY, "-"),
    (every("fixed", 50.0), GREEN, "-."),
    (rodas(1e-4), BLUE, "-"),
)
WAY = {"sine_wide": "5 sin t mm", "sine_fast": "sin 2 pi t mm"}
FLOOR_NM = 1e-4
"""Errors below are drawn here: on a logarithmic axis 0 has no place."""


class Point(NamedTuple):
    """A scheme in the work-precision picture."""

    group: str
    real_time: float
    error_nm: float
    label: str = ""


MARKS = {
    "RODAS": (BLUE, "o"),
    "SDIRK3, scalar": (GREEN, "s"),
    "RK4": (ORANGE, "^"),
    "exponential Rosenbrock-Euler": (PURPLE, "D"),
    "explicit Euler": (VERMILION, "v"),
    "SciPy LSODA": (SKY, "X"),
    "SciPy Radau": (BLACK, "P"),
}


def integrator_pictures(loops: Loops) -> list[Picture]:
    """All pictures of this file that are the same on every machine."""
    caption = "Distance from the truth along both sines. Errors are made at the reversals, and the loop forgets them."
    return [Picture("integrator_errors", caption, partial(error_figure, loops))]


def error_figure(loops: Loops) -> Figure:
    """Error of four schemes along both sines."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    for axes, sine in zip(figure.subplots(1, 2, sharey=True), SMOOTH, strict=True):
        truth = angles(sine, TRUTH)
        time = PERIOD_S * np.arange(len(truth))
        for scheme, colour, line in SHOWN:
            error = NM * np.abs(angles(sine, scheme) - truth)
            axes.semilogy(time, np.maximum(error, FLOOR_NM), color=colour, linestyle=line, label=scheme.name)
        axes.set_title(WAY[sine])
        axes.set_xlabel("time, s")
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("distance from the truth, nm")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def work_precision_figure(points: Sequence[Point], title: str) -> Figure:
    """Error against how many times faster than real time, of schemes that were measured in one run."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots()
    for group, (colour, mark) in MARKS.items():
        mine = sorted((p for p in points if p.group == group), key=lambda p: p.real_time)
        if not mine:
            continue
        axes.loglog([p.real_time for p in mine], [p.error_nm for p in mine], color=colour, marker=mark, label=group)
        for p in mine:
            axes.annotate(p.label, (p.real_time, p.error_nm), textcoords="offset points", xytext=(6, 5), fontsize=8)
    axes.margins(x=0.1)
    axes.axhline(0.5, color=BLACK, linestyle=":", linewidth=1.0)
    axes.axvline(500.0, color=BLACK, linestyle=":", linewidth=1.0)
    axes.set_xlabel("times faster than real time, one core")
    axes.set_ylabel("largest error of the position, nm")
    axes.set_title(title)
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=4)
    return figure
