"""Figures of the study: pictures of results, nothing computed here beyond units."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.fuzzy.partition import Partition
from leadscrew.report.style import BLUE, ORANGE, colour, pen
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.rules import SETS
from leadscrew.studies.vud_lathe.runs import GENTLE, STEPS, TABLE_1_STEPS, speed_between, true_error_um
from leadscrew.studies.vud_lathe.tables import Move

COMPARED = ("paper.vud", "corrected.vud_beta_e", "ours.original_fit")
TARGET = {STEPS[0]: -50.0, STEPS[1]: -170.0}
ARRIVAL_S = {STEPS[0]: 1.0, STEPS[1]: 1.25}
PHASE_TIMES_S = {"paper.vud": (3.0, 7.0, 8.0, 10.0), "corrected.vud_beta_e": (0.05, 0.4, 0.6, 0.8, 1.15)}
"""When the phase picture draws the contracted universe, for each controller's own way."""


def pictures(runs: Mapping[str, Any], moves: Mapping[str, Move], example: tuple[Partition, Partition]) -> list[Picture]:
    """The study's figures; ``example`` holds the contracted sets of e and ec of the worked example."""
    return [
        Picture("fig11a_position_m50", "Step to -50 mm (Figure 11 a).", partial(position, runs, STEPS[0])),
        Picture("fig11b_position_m170", "Step to -170 mm (Figure 11 b).", partial(position, runs, STEPS[1])),
        Picture("fig12_error", "True error after 2 s (Figure 12).", partial(error, runs)),
        Picture("creep", "The printed law on its whole way: a creep at 6 mm/s.", partial(creep, runs)),
        Picture("universes", "How the universes of e and ec shrink.", partial(universes, runs, STEPS[0])),
        Picture("phase", "e and ec, and the universes around them at the times that are written beside them.",
                partial(phase, runs, STEPS[0])),
        Picture("fig6_8_sets", "The six sets of e, ec and the duty (Figures 6 to 8).", partial(initial_sets, SETS)),
        Picture("fig9_10_sets", "The sets contracted for the worked example (Figures 9 and 10).",
                partial(contracted_sets, SETS, example)),
        Picture("table1_fit", "Our stand-in for the original servo against Table 1.", partial(table_fit, runs, moves)),
        Picture("gentle_moves", "Error on commands with limited acceleration and jerk.", partial(gentle, runs)),
    ]  # fmt: skip


def _figure(rows: int = 1, columns: int = 1, height: float = 4.0) -> tuple[Figure, Any]:
    figure = Figure(figsize=(4.2 * columns + 2.8 * (columns == 1), height), layout="constrained")
    return figure, figure.subplots(rows, columns)


def _legend(figure: Figure, axes: Any) -> None:
    """One legend for the whole figure, below it, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)


def position(runs: Mapping[str, Any], scenario: str) -> Figure:
    """Position against time for the printed law, the corrected one and the original servo."""
    figure, axes = _figure()
    target, arrival = TARGET[scenario], ARRIVAL_S[scenario]
    for controller in COMPARED:
        run = runs[f"{scenario}/{controller}"]
        shown = run.time <= 2.0
        axes.plot(run.time[shown], run["actual.position"][shown], **pen(controller))
    axes.axhline(target, color="0.7", linewidth=0.8, zorder=0)
    axes.plot([arrival, arrival], [0.0, target], **pen("paper says", f"paper: near target at {arrival} s"))
    axes.set(xlabel="time (s)", ylabel="true position (mm)", title=f"Step to {target:g} mm")
    _legend(figure, axes)
    return figure


def error(runs: Mapping[str, Any]) -> Figure:
    """Error after 2 s, with the bands that the paper gives for the two controllers."""
    figure, panels = _figure(1, 2)
    for axes, scenario in zip(panels, STEPS, strict=True):
        for controller in ("corrected.vud_beta_e", "corrected.vud_beta_e_half", "ours.original_fit"):
            run = runs[f"{scenario}/{controller}"]
            shown = run.time >= 2.0
            axes.plot(run.time[shown], true_error_um(run)[shown], **pen(controller))
        for band in (-2.0, 2.0):
            axes.axhline(band, **pen("paper says", "paper: VUD within 2 µm" if band > 0 else None))
        printed = runs[f"{scenario}/paper.vud"].metrics["error_after_2s"]
        axes.text(0.98, 0.03, f"paper.vud: still up to {printed:.0f} mm away", color=colour("paper.vud"), ha="right",
                  transform=axes.transAxes)  # fmt: skip
        axes.set(xlabel="time (s)", title=f"Step to {TARGET[scenario]:g} mm", ylim=(-2.9, 2.9))
    panels[0].set_ylabel("true error (µm)")
    _legend(figure, panels[0])
    return figure


def creep(runs: Mapping[str, Any]) -> Figure:
    """The printed law over its whole way, beside the corrected one."""
    figure, axes = _figure()
    speed = speed_between(runs[f"{STEPS[1]}/paper.vud"], 3.0, 5.0)
    for scenario in STEPS:
        for controller in ("paper.vud", "corrected.vud_beta_e"):
            run = runs[f"{scenario}/{controller}"]
            label = controller if scenario == STEPS[0] else None
            axes.plot(run.time[::20], run["actual.position"][::20], **pen(controller, label))
    axes.set(xlabel="time (s)", ylabel="true position (mm)", title=f"The printed law creeps: {speed:.2f} mm/s")
    _legend(figure, axes)
    return figure


def universes(runs: Mapping[str, Any], scenario: str) -> Figure:
    """The factors alpha against time, with the inputs inside the universes that they span."""
    figure, panels = _figure(2, 1, height=5.6)
    run = runs[f"{scenario}/corrected.vud_beta_e"]
    shown = run.time <= 1.2
    time = run.time[shown]
    for axes, name, symbol in zip(panels, ("e", "ec"), ("e", "ec"), strict=True):
        alpha = run[f"controller.alpha_{name}"][shown]
        axes.fill_between(time, -alpha, alpha, color=BLUE, alpha=0.2, label=f"universe of {symbol}", linewidth=0)
        axes.plot(time, run[f"controller.{name}"][shown], color=ORANGE, label=symbol)
        axes.set_yscale("symlog", linthresh=1e-3)
        axes.set(ylabel=f"{symbol} (1)")
        axes.legend(frameon=False, loc="upper right")
    panels[0].set_title(f"corrected.vud_beta_e, step to {TARGET[scenario]:g} mm")
    panels[-1].set_xlabel("time (s)")
    return figure


def phase(runs: Mapping[str, Any], scenario: str) -> Figure:
    """The way in the plane of e and ec, with the contracted universe drawn at a few times."""
    from matplotlib.patches import Rectangle

    figure, panels = _figure(1, 2, height=4.6)
    ticks = (-1.0, -0.1, -0.01, 0.0, 0.01, 0.1, 1.0)
    for axes, (controller, times) in zip(panels, PHASE_TIMES_S.items(), strict=True):
        run = runs[f"{scenario}/{controller}"]
        e, ec = run["controller.e"], run["controller.ec"]
        until = round(1000 * times[-1]) + 200
        axes.plot(e[:until], ec[:until], color=colour(controller), linewidth=0.9)
        for t in times:
            k = round(1000 * t)
            half_e, half_ec = run["controller.alpha_e"][k], run["controller.alpha_ec"][k]
            axes.add_patch(Rectangle((-half_e, -half_ec), 2 * half_e, 2 * half_ec, fill=False, color="0.45", lw=0.8))
            axes.plot(e[k], ec[k], "o", color=colour(controller), markersize=3.5)
            axes.annotate(f"{t:g} s", (half_e, -half_ec), textcoords="offset points", xytext=(-1, 2), ha="right",
                          fontsize="x-small")  # fmt: skip
        axes.set_xscale("symlog", linthresh=1e-3)
        axes.set_yscale("symlog", linthresh=1e-3)
        axes.set_xticks(ticks, [f"{x:g}" for x in ticks], fontsize="small")
        axes.set_yticks(ticks, [f"{x:g}" for x in ticks], fontsize="small")
        axes.set(xlabel="e (1)", ylabel="ec (1)", xlim=(-1.5, 1.5), ylim=(-1.5, 1.5), title=controller)
    return figure


def _draw_sets(axes: Any, sets: Partition, name: str) -> None:
    reach = max(abs(c) for c in sets.centres)
    x = np.union1d(np.linspace(-reach, reach, 401), sets.centres)
    for index, (label, mu) in enumerate(zip(sets.labels, sets.memberships(x).T, strict=True)):
        axes.plot(x, mu, color=colour(label), linewidth=1.3)
        axes.text(sets.centres[index], 1.03, label, ha="center", fontsize="small", color=colour(label))
    axes.set(xlabel=f"{name} (1)", ylabel="membership (1)", ylim=(0.0, 1.15))


def initial_sets(sets: Partition) -> Figure:
    """The six sets on the full universe, and the wide gap around zero."""
    figure, axes = _figure(height=2.8)
    _draw_sets(axes, sets, "e, ec, duty")
    axes.axvspan(-0.33, 0.33, color="0.93", zorder=0)
    axes.set_ylim(0.0, 1.3)
    axes.text(0.0, 1.17, "no set at zero: gap 0.66 against 0.34", ha="center", fontsize="small")
    return figure


def contracted_sets(sets: Partition, example: tuple[Partition, Partition]) -> Figure:
    """The sets on the contracted universes of the worked example, with its inputs."""
    figure, panels = _figure(1, 2, height=3.0)
    for axes, contracted, name, value in zip(panels, example, ("e", "ec"), (-0.25, 0.12), strict=True):
        _draw_sets(axes, contracted, name)
        axes.axvline(value, color="black", linestyle=":", linewidth=1.0)
        reach = contracted.centres[-1]
        axes.set_title(f"{name} = {value:g} in [-{reach:.4f}, {reach:.4f}]", fontsize="medium", pad=14)
    return figure


def table_fit(runs: Mapping[str, Any], moves: Mapping[str, Move]) -> Figure:
    """Our stand-in for the original servo, as lines, over the points of Table 1."""
    figure, axes = _figure()
    for number, (name, scenario) in enumerate(TABLE_1_STEPS.items()):
        run, move = runs[f"{scenario}/ours.original_fit"], moves[name]
        shown = run.time <= 2.0
        axes.plot(run.time[shown], (move.target_mm - run["actual.position"][shown]) / 190.0,
                  **pen("ours.original_fit", None if number else "ours.original_fit"))  # fmt: skip
        axes.plot(move.time_s, move.error, "o", color="black", markersize=3, label=None if number else "Table 1")
    axes.set(xlabel="time (s)", ylabel="normalised error e (1)")
    axes.legend(frameon=False)
    return figure


def gentle(runs: Mapping[str, Any]) -> Figure:
    """True error along a trapezoid and an S-curve to -170 mm."""
    figure, panels = _figure(1, 2)
    for axes, scenario in zip(panels, GENTLE, strict=True):
        for controller in ("corrected.vud_beta_e", "ours.pd"):
            run = runs[f"{scenario}/{controller}"]
            shown = run.time <= 2.0
            axes.plot(run.time[shown], 0.001 * true_error_um(run)[shown], **pen(controller))
        axes.set(xlabel="time (s)", ylabel="true error (mm)", title=scenario)
    _legend(figure, panels[0])
    return figure
