"""Pictures of the comparison: Table II beside simulation, errors in time, random phases, the robustness box."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.report.style import colour, pen
from leadscrew.studies.npid_xytable.calibration import LINES_HZ
from leadscrew.studies.npid_xytable.columns import NPID_UM, PID_UM
from leadscrew.studies.npid_xytable.results import Results
from leadscrew.studies.npid_xytable.scenarios import SPEEDS
from leadscrew.studies.npid_xytable.trials import TOLD, spindle_key
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = ("paper.pid", "corrected.npid_um", "ours.pid_159_ff", "ours.resonant_full")
"""Controllers of the bars and traces, worst first."""

BOXED = (
    "paper.pid", "corrected.npid_um", "ours.npid_slope", "ours.pid_ms_159", "ours.npid_slope_159", "ours.pid_159_ff",
    "ours.resonant_box", "ours.resonant_full",
)  # fmt: skip


def comparison_pictures(found: Results) -> list[Picture]:
    """Four pictures."""
    return [
        Picture(
            "table2_simulated",
            "The fifteen rows of Table II: as printed, and simulated at 1 mm with thirty draws of the phases (bars: "
            "mean, lines: 5 to 95 %). PID is calibrated to its column",
            lambda: _rows(found),
        ),
        Picture(
            "errors_1000",
            "Error over one period of the motion at 1,000 1/min, spindle lines included, under four controllers",
            lambda: _traces(found),
        ),
        Picture(
            "random_phases",
            "Mean reduction of a run's rows by NPID against the motion's unknown amplitude; paper: 8 to 40 %",
            lambda: _phases(found),
        ),
        Picture("robustness_box", "Rms error on the twelve plants of the box, three speeds", lambda: _box(found)),
    ]


def _rows(found: Results) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    places = np.arange(len(LINES_HZ))
    width = 0.8 / len(SHOWN)
    for number, (rpm, axes) in enumerate(zip(SPEEDS, figure.subplots(3, 1, sharex=True), strict=True)):
        for k, name in enumerate(SHOWN):
            rows = found.trials.nominal(name).at(rpm)
            (low, high), mean = np.percentile(rows, (5, 95), axis=0), rows.mean(axis=0)
            at = places + (k - 0.5 * (len(SHOWN) - 1)) * width
            spread = np.abs([mean - low, high - mean])
            axes.bar(at, mean, width, color=colour(name), label=name, yerr=spread, error_kw={"lw": 1, "capsize": 2})
        for printed, mark, words in ((PID_UM, "_", "PID, printed"), (NPID_UM, "x", "NPID, printed")):
            axes.plot(places, printed[rpm], linestyle="", marker=mark, color="black", markersize=9, label=words)
        axes.set_ylabel(f"{rpm:,} 1/min\namplitude (um)")
        axes.grid(axis="y", alpha=0.3)
        if number == 0:
            axes.legend(ncols=3, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, 1.45))
    axes.set_xticks(places, [f"{hz:.1f}" for hz in LINES_HZ])
    axes.set_xlabel("line (Hz)")
    return figure


def _traces(found: Results) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 6.5), layout="constrained")
    for axes, name in zip(figure.subplots(len(SHOWN), 1, sharex=True), SHOWN, strict=True):
        run = found.loops.run(name, "spindle_1000", **_told(found, name))
        last = run.time >= run.time[-1] - 1.0 / 0.7
        axes.plot(run.time[last] - run.time[last][0], 1e3 * run["true_error"][last], linewidth=0.9, **pen(name))
        axes.set_ylabel("error (um)")
        axes.grid(alpha=0.3)
        axes.set_title(name, fontsize="medium", loc="left")
    axes.set_xlabel("time in the motion's period (s)")
    return figure


def _told(found: Results, name: str) -> dict[str, Any]:
    """The spindle's speed, for a controller that is told it, as an option of a run."""
    key = spindle_key(found.loops.get(name, "spindle_1000")) if name in TOLD else None
    return {} if key is None else {"changes": {key: 1000.0 / 60.0}}


def _phases(found: Results) -> Figure:
    from matplotlib.figure import Figure

    from leadscrew.studies.npid_xytable.claims_columns import RANDOM, random_trial

    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    axes.axhspan(8.0, 40.0, color="0.88", label="paper says: 8 to 40 %")
    reductions = [random_trial(found.loops, a).reductions().mean(axis=1) for a in RANDOM]
    axes.boxplot(reductions, showfliers=True, widths=0.5, medianprops={"color": colour("corrected.npid_um"), "lw": 2})
    axes.set_xticks(np.arange(len(RANDOM)) + 1, [f"{a:g} mm" for a in RANDOM])
    axes.set_xlabel("amplitude of the motion at 0.7 Hz")
    axes.set_ylabel("mean reduction of five rows (%)")
    axes.grid(axis="y", alpha=0.3)
    axes.legend(loc="lower right")
    return figure


def _box(found: Results) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 4.2), layout="constrained")
    axes = figure.subplots()
    for place, name in enumerate(BOXED):
        rms = found.trials.boxed(name).rms
        axes.plot(rms, np.full(rms.size, place) + np.linspace(-0.25, 0.25, rms.size), ".", color=colour(name))
    axes.set_yticks(np.arange(len(BOXED)), BOXED)
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("rms error of a run (um)")
    axes.set_ylabel("controller")
    axes.grid(axis="x", alpha=0.3)
    return figure
