"""Pictures of backlash: Figures 1 and 2 of the paper, and Figure 19 from loops closed on either encoder or on both."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.plants.backlash import DeadBand, reaction
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.studies.fsmc_ballscrew import backlash_runs as b
from leadscrew.studies.fsmc_ballscrew import impacts as m
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.study import Picture

SHOWN: tuple[tuple[str, float, str, dict[str, Any]], ...] = (
    ("ours.pd_dob", b.MOTOR, "motor encoders", {"color": VERMILION, "linestyle": "--"}),
    ("ours.pd_dob_fixed", b.TABLE, "linear encoders, ours.pd_dob_fixed", {"color": BLUE, "linestyle": "-"}),
    ("ours.fsmc_4khz", b.TABLE, "linear encoders, ours.fsmc_4khz", {"color": ORANGE, "linestyle": "-"}),
    ("ours.pd_dob", 1e-3, "both encoders (1 ms)", {"color": GREEN, "linestyle": "-."}),
)
"""Controller, lag of the table's reading, words, pen."""


def backlash_pictures(loops: Loops) -> list[Picture]:
    """Drawn on demand."""
    return [
        Picture("fig1_backlash_classical", "Figure 1 redrawn: reaction against action of the classical backlash, a "
                "dead band whose gaps and slopes differ by side.", fig1),
        Picture("fig2_backlash_modern", "Figure 2 redrawn: dead band and almost elastic impact. After a reversal of "
                "sin 2 pi t mm the screw crosses 2 um of play, hits the table, and the table bounces.",
                partial(fig2, loops)),
        Picture("fig19_compensated_reversal", "Figure 19 redrawn: circle of 1 mm at 1 Hz with 2 um of play on both "
                "axes. With motor encoders the step of half the play stays; with linear encoders it is compensated, "
                "which takes time and leaves peaks.", partial(fig19, loops)),
        Picture("backlash_reversals", "Error of the table after one reversal, the classic play in the loop at 4 kHz.",
                partial(after_reversal, loops)),
    ]  # fmt: skip


def fig1() -> Figure:
    """Reaction against twist."""
    figure = Figure(figsize=(5.2, 3.8), layout="constrained")
    axes = figure.subplots()
    twist = np.linspace(-5.0, 5.0, 501)
    bands: tuple[tuple[DeadBand, str, dict[str, Any]], ...] = (
        (DeadBand(1.0, 1.0, 1e8, 1e8), "1 um and 100 N/um each side", {"color": BLUE, "linestyle": "-"}),
        (DeadBand(0.5, 2.5, 1.5e8, 6e7), "0.5 um, 150 N/um; 2.5 um, 60 N/um", {"color": ORANGE, "linestyle": "--"}),
    )
    for band, label, pen in bands:
        axes.plot(twist, [1e-6 * reaction(band, float(d)) for d in twist], label=label, **pen)
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.axvline(0.0, color="0.6", linewidth=0.8)
    axes.set(xlabel="action: screw minus table (um)", ylabel="reaction: force on the table (N)")
    axes.legend(frameon=False, loc="upper left", fontsize="small")
    axes.grid(color="0.92", linewidth=0.6)
    return figure


def fig2(loops: Loops) -> Figure:
    """Twist and force after a reversal."""
    figure = Figure(figsize=(8.6, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for e, pen in ((0.9, {"color": BLUE, "linestyle": "-"}), (0.05, {"color": VERMILION, "linestyle": "--"})):
        found = m.impact(loops, "sine_fast", e)
        near = (found.since_s > -0.005) & (found.since_s < 0.08)
        for axes, y in ((left, found.twist_um), (right, found.beyond_um)):
            axes.plot(1e3 * found.since_s[near], y[near], linewidth=1.2, label=f"restitution {e:g}", **pen)
    for level in (-1.0, 1.0):
        left.axhline(level, color="0.6", linewidth=0.8)
    left.text(79.0, 0.97, "flanks", color="0.4", ha="right", va="top")
    for axes in (left, right):
        axes.axvline(1e3 * m.crossing_of_parabola("sine_fast"), color=BLACK, linestyle=":", linewidth=1.0,
                     label="sqrt(2 b / (R w^2)) = 10.07 ms")  # fmt: skip
        axes.set_xlabel("time after the reversal of the screw (ms)")
        axes.grid(color="0.92", linewidth=0.6)
    left.set(ylabel="screw minus table (um)", title="dead band and impact")
    right.set(ylabel="table minus classical play (um)", title="what the impact adds")
    right.legend(frameon=False, loc="lower right", fontsize="small")
    return figure


def fig19(loops: Loops) -> Figure:
    """Radius against angle on a polar plot, and around one reversal."""
    figure = Figure(figsize=(9.4, 4.8), layout="constrained")
    polar: Any = figure.add_subplot(1, 2, 1, projection="polar")
    plain = figure.add_subplot(1, 2, 2)
    zero = 4.0
    for controller, lag, words, pen in (SHOWN[0], SHOWN[1], SHOWN[3]):
        run = b.backlash_run(loops, controller, "sine_fast", "play", lag, 2.25)
        turn = b.circle(run, 1.0).ccw
        assert turn is not None
        angle, deviation = turn.angle, turn.deviation_um(1.0)
        polar.plot(angle, zero + deviation, linewidth=1.1, label=words, **pen)
        plain.plot(np.degrees(angle), deviation, linewidth=1.1, **pen)
    every = np.linspace(0.0, 2.0 * math.pi, 361)
    polar.plot(every, np.full_like(every, zero), color="0.5", linewidth=0.8, linestyle=":", label="nominal circle")
    polar.set_ylim(0.0, zero + 2.0)
    polar.set_yticks([zero - 2.0, zero, zero + 2.0], ["-2", "0", "2 um"])
    polar.set_rlabel_position(22.5)
    polar.grid(color="0.9", linewidth=0.6)
    plain.axhline(0.0, color="0.5", linewidth=0.8, linestyle=":")
    plain.set(
        xlabel="angle (degrees)", ylabel="radius less 1 mm (um)", xlim=(60.0, 130.0), title="reversal of the Y axis"
    )
    plain.grid(color="0.92", linewidth=0.6)
    polar.set_title("circle of 1 mm, 377 mm/min", fontsize="medium")
    figure.legend(
        *polar.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False, fontsize="small"
    )
    return figure


def after_reversal(loops: Loops) -> Figure:
    """Error against time for the fast sine and the wide one."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, (name, seconds, words) in zip(
        panels, (("sine_fast", 2.25, "sin 2 pi t mm"), ("sine_wide", 7.9, "5 sin t mm")), strict=True
    ):
        at = 2.5 * math.pi / m.SINES[name][1] if name == "sine_fast" else 1.5 * math.pi
        for controller, lag, label, pen in SHOWN:
            run = b.backlash_run(loops, controller, name, "play", lag, seconds)
            near = (run.time > at - 0.02) & (run.time < at + 0.08)
            way = -1.0 if name == "sine_wide" else 1.0
            axes.plot(1e3 * (run.time[near] - at), way * b.error_um(run)[near], linewidth=1.1, label=label, **pen)
        axes.axhline(0.0, color="0.5", linewidth=0.8, linestyle=":")
        axes.set(xlabel="time after the reversal (ms)", title=words)
        axes.grid(color="0.92", linewidth=0.6)
    panels[0].set_ylabel("error of the table (um)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False,
                  fontsize="small")  # fmt: skip
    return figure
