"""Figures 7 to 10 redrawn, the rules as surfaces, and from where the fuzzy law comes back."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from leadscrew.friction.lugre import LuGre
from leadscrew.plants.ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.studies.fsmc_ballscrew.attraction import HOME_UM, LOADS, STEPS_MM, SYSTEMS, Region, hold, region
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.study import Picture

SETS = {"N": VERMILION, "Z": GREEN, "P": BLUE, "NB": VERMILION, "NS": ORANGE, "ZO": GREEN, "PS": SKY, "PB": BLUE}
WORDS = {"printed": "as printed", "corrected": "corrected", "without_dead_corner": "without the dead corner"}
LAYERS = {"corrected.smc": (VERMILION, 1.0, "SMC"), "paper.csmc": (BLUE, 0.5, "CSMC")}
"""Colour, half width of the layer in phi, short name."""


def fuzzy_pictures(loops: Loops) -> list[Picture]:
    """Boundary layer, sets, scaling, surfaces, region of attraction."""
    return [
        Picture("fig7_boundary_layer",
                "Figure 7 with motions in it: a bare step of 1 mm under SMC and CSMC. Both come down the line of slope "
                "-lam and stop in their layers, CSMC in the one of half the width.", partial(_layer, loops)),
        Picture("fig8_9_sets",
            "Figures 8 and 9: the sets of both inputs, over their scales, and of the output, over U. "
                "The figures' scales are not known.", _sets),
        Picture("fig10_scaling", "Figure 10: what the scales do. The fuzzy torque over s alone and over s_c alone, and "
                "over the integral at rest on the target (s = -s_c): with equal scales the corrected rules do not see "
                "it, with S_c = 4 S they do up to the corner, the printed ones and those without the corner always.",
                _scaling),
        Picture("rule_surfaces",
            "The rule bases as surfaces. The printed one acts along s - s_c, the corrected one along "
                "s + s_c, as the complementary law does. On s = -s_c the stage rests on its target, and K must not be "
                "0 or "
                "nothing holds the friction: dashed with S_c = S, dash-dotted with S_c = 4 S.", _surfaces),
        Picture("attraction",
            "From where the stage comes back to within 1 um in 0.5 s: a step and a load that comes on "
                "with it, U = 120 N m, S_c = 4 S. Dotted: what the rules can hold at rest less static friction, "
                "U K - F_S. Below it the rules without the dead corner come back from everywhere.",
                partial(_attraction, loops)),
    ]  # fmt: skip


def _layer(loops: Loops) -> Figure:
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    panels = figure.subplots(1, 2)
    lam, phi = 150.0, 0.1
    per_rad = 1e3 * TRAVEL_MM_PER_RAD
    for law, (colour, half, name) in LAYERS.items():
        run = loops.run(law, "step_raw", 0.2, ("true_error", "plant.speed"), sample=2e-5)
        e, rate = -1e3 * run["true_error"], TRAVEL_MM_PER_RAD * run["plant.speed"]
        for axes in panels:
            axes.plot(e, rate, color=colour, linewidth=1.2, label=f"{name}, step of 1 mm")
            x = np.array([-1200.0, 200.0])
            for side in (-1.0, 1.0):
                axes.plot(x, TRAVEL_MM_PER_RAD * (side * half * phi - lam * x / per_rad), color=colour, linestyle=":",
                          linewidth=1.1, label=f"layer of {name}" if side > 0 else None)  # fmt: skip
    for axes in panels:
        axes.axhline(0.0, color=BLACK, linewidth=0.5)
        axes.axvline(0.0, color=BLACK, linewidth=0.5)
        axes.set_xlabel("e (um)")
        axes.set_ylabel("e' (mm/s)")
    panels[0].set_xlim(-1050.0, 60.0)
    panels[0].set_title("the whole step", fontsize="medium")
    width = per_rad * phi / lam
    panels[1].set_xlim(-2.2, 2.2)
    panels[1].set_ylim(-0.45, 0.45)
    panels[1].set_title(f"near the target: phi / lam = {width:.2f} um, half of it for CSMC", fontsize="medium")
    panels[1].legend(fontsize="small", loc="lower left")
    return figure


def _sets() -> Figure:
    figure = Figure(figsize=(9.0, 3.0), layout="constrained")
    panels = figure.subplots(1, 2)
    system = SYSTEMS["corrected"]
    for axes, variable, reach, label in (
        (panels[0], system.inputs[0], 1.3, "s / S,  s_c / S_c (1)"),
        (panels[1], system.outputs[0], 1.6, "K (1)"),
    ):
        x = np.linspace(-reach, reach, 1301)
        for term in variable.terms:
            low, peak, high = term.parameters
            left = np.ones_like(x) if np.isinf(low) else np.clip((x - low) / (peak - low), 0.0, 1.0)
            right = np.ones_like(x) if np.isinf(high) else np.clip((high - x) / (high - peak), 0.0, 1.0)
            axes.plot(x, np.minimum(left, right), color=SETS[term.name], linewidth=1.4)
            axes.text(peak, 1.04, term.name, ha="center", color=SETS[term.name])
        axes.set_ylim(0.0, 1.18)
        axes.set_xlabel(label)
    panels[0].set_ylabel("membership (1)")
    panels[0].set_title("Figure 8: inputs", fontsize="medium")
    panels[1].set_title("Figure 9: output", fontsize="medium")
    return figure


def _torque(rules: str, s: np.ndarray, s_c: np.ndarray, ratio: float) -> np.ndarray:
    return np.asarray(120.0 * SYSTEMS[rules].many(s=s / 0.65, s_c=s_c / (0.65 * ratio)))


def _scaling() -> Figure:
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    x, none = np.linspace(-4.0, 4.0, 401), np.zeros(401)
    for axes, s, s_c, label in (
        (panels[0], x, none, "s, with s_c = 0 (rad/s)"),
        (panels[1], none, x, "s_c, with s = 0 (rad/s)"),
    ):
        axes.plot(x, _torque("corrected", s, s_c, 4.0), color=BLUE, label="corrected, S_c = 4 S")
        axes.plot(x, _torque("printed", s, s_c, 4.0), color=VERMILION, linestyle="--", label="printed, S_c = 4 S")
        axes.set_xlabel(label)
    for rules, ratio, colour, line in (
        ("corrected", 4.0, BLUE, "-"), ("printed", 4.0, VERMILION, "--"), ("corrected", 1.0, ORANGE, "-"),
        ("without_dead_corner", 4.0, GREEN, "-."),
    ):  # fmt: skip
        panels[2].plot(
            x, _torque(rules, x, -x, ratio), color=colour, linestyle=line, label=f"{WORDS[rules]}, S_c = {ratio:g} S"
        )
    panels[2].set_xlabel("s = -s_c = lam^2 xi (rad/s)")
    panels[0].set_ylabel("U K (N m)")
    for axes in panels:
        axes.axhline(0.0, color=BLACK, linewidth=0.5)
        axes.grid(linewidth=0.3)
    panels[0].legend(fontsize="small")
    lines, labels = panels[2].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower right", ncols=4, fontsize="small", title="right panel")
    return figure


def _surfaces() -> Figure:
    figure = Figure(figsize=(11.0, 3.9), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    x = np.linspace(-1.25, 1.25, 201)
    shade: Any = None
    for axes, (rules, words) in zip(panels, WORDS.items(), strict=True):
        k = SYSTEMS[rules].many(s=x[None, :], s_c=x[:, None])
        shade = axes.pcolormesh(x, x, k, cmap="RdBu", vmin=-1.0, vmax=1.0, shading="auto", rasterized=True)
        lines = axes.contour(x, x, k, levels=[-0.75, -0.5, -0.25, 0.25, 0.5, 0.75], colors=BLACK, linewidths=0.5)
        axes.clabel(lines, fontsize="xx-small")
        axes.plot(x, -x, color=BLACK, linestyle="--", linewidth=1.2)
        axes.plot(x, -x / 4.0, color=BLACK, linestyle="-.", linewidth=1.2)
        axes.set_title(words, fontsize="medium")
        axes.set_xlabel("s / S (1)")
        axes.set_aspect("equal")
    panels[0].set_ylabel("s_c / S_c (1)")
    figure.colorbar(shade, ax=list(panels), label="K (1)", shrink=0.85)
    return figure


def _attraction(loops: Loops) -> Figure:
    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    steps, forces = np.log10(STEPS_MM), np.array(LOADS)
    edges = np.append(steps - 0.5, steps[-1] + 0.5), np.append(forces - 2.5, forces[-1] + 2.5)
    bands = [0.0, HOME_UM, 30.0, 300.0, 1e9]
    colours = ListedColormap(["#DDEEDD", "#F3D9A4", "#E69F00", "#8B3A00"])
    shade: Any = None
    for axes, (rules, words) in zip(panels, WORDS.items(), strict=True):
        found: Region = region(loops, rules)
        shade = axes.pcolormesh(*edges, np.minimum(found.left_um, 1e8).T, cmap=colours, norm=BoundaryNorm(bands, 4))
        limit = 120.0 * hold(rules, 4.0) - LuGre().static
        if limit < forces[-1]:
            axes.axhline(limit, color=BLACK, linestyle=":", linewidth=1.6)
        axes.set_title(words, fontsize="medium")
        axes.set_xlabel("error at the start (mm)")
        axes.set_xticks(steps, [f"{e:g}" for e in STEPS_MM])
    panels[0].set_ylabel("load (N m)")
    bar = figure.colorbar(shade, ax=list(panels), shrink=0.85, spacing="uniform", ticks=bands[:-1])
    bar.ax.set_yticklabels(["0", "1", "30", "300"])
    bar.set_label("error after 0.5 s (um)")
    figure.suptitle(f"S = 0.65 rad/s, S_c = 4 S, U = 120 N m, J = {INERTIA:.3g} kg m^2", fontsize="small")
    return figure
