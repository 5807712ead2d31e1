"""The study's figures: those of the paper redrawn, its networks, delay and learning, and what learns between pieces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.panels import grid, with_legend
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, pen
from leadscrew.neural.inference_net import CENTRES, LABELS
from leadscrew.neural.inference_net import SETS as SET_COUNT
from leadscrew.neural.performance import GOLDEN, LEVELS, surface
from leadscrew.neural.performance import TABLE as TABLE_1
from leadscrew.neural.safety import FLATTEST, NEAR, STEEPEST, safety
from leadscrew.studies.exhibits import figure
from leadscrew.studies.lab import Lab
from leadscrew.studies.sofnn_tangent import curvature_rules, trainings
from leadscrew.studies.sofnn_tangent.claims import changed_deviation, step
from leadscrew.studies.sofnn_tangent.controllers import UNTUNED
from leadscrew.studies.sofnn_tangent.cuts import (
    FIXED,
    LESSONS,
    MAMDANI,
    NONE,
    PID,
    PNN,
    TABLE,
    TUNED,
    cells,
    first_rules,
    learned,
    mean_rms,
    texture_floor,
)
from leadscrew.studies.sofnn_tangent.delay import ASSUMED, K_E, TRUE, delay_map
from leadscrew.studies.sofnn_tangent.experiments import laps
from leadscrew.studies.sofnn_tangent.laws import even_part
from leadscrew.studies.sofnn_tangent.pieces import (
    ON_THE_OTHER_PLANT,
    SWAP_AT,
    WAYS,
    WITH_NEW_MATERIAL,
    series,
    swapped,
)
from leadscrew.studies.sofnn_tangent.scenarios import LAP_COUNT, LINES, MATERIAL_NAMES, SAMPLE_MM, line

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

# A line that only guides the eye: zero, a limit.
GUIDE: dict[str, Any] = {"color": "0.5", "linewidth": 0.8, "linestyle": ":", "zorder": 0}
SET_COLOURS = (VERMILION, ORANGE, GREEN, BLACK, SKY, BLUE, PURPLE)
MATERIAL_COLOURS = dict(zip(MATERIAL_NAMES, (BLUE, GREEN, VERMILION), strict=True))
MARKS = dict(zip(LINES, ("o", "^", "s"), strict=True))
WAY_PENS = dict(zip(WAYS, ((ORANGE, "s"), (BLUE, "o"), (BLACK, "D"), (PURPLE, "^"), (GREEN, "v")), strict=True))
RMS_TICKS = (0.2, 0.3, 0.5, 1.0, 2.0)


def plain_ticks(axes: Any, which: str, at: tuple[float, ...]) -> None:
    """A logarithmic scale with plain numbers."""
    getattr(axes, f"set_{which}scale")("log")
    getattr(axes, f"set_{which}ticks")(at, [f"{x:g}" for x in at])
    axes.minorticks_off()


# ---- the paper's figures
@figure("The seven sets of E, EC and D as reconstructed (Figure 3, which is missing in the text that we have).")
def fig3_membership_functions(lab: Lab) -> Figure:
    fig, axes = grid(7.0, 2.8)
    x = np.linspace(-7.0, 7.0, 561)
    for label, centre, peak, colour in zip(LABELS, CENTRES, np.eye(SET_COUNT), SET_COLOURS, strict=True):
        axes.plot(x, np.interp(x, CENTRES, peak), color=colour)
        axes.text(centre, 1.04, label, ha="center", color=colour)
    axes.set(xlabel="E, EC, D (level)", ylabel="membership (1)", xlim=(-7, 7), ylim=(0.0, 1.2), xticks=LEVELS)
    return fig


@figure("Answer to a step of the shear of −5°, with the areas of Figure 4 that the tuned network passes.")
def fig4_step_areas(lab: Lab) -> Figure:
    fig, axes = grid(7.0, 4.0)
    for name in (PNN, TABLE, TUNED, PID):
        run = step(lab, name)
        axes.plot(run.time - 1.0, run["actual.deviation"], **pen(name))
    run = step(lab, TUNED)
    t, e = run.time - 1.0, run["actual.deviation"]
    first, shade = int(np.argmin(e)), {"I": SKY, "II": ORANGE, "III": GREEN}
    rising = np.diff(e, prepend=e[0]) > 0.0
    area = np.where(e < 0.0, np.where(rising, "I", ""), np.where(rising, "II", "III"))
    for name, colour in shade.items():
        begin = first + int(np.flatnonzero(area[first:] == name)[0])
        end = begin + int(np.flatnonzero(area[begin:] != name)[0])
        axes.axvspan(t[begin], t[end], color=colour, alpha=0.3, linewidth=0.0)
        axes.text(0.5 * (t[begin] + t[end]), 1.15, name, ha="center")
    axes.axhline(0.0, **GUIDE)
    axes.set(xlabel="time after the step (s)", ylabel="deviation (°)", xlim=(-0.1, 1.5), ylim=(-5.0, 1.6))
    return with_legend(fig, axes, columns=4)


@figure("The line to be cut, a cubic B-spline, with its control polygon: it stands for Figure 5.")
def fig5_trajectory(lab: Lab) -> Figure:
    from leadscrew.paths.shapes import WAVE

    fig, axes = grid(7.0, 4.0)
    polygon, found = np.asarray(WAVE, dtype=float), line("wave")
    axes.plot(*polygon.T, "o--", color=VERMILION, markersize=4, linewidth=1.0, label="control polygon")
    axes.plot(found.x, found.y, color=BLACK, label="line to be cut")
    axes.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    return with_legend(fig, axes)


@figure("Tangential angle along the wave without compensation (Figure 6), and the deviation.")
def fig6_without_compensation(lab: Lab) -> Figure:
    fig, (upper, lower) = grid(7.0, 5.0, 2, 1, sharex=True)
    heading, way = line("wave").heading, SAMPLE_MM * np.arange(len(line("wave").heading))
    e = lab.run(NONE, "wave_fabric")["actual.deviation"][1 : len(way) + 1]
    upper.plot(way, heading, color="0.5", linestyle=":", label="programmed")
    upper.plot(way, heading + e, **pen(NONE))
    lower.plot(way, e, **pen(NONE))
    lower.axhline(0.0, **GUIDE)
    upper.set_ylabel("tangential angle (°)")
    lower.set(xlabel="distance along the line (mm)", ylabel="deviation (°)")
    return with_legend(fig, upper)


@figure("With compensation (Figure 7): deviation of the cut along the wave, and the offset angle.", key=True)
def fig7_with_compensation(lab: Lab) -> Figure:
    fig, (upper, lower) = grid(7.0, 5.0, 2, 1, sharex=True)
    for name in (NONE, PNN, TUNED, PID):
        run = lab.run(name, "wave_fabric")
        way = SAMPLE_MM * np.arange(len(run.time) - 1)
        upper.plot(way, run["actual.deviation"][1:], linewidth=1.2, **pen(name))
        if name != NONE:
            lower.plot(way, run["output"][:-1], linewidth=1.2, **pen(name))
    for axes in (upper, lower):
        axes.axhline(0.0, **GUIDE)
    upper.set_ylabel("deviation (°)")
    lower.set(xlabel="distance along the line (mm)", ylabel="offset angle (°)")
    return with_legend(fig, upper, columns=4)


# ---- the performance network
@figure("Table 1, the network of 18 weights that stands for it, and the difference. Framed: cells that are not odd.")
def table_1_and_network(lab: Lab) -> Figure:
    from matplotlib.patches import Rectangle

    fig, panels = grid(11.0, 4.0, 1, 3)
    network = surface(GOLDEN, *np.meshgrid(LEVELS, LEVELS))
    shown = (("Table 1", TABLE_1, 6.0), ("network, 18 weights", network, 6.0), ("difference", network - TABLE_1, 2.0))
    for axes, (title, values, most) in zip(panels, shown, strict=True):
        image = axes.imshow(values, origin="lower", extent=(-6.5, 6.5) * 2, cmap="RdBu", vmin=-most, vmax=most)
        fig.colorbar(image, ax=axes, label="P (level)", shrink=0.8)
        axes.set(xlabel="E (level)", title=title, xticks=LEVELS[::2], yticks=LEVELS[::2])
    panels[0].set_ylabel("EC (level)")
    uneven = (even_part(TABLE_1) != 0.0) & (np.abs(TABLE_1) >= np.abs(TABLE_1[::-1, ::-1]))
    for (i, j), value in np.ndenumerate(TABLE_1):
        colour = "white" if abs(value) > 4.0 else BLACK
        panels[0].text(
            j - 6, i - 6, f"{value:g}".replace("-", "−"), ha="center", va="center", fontsize=6.5, color=colour
        )
        if uneven[i, j]:
            panels[0].add_patch(Rectangle((j - 6.45, i - 6.45), 0.9, 0.9, fill=False, edgecolor=BLACK, linewidth=1.0))
    return fig


@figure(
    "Left: the correction along EC = 0 by networks that fit the cells about as well; two do not pass through zero, one "
    "has the wrong sign around it. Right: trainings of 18 weights; only the shaded slopes are safe."
)
def safe_and_unsafe_networks(lab: Lab) -> Figure:
    fig, (left, right) = grid(10.0, 5.0, 1, 2)
    e, nets = np.linspace(-3.0, 3.0, 301), trainings.nets()
    left.axvspan(-NEAR, NEAR, color=BLACK, alpha=0.06)
    left.plot(LEVELS[3:10], TABLE_1[6, 3:10], "o", color=BLACK, label="Table 1")
    left.plot(e, surface(GOLDEN, e, 0.0), color=BLUE, label="the controllers' own")
    for name, label, colour, dash in (
        ("min_rmse", "smallest RMSE", VERMILION, "--"),
        ("biased_up", "P(0, 0) > 0", ORANGE, "-."),
        ("biased_down", "P(0, 0) < 0", PURPLE, ":"),
    ):
        left.plot(e, surface(nets[name], e, 0.0), color=colour, linestyle=dash, label=label)
    left.set(xlabel="E (level)", ylabel="P(E, 0) (level)", ylim=(-4.5, 4.5))
    right.axhspan(-STEEPEST, -FLATTEST, color=GREEN, alpha=0.12)
    for method, label, colour, mark in (
        ("lm", "least squares", SKY, "o"),
        ("ga+lm", "genetic algorithm, least squares", PURPLE, "s"),
        ("cma_48k", "CMA-ES", GREEN, "^"),
        ("ga_80x600", "genetic algorithm", ORANGE, "v"),
    ):
        rows = trainings.of("18", method)
        right.plot([r.rmse for r in rows], [r.slope for r in rows], mark, color=colour, markersize=5, label=label)
    own = safety(GOLDEN)
    right.plot([own.rmse], [own.slope], "*", color=BLUE, markersize=13, linestyle="none")
    right.set(xlabel="RMSE (level)", ylabel="slope at the origin (1)", ylim=(-3.6, 1.0))
    for axes in (left, right):
        axes.axhline(0.0, **GUIDE)
    return with_legend(fig, left, right, columns=5, fontsize="small")


# ---- learning
@figure("Rules with Table 1 between its cells before learning, after five flowers in fabric, and the difference.")
def learned_rules(lab: Lab) -> Figure:
    fig, panels = grid(10.0, 3.9, 1, 3)
    before = first_rules(lab, TABLE).reshape(SET_COUNT, SET_COUNT)
    after = learned(lab, TABLE, "flower_fabric", LESSONS).weights[-1].reshape(SET_COUNT, SET_COUNT)
    shown = (("before", before), (f"after {LESSONS} pieces", after), ("difference", after - before))
    for axes, (title, values) in zip(panels, shown, strict=True):
        image = axes.imshow(values, cmap="PuOr", vmin=-8.0, vmax=8.0, origin="lower")
        axes.set(title=title, xlabel="E (set)")
        axes.set_xticks(range(SET_COUNT), LABELS)
        axes.set_yticks(range(SET_COUNT), LABELS)
        for (j, i), value in np.ndenumerate(values):
            if abs(value) > 0.005:
                colour = "white" if abs(value) > 5.5 else BLACK
                axes.text(i, j, f"{value:z.1f}".replace("-", "−"), ha="center", va="center", fontsize=7, color=colour)
    panels[0].set_ylabel("EC (set)")
    fig.colorbar(image, ax=list(panels), label="consequent (level)", shrink=0.8)
    return fig


@figure(f"Rules in the row EC = ZO after each of {LAP_COUNT} laps of the flower in fabric, and RMS of each lap.")
def rules_over_laps(lab: Lab) -> Figure:
    fig, panels = grid(9.0, 5.0, 2, 2, sharex=True, sharey="row", height_ratios=(3, 1))
    for (upper, lower), name in zip(panels.T, (TABLE, TUNED), strict=True):
        found, weights, _ = laps(lab, name)
        row = weights.reshape(-1, SET_COUNT, SET_COUNT)[:, SET_COUNT // 2]
        for values, label, colour in zip(row.T, LABELS, SET_COLOURS, strict=True):
            upper.plot(range(len(values)), values, color=colour, label=label, linewidth=1.2)
        lower.step(range(len(found) + 1), [found[0], *found], where="pre", color=pen(name)["color"])
        upper.set_title(name)
        lower.set(xlabel="lap (1)", ylim=(0.0, 2.2))
    panels[0, 0].set_ylabel("consequent (level)")
    panels[1, 0].set_ylabel("RMS (°)")
    return with_legend(fig, panels[0, 0], columns=7)


@figure(
    "Whether a step settles, by assumed and true delay: dots settle, crosses swing in the simulation; shaded: all "
    "roots of the linear loop are inside the unit circle. Left the printed scales, right six times the gain."
)
def assumed_and_true_delay(lab: Lab) -> Figure:
    fig, panels = grid(8.0, 4.2, 1, 2, sharey=True)
    for axes, (name, k_e) in zip(panels, ((n, K_E[n]) for n in ("6/90", "6/15")), strict=True):
        found = delay_map(lab, k_e)
        shaded = np.where(found.stable.T, 1.0, np.nan)
        axes.pcolormesh(ASSUMED, TRUE, shaded, cmap="Blues", vmin=0.0, vmax=4.0, shading="nearest")
        for settles, mark, colour in ((True, "o", BLUE), (False, "x", VERMILION)):
            i, j = np.nonzero(found.settled == settles)
            axes.plot(np.array(ASSUMED)[i], np.array(TRUE)[j], mark, color=colour, markersize=5)
        axes.set(title=f"{name} level/°", xlabel="assumed delay m (samples)", xticks=ASSUMED)
    panels[0].set_ylabel("true delay of the camera (samples)")
    return fig


@figure("Deviation on three lines, a mean over 10 mm; from half on the material is foam in place of fabric.")
def change_of_material(lab: Lab) -> Figure:
    fig, panels = grid(8.0, 7.0, len(LINES), 1)
    width = round(10.0 / SAMPLE_MM)
    for axes, name in zip(panels, LINES, strict=True):
        for controller in (FIXED, PNN, TUNED, PID):
            e = changed_deviation(lab, controller, name)[0]
            way = SAMPLE_MM * (np.arange(len(e) - width + 1) + width // 2)
            axes.plot(way, np.convolve(e, np.full(width, 1.0 / width), mode="valid"), linewidth=1.2, **pen(controller))
        axes.axvline(0.5 * SAMPLE_MM * len(e), **GUIDE)
        axes.axhline(0.0, **GUIDE)
        axes.set(title=name, ylabel="deviation (°)")
    panels[-1].set_xlabel("distance along the line (mm)")
    return with_legend(fig, panels[0], columns=4)


# ---- all controllers, and pieces: what takes longest is drawn last
@figure("RMS deviation of every controller in nine cells, mean of five runs; the bar is the mean of all cells.")
def every_controller(lab: Lab) -> Figure:
    names = sorted((*UNTUNED, MAMDANI), key=lambda name: -mean_rms(lab, name))
    fig, axes = grid(8.4, 1.5 + 0.28 * len(names))
    for row, name in enumerate(names):
        found = cells(lab, name).rms.mean(axis=-1)
        for (i, j), value in np.ndenumerate(found):
            label = f"{LINES[i]}, {MATERIAL_NAMES[j]}" if row == 0 else None
            axes.plot(value, row, MARKS[LINES[i]], color=MATERIAL_COLOURS[MATERIAL_NAMES[j]], markersize=5, label=label)
        axes.plot(found.mean(), row, "|", color=BLACK, markersize=14, markeredgewidth=2.5)
    axes.set_yticks(range(len(names)), names)
    plain_ticks(axes, "x", (0.2, 0.5, 1.0, 2.0, 5.0, 10.0))
    axes.set_xlabel("RMS deviation (°)")
    axes.grid(alpha=0.3)
    return with_legend(fig, axes, columns=3)


@figure(
    "RMS deviation by piece, mean of nine cells; bars: standard deviation of five runs. Left the plant as believed, "
    "right one with terms that no controller knows of. Dotted: what the texture alone makes."
)
def pieces_error(lab: Lab) -> Figure:
    fig, panels = grid(9.0, 5.0, 1, 2, sharey=True)
    floor = float(np.mean(list(texture_floor(lab).values())))
    for axes, mismatch, title in zip(panels, (False, True), ("plant as believed", "with unknown terms"), strict=True):
        for way in ON_THE_OTHER_PLANT if mismatch else WAYS:
            found, (colour, mark) = series(lab, way, mismatch=True) if mismatch else series(lab, way), WAY_PENS[way]
            at = range(1, len(found.rms) + 1)
            look = {"color": colour, "marker": mark, "markersize": 4, "linewidth": 1.2, "capsize": 2, "label": way}
            axes.errorbar(at, [found.mean(j) for j in at], yerr=[found.spread(j) for j in at], **look)
        axes.axhline(floor, **GUIDE)
        axes.set(xlabel="piece (1)", title=title, xticks=range(1, 7))
        plain_ticks(axes, "y", RMS_TICKS)
    panels[0].set(ylabel="RMS deviation (°)", ylim=(0.15, 3.0))
    return with_legend(fig, panels[0])


@figure(f"RMS deviation of flowers, cut in fabric and from piece {SWAP_AT} on in foam, mean of five runs.")
def pieces_swap(lab: Lab) -> Figure:
    fig, axes = grid(7.0, 4.6)
    for way in WITH_NEW_MATERIAL:
        runs, (colour, mark) = swapped(lab, way), WAY_PENS[way]
        at = np.arange(1, len(runs) + 1)
        look = {"color": colour, "marker": mark, "markersize": 4, "linewidth": 1.2, "capsize": 2, "label": way}
        axes.errorbar(at, runs.mean(axis=1), yerr=runs.std(axis=1, ddof=1), **look)
    axes.axvline(SWAP_AT - 0.5, **GUIDE)
    axes.set(xlabel="piece (1)", ylabel="RMS deviation (°)", ylim=(0.1, 3.5))
    plain_ticks(axes, "y", RMS_TICKS)
    return with_legend(fig, axes)


@figure("Rules of the curvature in fabric: learned on one line, frozen, and asked on each. Grey: no compensation.")
def pieces_recall(lab: Lab) -> Figure:
    fig, panels = grid(9.0, 4.2, 1, 2, sharey=True)
    at = np.arange(len(LINES))
    for axes, form in zip(panels, ("every rule for itself", next(iter(curvature_rules.FORMS))), strict=True):
        found = curvature_rules.recalled(lab, form)
        axes.bar(at, found.none.mean(axis=-1), 0.9, color="0.88", label="no compensation")
        for i, (name, colour) in enumerate(zip(LINES, (BLUE, ORANGE, GREEN), strict=True)):
            axes.bar(at + 0.27 * (i - 1), found.frozen[i].mean(axis=-1), 0.25, color=colour, label=f"learned on {name}")
        axes.set_xticks(at, LINES)
        axes.set(xlabel="cut (line)", title=form)
    panels[0].set_ylabel("RMS deviation, frozen (°)")
    return with_legend(fig, panels[0], columns=4)
