"""Pictures of the workflow without a sensor: the pieces of a drawing, and the second by the first in all materials."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.studies.sofnn_tangent import workflow as w
from leadscrew.studies.sofnn_tangent.claims_workflow import THIRD
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.study import Picture

DRAWING = "leaf.svg"
MATERIAL = "foam"


def workflow_pictures(loops: Loops) -> list[Picture]:
    """Both."""
    del loops
    return [
        Picture("workflow_pieces", f"An SVG drawing ({DRAWING}) in {MATERIAL}, simulated: the programmed line and what "
                "is cut of it, without compensation and with the program that the scan of that piece made; right, the "
                "error of the tangent, and the offsets that were learned. Dotted: the knife is lifted and plunged.",
                pieces_picture),
        Picture("workflow_ratios", "Error of the second piece by that of the first, mean of nine runs. Filled: the "
                f"cut line is known; open: a scan with {w.NOISE_MM:g} mm of noise of a piece that lay elsewhere, "
                "brought back by two marks. Dashed: a third, the target.", ratios_picture),
    ]  # fmt: skip


def pieces_picture() -> Figure:
    """Two pieces of one drawing."""
    from leadscrew.tangent import machine
    from leadscrew.tangent.compensate import compensated
    from leadscrew.tangent.emit import program
    from leadscrew.tangent.measured import Trace
    from leadscrew.tangent.program import program_of

    none = np.empty(0)
    one = program_of(w.first_program(DRAWING), DRAWING)
    first = machine.cut(one.strokes, one.settings, MATERIAL, seed=1)
    traces = [Trace(k, c.x, c.y, none, none, False, DRAWING) for k, c in enumerate(first, start=1)]
    found = compensated(one.strokes, one.settings, traces)
    two = program_of(program(found.strokes, one.settings), DRAWING)
    second = machine.cut(two.strokes, two.settings, MATERIAL, seed=2)
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
    plan = figure.add_subplot(grid[:, 0])
    error, offset = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    begun = 0.0
    for k, (stroke, a, b) in enumerate(zip(one.strokes, first, second, strict=True)):
        line = stroke.at(stroke.grid(0.2))
        names = ("programme", "first piece", "second piece") if k == 0 else (None, None, None)
        plan.plot(line.x, line.y, color=BLACK, lw=2.2, alpha=0.35, label=names[0])
        for cut, colour, name in ((a, VERMILION, names[1]), (b, BLUE, names[2])):
            plan.plot(cut.x, cut.y, color=colour, lw=1.0, label=name)
            error.plot(begun + cut.travel, cut.error, color=colour, lw=1.0)
        offset.plot(begun + b.travel, b.offset, color=GREEN, lw=1.0)
        if k:
            for axes in (error, offset):
                axes.axvline(begun, color=BLACK, lw=0.7, ls=":")
        begun += stroke.length
    plan.set_aspect("equal")
    plan.set(xlabel="x / mm", ylabel="y / mm")
    plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3, frameon=False)
    error.axhline(0.0, color=BLACK, lw=0.5)
    offset.axhline(0.0, color=BLACK, lw=0.5)
    error.set(
        ylabel="error of the tangent / deg", title=f"{machine.rms(first):.2f}, then {machine.rms(second):.2f} deg rms"
    )
    offset.set(xlabel="way / mm", ylabel="offset, second piece / deg")
    return figure


def ratios_picture() -> Figure:
    """All drawings in all materials."""
    drawings = (*LAPS, *w.DRAWINGS)
    figure = Figure(figsize=(8.2, 4.0), layout="constrained")
    axes = figure.subplots()
    exact, scanner = (w.ratios(drawings, MATERIAL_NAMES, scan) for scan in ("exact", "scanner"))
    for m, (material, colour) in enumerate(zip(MATERIAL_NAMES, (VERMILION, ORANGE, BLUE), strict=True)):
        x = np.arange(len(drawings)) + 0.22 * (m - 1)
        axes.vlines(x, exact[:, m], scanner[:, m], color=colour, lw=1.0)
        axes.plot(x, exact[:, m], "o", color=colour, label=material)
        axes.plot(x, scanner[:, m], "o", color=colour, mfc="white")
    axes.axhline(THIRD, color=BLACK, ls="--", lw=1.0)
    axes.set_xticks(np.arange(len(drawings)), drawings)
    axes.set_ylim(0.0, 0.5)
    axes.set(ylabel="error, second piece by first")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    return figure
