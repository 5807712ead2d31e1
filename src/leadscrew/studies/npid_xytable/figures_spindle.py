"""Pictures of the spindle sweep: errors at the lines against speed, and what a resonator at a folded line does."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable.spindle_sweep import (
    APART,
    FOLDS_RPM,
    NYQUIST_HZ,
    RPM,
    SWEPT,
    TOOTH_MV,
    SpindleSweep,
    line,
    seen_hz,
    tooth_hz,
)
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PENS = {
    "paper.pid": ("PID, Table I", VERMILION, "o"),
    "corrected.npid_um": ("NPID (um)", BLUE, "s"),
    "ours.pid_ms_159": ("retuned PID, Ms 1.59", ORANGE, "^"),
    "ours.pid_ms_185": ("retuned PID, Ms 1.85", PURPLE, "v"),
    "resonant": ("Ms 1.59 with resonators", GREEN, "D"),
}


def spindle_pictures(found: SpindleSweep) -> list[Picture]:
    """Two pictures."""
    return [
        Picture(
            "spindle_sweep",
            "Error at the lines of spindle (1 mV) and four teeth (2 mV) from 500 to 24,000 1/min: simulated (marks) "
            "and "
            "in closed form (lines). Beyond the dashed line the teeth pass above half the control rate and are "
            "measured "
            "where they fold to; there they have no resonator",
            partial(swept, found),
        ),
        Picture(
            "spindle_folding",
            "Left: where the teeth stand in samples at 2 kHz. Right: motion of the table, 2 mV at the teeth, under a "
            "resonator at the folded frequency: the samples show nothing, the table moves at two frequencies",
            folding,
        ),
    ]


def swept(found: SpindleSweep) -> Figure:
    """Two panels over one axis."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 6.0), layout="constrained")
    for axes, what in zip(figure.subplots(2, 1, sharex=True), ("spindle", "tooth"), strict=True):
        for name in SWEPT:
            label, shade, mark = PENS[name]
            values = np.where(APART, getattr(found.swept[name], what), np.nan)
            axes.plot(RPM, values, mark, color=shade, markersize=4, label=label)
            if name in found.expected:
                axes.plot(RPM, np.where(APART, getattr(found.expected[name], what), np.nan), color=shade, linewidth=0.9)
        if what == "tooth":
            axes.axvline(FOLDS_RPM, color=BLACK, linestyle="--", linewidth=0.9)
            axes.text(FOLDS_RPM * 0.97, 1.2, "teeth at 1 kHz", ha="right", va="center", fontsize="small")
            axes.set_xlabel("spindle speed (1/min)")
        axes.set(xscale="log", yscale="log", ylim=(1e-5, 5.0), ylabel=f"error at the {what} line (um)")
        axes.grid(color="0.92", linewidth=0.6)
    axes.set_xticks((500, 1000, 2000, 5000, 10000, 24000), ("500", "1,000", "2,000", "5,000", "10,000", "24,000"))
    axes.minorticks_off()
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure


def folding() -> Figure:
    """Two panels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    rpm = np.linspace(500.0, 24_000.0, 471)
    left.plot(rpm, [tooth_hz(r) for r in rpm], color="0.6", linestyle=":", label="teeth")
    left.plot(rpm, [seen_hz(tooth_hz(r)) for r in rpm], color=BLUE, label="in the samples")
    left.plot(rpm, rpm / 60.0, color=ORANGE, linestyle="-.", label="spindle")
    left.axhline(NYQUIST_HZ, color=BLACK, linestyle="--", linewidth=0.9, label="half the control rate")
    left.set(xlabel="spindle speed (1/min)", ylabel="frequency (Hz)")
    left.legend(frameon=False, fontsize="small")
    hz = np.linspace(1010.0, 1990.0, 99)
    plain = [line(SWEPT["ours.pid_ms_159"], f) for f in hz]
    ghosts = [line(SWEPT["ours.pid_ms_159"], f, cancelled=True) for f in hz]
    nm = 1e3 * TOOTH_MV
    right.plot(hz, [nm * np.sqrt(2.0) * x.rms for x in plain], color=VERMILION, label="no resonator")
    right.plot(hz, [nm * x.own for x in ghosts], color=SKY, linestyle="--", label="at the teeth, with it")
    right.plot(hz, [nm * x.ghost for x in ghosts], color=BLACK, linestyle=":", label="ghost, folded, with it")
    right.plot(hz, [nm * np.sqrt(2.0) * x.rms for x in ghosts], color=BLUE, label="both together")
    right.set(xlabel="frequency of the teeth (Hz)", ylabel="amplitude of the motion (nm)", ylim=(0.0, None))
    right.legend(frameon=False, fontsize="small")
    for axes in (left, right):
        axes.grid(color="0.92", linewidth=0.6)
    return figure
