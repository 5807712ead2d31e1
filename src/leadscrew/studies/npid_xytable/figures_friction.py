"""Pictures of friction: errors through a reversal, the circle magnified, what a wrong belief of friction leaves."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, PERIOD_S
from leadscrew.studies.npid_xytable.friction_runs import COUNTS, RADIUS_MM, WRONG, FrictionRuns
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PENS = {
    "paper.pid": ("PID, Table I", VERMILION, "--"),
    "corrected.npid_um": ("NPID (um)", BLUE, "-"),
    "retuned": ("retuned PID", ORANGE, "-"),
    "full": ("retuned, feed-forward, 21 resonators", GREEN, "-"),
    "by_sign": ("retuned, friction by sign", SKY, "-"),
    "learned": ("retuned, learned feed-forward", BLACK, "-"),
}
WIDE_MM = 4.0
"""Of the drawing's radius, for the largest deviation."""


def friction_pictures(runs: FrictionRuns) -> list[Picture]:
    """Three pictures."""
    return [
        Picture(
            "friction_reversal",
            "Error around a reversal, 15 mm at 0.7 Hz against 150 mV of LuGre friction: the bristles turn over within "
            "about 8 ms. Right: the best two again, the learned one read by an encoder of 0.5 um",
            partial(reversal, runs),
        ),
        Picture(
            "friction_circle",
            "A circle of 10 mm at 0.7 Hz, friction of 20 mV, Y with 10 % less gain: contour error magnified. The "
            "printed gains are off everywhere, the retuned PID at the four reversals, the learned feed-forward nowhere",
            partial(drawn_circles, runs),
        ),
        Picture(
            "friction_robust",
            "Learned feed-forward, 15 mm against 150 mV, where the axis or the belief is off: it learns size of "
            "friction, inertia and damping, not the presliding travel",
            partial(robust, runs),
        ),
    ]  # fmt: skip


def reversal(runs: FrictionRuns) -> Figure:
    """Left all four, right the best two."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 3.6), layout="constrained")
    panels = figure.subplots(1, 2)
    # 15 sin(2 pi 0.7 t) turns back at odd quarters of a period; the last one that has 100 ms behind it.
    end = 30.0
    turns = (np.arange(0.25, BASE_HZ * end, 0.5)) / BASE_HZ
    turn = turns[turns < end - 0.15][-1]
    time = end - PERIOD_S * np.arange(COUNTS, 0, -1)
    seen = (time > turn - 0.02) & (time < turn + 0.1)
    traces = {name: runs.table[name].error[3] for name in ("paper.pid", "corrected.npid_um", "retuned", "full")}
    traces["learned"] = runs.learned.error[0]
    for axes, names in ((panels[0], tuple(traces)[:4]), (panels[1], ("full", "learned"))):
        for name in names:
            label, shade, line = PENS[name]
            axes.plot(1e3 * (time[seen] - turn), traces[name][seen], color=shade, linestyle=line, label=label)
        axes.axvline(0.0, color="0.7", linewidth=0.8)
        axes.grid(color="0.92", linewidth=0.6)
        axes.set(xlabel="time from the reversal (ms)", ylabel="error (um)")
    handles = {label: h for axes in panels for h, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(
        list(handles.values()), list(handles), loc="outside lower center", ncols=3, frameon=False, fontsize="small"
    )
    return figure


def drawn_circles(runs: FrictionRuns) -> Figure:
    """Three circles, each to its own scale."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    panels = figure.subplots(1, 3)
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    for axes, names in zip(
        panels, (("paper.pid", "corrected.npid_um"), ("retuned", "by_sign"), ("learned",)), strict=True
    ):
        most = max(runs.circles[name].largest for name in names)
        step = float(f"{most:.0e}")
        axes.plot(RADIUS_MM * np.cos(angle), RADIUS_MM * np.sin(angle), color="0.6", linewidth=0.8)
        for name in names:
            turn = runs.circles[name].test.ccw
            assert turn is not None
            label, shade, line = PENS[name]
            around = np.arctan2(turn.y_mm, turn.x_mm)
            grown = RADIUS_MM + WIDE_MM / step * 1e3 * (np.hypot(turn.x_mm, turn.y_mm) - RADIUS_MM)
            axes.plot(
                grown * np.cos(around), grown * np.sin(around), color=shade, linestyle=line, linewidth=1.2, label=label
            )
        axes.plot([-0.5 * WIDE_MM, 0.5 * WIDE_MM], [0.0, 0.0], color=PURPLE, linewidth=2.0)
        axes.text(0.0, -0.5, f"{step:g} um", color=PURPLE, ha="center", va="top", fontsize="small")
        axes.set_aspect("equal")
        axes.set(xlabel="x (mm)", xlim=(-15.5, 15.5), ylim=(-15.5, 15.5))
        axes.legend(frameon=False, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.16))
    panels[0].set_ylabel("y (mm)")
    return figure


def robust(runs: FrictionRuns) -> Figure:
    """A bar a case."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 4.8), layout="constrained")
    axes = figure.subplots()
    names = (
        "as believed", "friction +20 %", "friction -20 %", "presliding +20 %", "presliding -20 %", "gain -10 %",
        *(f"gain -10 %, friction {f} %, presliding {z} %" for f in ("-20", "+20") for z in ("-20", "+20")),
        "F_S / F_C 1.0", "F_S / F_C 1.5",
        *(f"believed: {what}" for what in WRONG),
    )  # fmt: skip
    places = np.arange(len(names))[::-1]
    axes.barh(places + 0.2, runs.learned.rms, 0.4, color=BLACK, label="rms")
    axes.barh(places - 0.2, runs.learned.largest, 0.4, color=SKY, label="largest")
    axes.axvline(1.0, color=VERMILION, linestyle=":", label="M5: rms below 1 um")
    axes.axvline(float(runs.table["full"].rms[3]), color=GREEN, linestyle="--", label="21 resonators, rms")
    axes.set(xscale="log", xlabel="error (um)", ylabel="the axis", xlim=(0.05, 30.0))
    axes.set_yticks(places, names)
    axes.grid(axis="x", color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    return figure
