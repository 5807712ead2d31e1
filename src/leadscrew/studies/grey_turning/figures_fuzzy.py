"""Pictures of the fuzzy controllers: Figure 3, the rules with product and minimum, stable gains, the comparison."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.controllers.grey_fuzzy.rule_tables import SETS, STANDARD
from leadscrew.controllers.grey_fuzzy.surface import CENTRES, MINIMUM, PRODUCT
from leadscrew.controllers.grey_fuzzy.tfc import tfc
from leadscrew.controllers.grey_fuzzy.tunings import FACTORS
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, pen
from leadscrew.studies.grey_turning.claims_fuzzy import answers
from leadscrew.studies.grey_turning.claims_fuzzy_margins import NAMES
from leadscrew.studies.grey_turning.linear_force_loop import first_part
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture

LINES = {"tfc": (VERMILION, "-"), "gpfc_b": (BLUE, "--"), "gpfc_a": (SKY, "-."), "two_point": (GREEN, ":")}
"""Pens of the laws where the whole law and not a tuning is meant."""
SHOWN = {"plant_f": ("s6", "s9", "s9_half", "stfc", "sg"), "plant_n": ("s6n", "sbn", "edge_n", "stfc_n")}
BESIDE = {"s9_half": (-24, 6), "sg": (5, 3), "s9": (-14, 4), "stfc": (5, -10), "stfc_n": (5, -10)}
"""Where the name of a factor set stands, in points from its dot."""
COMPARED = ("corrected.tfc_stfc", "corrected.gpfc_b_sg", "ours.two_point_stfc", "ours.smith_f")


def fuzzy_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("fig3_sets", "The paper's Figure 3: seven sets with peaks every two scaling factors, the same for "
                "error, change and output; the outer ones stay 1.", membership_functions),
        Picture("rule_surface", "What the 49 rules of the standard table say, in S3. Left: with the product it is a "
                "plane held to 6 S3. Middle: what the minimum adds. Right: a cut, the change at 1 S2.", rule_surface),
        Picture("stable_gains", "Gains of the PI that each law is near the set-point: stable below its curve. Dots are "
                "the factor sets. Left plant F, right plant N.", stable_gains),
        Picture("comparison_controllers", "Entry into the cut on plant F, 1 mm, one noise seed: fuzzy controller, grey "
                "prediction, two-point prediction and Smith predictor.", partial(comparison, loops)),
    ]  # fmt: skip


def membership_functions() -> Figure:
    """Memberships against the signal in scaling factors."""
    figure = Figure(figsize=(7.6, 3.2), layout="constrained")
    axes = figure.subplots()
    x = np.linspace(-8.0, 8.0, 641)
    pens = (BLACK, PURPLE, GREEN, BLUE, SKY, ORANGE, VERMILION)
    for k, (name, colour) in enumerate(zip(SETS, pens, strict=True)):
        peak = np.eye(len(SETS))[k]
        axes.plot(x, np.interp(x, CENTRES, peak), color=colour)
        axes.text(CENTRES[k], 1.04, name, color=BLACK, ha="center")
    axes.set(xlabel="e / S1, ec / S2, u / S3", ylabel="membership", ylim=(0.0, 1.18), xlim=(-8.0, 8.0))
    axes.set_xticks(np.arange(-8, 9, 2))
    axes.grid(alpha=0.3)
    return figure


def rule_surface() -> Figure:
    """Surface with the product, what the minimum adds, and a cut."""
    figure = Figure(figsize=(11.0, 3.8), layout="constrained")
    whole, added, cut = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.1))
    axis = np.linspace(-7.0, 7.0, 113)
    product, minimum = (answers(tfc(inference=kind), axis, axis) for kind in (PRODUCT, MINIMUM))
    for axes, z, colours, levels in (
        (whole, product, "cividis", np.arange(-6.0, 6.1, 1.0)),
        (added, minimum - product, "cividis", np.linspace(-0.35, 0.35, 8)),
    ):
        filled = axes.contourf(axis, axis, z, levels=levels, cmap=colours, extend="both")
        figure.colorbar(filled, ax=axes, label="output (S3)")
        axes.set(xlabel="ec (S2)", ylabel="e (S1)")
        axes.set_xticks(np.arange(-6, 7, 2))
        axes.set_yticks(np.arange(-6, 7, 2))
    for i, e in enumerate(CENTRES):
        for j, ec in enumerate(CENTRES):
            light = STANDARD[i, j] <= 0.0
            whole.text(ec, e, SETS[int(STANDARD[i, j]) + 3], ha="center", va="center", fontsize="x-small",
                       color="white" if light else BLACK)  # fmt: skip
    fine = np.linspace(-7.0, 7.0, 561)
    for kind, colour, style, name in ((PRODUCT, BLUE, "-", "product (17)"), (MINIMUM, VERMILION, "--", "minimum (16)")):
        cut.plot(fine, answers(tfc(inference=kind), fine, np.array([1.0]))[:, 0], color=colour, linestyle=style,
                 label=name)  # fmt: skip
    cut.set(xlabel="e (S1)", ylabel="output (S3), ec = 1 S2")
    cut.legend(frameon=False, loc="upper left", fontsize="small")
    cut.grid(alpha=0.3)
    return figure


def stable_gains() -> Figure:
    """D-partition on both plants, with the factor sets."""
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    for axes, (machine, names) in zip(figure.subplots(1, 2), SHOWN.items(), strict=True):
        for law, (colour, style) in LINES.items():
            kp, ki = first_part(machine, law)
            axes.plot(1e3 * kp, 1e3 * ki, color=colour, linestyle=style, label=NAMES[law])
        for name in names:
            f = FACTORS[name]
            axes.plot([1e3 * f.kp], [1e3 * f.ki], "o", color=BLACK, markersize=4)
            axes.annotate(
                name,
                (1e3 * f.kp, 1e3 * f.ki),
                xytext=BESIDE.get(name, (5, 3)),
                textcoords="offset points",
                fontsize="small",
            )
        axes.set(xlabel="Kp (mV/N)", ylabel="Ki (mV/N a sample)", title=machine, xlim=(0.0, None), ylim=(0.0, None))
        axes.grid(alpha=0.3)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    return figure


def comparison(loops: Loops) -> Figure:
    """Filtered force and voltage of the entry."""
    figure = Figure(figsize=(8.0, 5.4), layout="constrained")
    force, volts = figure.subplots(2, 1, sharex=True)
    shown = round(1.0 / PERIOD_S)
    for name, style in zip(COMPARED, ("-", "--", ":", "-."), strict=True):
        run = loops.run(name, "fig6_fixed_depth")
        t = np.asarray(run.time)[:shown]
        look = pen(name) | {"linestyle": style}
        force.plot(t, np.asarray(run["feedback"])[:shown], **look)
        volts.plot(t, 1e3 * np.asarray(run["output"])[:shown], **(look | {"label": None}))
    force.axhline(150.0, color=BLACK, linewidth=0.8)
    force.set(ylabel="filtered force (N)", ylim=(0.0, 175.0))
    volts.set(xlabel="time (s)", ylabel="feed voltage (mV)", xlim=(0.0, 1.0))
    force.legend(frameon=False, loc="lower right", fontsize="small")
    for axes in (force, volts):
        axes.grid(alpha=0.3)
    return figure
