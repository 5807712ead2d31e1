"""Pictures of the inference network: its sets, its surface beside Mamdani's, its covariance, centres that wander."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadscrew.neural.inference_net import CENTRES, LABELS, RULES, W0, initial_rules, regressors
from leadscrew.neural.samples import LEVELS, copied_rmse, reasoning_samples, rms
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.sofnn_tangent.inference_filter import FORGETTING, forms_kept, trace_of_learner
from leadscrew.studies.sofnn_tangent.inference_runs import LITERAL, TUNED, centres_on_the_way, laps_with
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.study import Picture

SETS = (VERMILION, ORANGE, GREEN, BLACK, SKY, BLUE, PURPLE)
"""A colour a set, NB to PB."""
STYLES = ("-", "--", "-.", "-", "-.", "--", "-")


def inference_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("membership_functions", "The paper's Figure 3, which is missing in our copy, as reconstructed: seven "
                "triangles over the 13 levels, the same for E, EC and D, crossing at one half, shouldered at the ends. "
                "Their sum is one everywhere.", membership_functions),
        Picture("inference_surface", "What the network is trained on and what it says. Left: the Mamdani system "
                "(max-min, centroid) at the 169 whole levels. Middle: the network after one Kalman pass. Right: the "
                "two along EC = 0, with the rules copied without training.", inference_surface),
        Picture("covariance_trace", "Trace of the covariance when only the nine rules around zero are excited. Left: "
                "with forgetting 0.98 it grows without end in every form (single precision ends where the line ends); "
                "without, it stays. Right: the same in the loop, lap after lap of the flower, and what it does to the "
                "deviation.", partial(covariance_trace, loops)),
        Picture("centres_wander", "Centres of the seven sets of E when they are learned on line with a walk of 0.01 a "
                "sample, on the wave in three materials, the paper's loop. NS ends next to zero.",
                partial(centres_wander, loops)),
    ]  # fmt: skip


def membership_functions() -> Figure:
    """The seven sets."""
    figure = Figure(figsize=(7.2, 3.0), layout="constrained")
    axes = figure.subplots()
    points = np.linspace(-7.0, 7.0, 561)
    for label, centre, peak, colour, style in zip(LABELS, CENTRES, np.eye(7), SETS, STYLES, strict=True):
        axes.plot(points, np.interp(points, CENTRES, peak), color=colour, linestyle=style)
        axes.annotate(label, (centre, 1.0), (0, 4), textcoords="offset points", ha="center", color=colour)
    axes.axvspan(-6.0, 6.0, color=BLACK, alpha=0.04, linewidth=0.0)
    axes.set(xlabel="E, EC, D, level", ylabel="membership", xlim=(-7, 7), ylim=(0.0, 1.15), xticks=LEVELS)
    axes.grid(alpha=0.3)
    return figure


def inference_surface() -> Figure:
    """Samples, network, and a cut through both."""
    samples = reasoning_samples()
    size = LEVELS.size
    fine = np.linspace(-6.0, 6.0, 121)
    e, ec = np.meshgrid(fine, fine)
    network = (regressors(e, ec) @ W0).reshape(e.shape)
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    look: dict[str, Any] = {"cmap": "PuOr", "vmin": -6.0, "vmax": 6.0, "shading": "nearest"}
    left.pcolormesh(LEVELS, LEVELS, samples.d.reshape(size, size), **look)
    shown = middle.pcolormesh(fine, fine, network, **look)
    middle.plot(*(x.ravel() for x in np.meshgrid(CENTRES, CENTRES)), ".", color=BLACK, markersize=3)
    figure.colorbar(shown, ax=[left, middle], label="D, level")
    row = slice(6 * size, 7 * size)
    error = rms(regressors(samples.e, samples.ec) @ W0 - samples.d)
    right.plot(fine, regressors(fine, np.zeros(fine.size)) @ W0, color=BLUE, label=f"trained, RMSE {error:.3f}")
    copied = regressors(fine, np.zeros(fine.size)) @ initial_rules().ravel()
    right.plot(fine, copied, color=ORANGE, linestyle="--", label=f"rules copied, RMSE {copied_rmse():.3f}")
    right.plot(samples.e[row], samples.d[row], "o", color=VERMILION, markersize=4, label="Mamdani")
    for axes, title in ((left, "Mamdani, 169 samples"), (middle, f"network, {RULES} consequents (dots)")):
        axes.set(title=title, xlabel="E, level", ylabel="EC, level", xticks=CENTRES, yticks=CENTRES)
    right.set(title="EC = 0", xlabel="E, level", ylabel="D, level", xticks=CENTRES, ylim=(-11.0, 7.0))
    right.legend(loc="lower left")
    right.grid(alpha=0.3)
    return figure


def covariance_trace(loops: Loops) -> Figure:
    """With and without forgetting."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    looks = (
        ("naive", 32, FORGETTING, VERMILION, "-", "forgetting 0.98, single precision"),
        ("joseph", 64, FORGETTING, ORANGE, "--", "forgetting 0.98, double precision, Joseph's form"),
        ("joseph", 64, 1.0, BLUE, "-", "no forgetting"),
    )
    for form, bits, forgetting, colour, style, label in looks:
        rows = [r for r in forms_kept() if (r.form, r.bits, r.forgetting) == (form, bits, forgetting) and r.finite]
        left.plot(
            [r.updates for r in rows], [r.trace for r in rows], style, color=colour, marker="o", ms=3, label=label
        )
    updates, trace = trace_of_learner(q=0.05, cap=4.0, r=0.01)
    left.plot(updates, trace, color=GREEN, linestyle="-.", label="walk 0.05, cap 4 (the controllers)")
    left.set(xscale="log", yscale="log", xlabel="updates", ylabel="trace of P, level$^2$", ylim=(1.0, 1e190))
    left.legend(loc="upper left")
    kept = laps_with(loops, TUNED)
    gone = laps_with(loops, TUNED | {"forgetting": FORGETTING, "q": 0.0, "cap": 1e300})
    laps = np.arange(1, kept.rms.size + 1)
    right.plot(laps, gone.rms, "--", color=ORANGE, marker="o", ms=3, label=f"forgetting: trace {gone.trace[-1]:.0e}")
    right.plot(laps, kept.rms, "-.", color=GREEN, marker="s", ms=3, label=f"walk and cap: trace {kept.trace[-1]:.0f}")
    right.set(xlabel="lap of the flower", ylabel="RMS deviation, deg", xticks=laps[::2], ylim=(0.0, None))
    right.legend(loc="lower right")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


def centres_wander(loops: Loops) -> Figure:
    """Centres of E along the wave."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    panels: Mapping[str, Axes] = dict(
        zip(("fabric", "leather", "foam"), figure.subplots(1, 3, sharey=True), strict=True)
    )
    for name, axes in panels.items():
        found = centres_on_the_way(loops, "wave_fabric", name, LITERAL | {"q_centre": 0.01})
        for i, (label, colour, style) in enumerate(zip(LABELS, SETS, STYLES, strict=True)):
            axes.plot(found.travel_mm, found.centres[:, i], color=colour, linestyle=style, label=label)
        axes.set(title=name, xlabel="travel, mm", yticks=CENTRES)
        axes.grid(alpha=0.3)
    panels["fabric"].set(ylabel="centre of E, level")
    handles, labels = panels["foam"].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside right center")
    return figure
