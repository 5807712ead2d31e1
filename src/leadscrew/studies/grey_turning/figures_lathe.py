"""Pictures of the whole lathe: Figure 8 redrawn, its three loops together, and the converter's part in the error."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, VERMILION
from leadscrew.studies.grey_turning.claims_lathe import BITS, GPFC6, GPFC9, TFC6, TFC9, converter_errors
from leadscrew.studies.grey_turning.lathe import FORCE_N, RPM, LatheRuns
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def lathe_pictures(found: LatheRuns) -> list[Picture]:
    """Three pictures."""
    return [
        Picture(
            "fig8_depth", "Figure 8 redrawn: depth of cut under the GPFC, 0.2 mm less every 2 s", partial(depth, found)
        ),
        Picture(
            "three_loops",
            "Spindle speed, force and depth under three coupled loops: falling depth, droop of 2.5 1/min per N m",
            partial(three_loops, found),
        ),
        Picture(
            "dac_steady_error",
            "Steady error of the force at 1 mm over the resolution of the converters, with load-cell noise and runout "
            "(filled) and without (open). Dotted: what the paper reports",
            partial(converters, found),
        ),
    ]


def depth(found: LatheRuns) -> Figure:
    """One panel."""
    from matplotlib.figure import Figure

    run = found.staircase(GPFC9, 4, droop=0.0, noise_n=0.0)
    figure = Figure(figsize=(7.0, 3.0), layout="constrained")
    axes = figure.subplots()
    part = run.time < 8.0
    wanted = 1.0 - 0.2 * np.floor(run.time / 2.0 + 1e-9)
    axes.step(run.time[part], wanted[part], where="post", color=BLACK, linestyle=":", label="programme")
    axes.plot(run.time[part], run["actual.depth"][0, part], color=BLUE, label="depth, GPFC")
    axes.set(xlabel="time (s)", ylabel="depth of cut (mm)", ylim=(0.0, 1.1), xlim=(0.0, 8.0))
    axes.legend(frameon=False, loc="lower left")
    axes.grid(color="0.92", linewidth=0.6)
    return figure


def three_loops(found: LatheRuns) -> Figure:
    """Three panels over one time axis."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 6.4), layout="constrained")
    speed, force, cut = figure.subplots(3, 1, sharex=True)
    for tuning, shade, name in ((TFC9, VERMILION, "TFC, S9"), (GPFC9, BLUE, "GPFC, S9")):
        run = found.staircase(tuning, runs=20)
        speed.plot(run.time, run["actual.rpm"][0], color=shade, label=name)
        force.plot(run.time, run["feedback.force"][0], color=shade)
        cut.plot(run.time, run["actual.depth"][0], color=shade)
    speed.axhline(RPM, color=BLACK, linestyle=":", linewidth=0.9)
    force.axhline(FORCE_N, color=BLACK, linestyle=":", linewidth=0.9)
    speed.set(ylabel="spindle (1/min)")
    force.set(ylabel="force, filtered (N)", ylim=(0.0, 250.0))
    cut.set(ylabel="depth of cut (mm)", xlabel="time (s)", ylim=(0.0, 1.1), xlim=(0.0, 8.0))
    speed.legend(frameon=False, loc="lower right", ncols=2)
    for axes in (speed, force, cut):
        axes.grid(color="0.92", linewidth=0.6)
    return figure


def converters(found: LatheRuns) -> Figure:
    """One panel."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 3.4), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(BITS))
    for tuning, shade, name, paper in ((TFC6, VERMILION, "TFC, S6", 1.7), (GPFC6, BLUE, "GPFC, S6", 1.0)):
        axes.plot(places, converter_errors(found, tuning, False), "o-", color=shade, label=name)
        axes.plot(places, converter_errors(found, tuning, True), "o--", color=shade, markerfacecolor="white")
        axes.axhline(paper, color=shade, linestyle=":", label=f"paper, {name.split(',')[0]}")
    axes.set_xticks(places, ["ideal", *(f"{n}" for n in BITS[1:])])
    axes.set(
        xlabel="resolution of the converters (bits over 20 V)", ylabel="mean |error| (% of 150 N)", ylim=(0.0, 2.0)
    )
    axes.legend(frameon=False, ncols=2, loc="upper left", bbox_to_anchor=(0.0, 0.84))
    axes.grid(color="0.92", linewidth=0.6)
    return figure
