"""Pictures of the grey model: the filter that it is, what it says of a rise, its errors beside simpler predictors."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.grey.filters import linearised, response
from leadscrew.grey.vectorised_others import limit, predictions
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.studies.grey_turning.claims_one_step import LOOP, MACHINE, SHOWN
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.one_step import RUNS, SET_POINT, closed_loops, errors
from leadscrew.studies.grey_turning.runs import Loops, filtered
from leadscrew.studies.study import Picture

PENS: dict[str, dict[str, Any]] = {
    "gm11": {"color": VERMILION, "marker": "o"},
    "line": {"color": BLUE, "marker": "s"},
    "two_point": {"color": GREEN, "marker": "^"},
}
NAMES = {
    "last": "last value", "gm11": "GM(1,1)", "gm11_guarded": "GM(1,1), |c| < 0.5", "gm11_shifted": "GM(1,1), +150 N",
    "line": "line of four", "dgm11": "DGM(1,1)", "two_point": "two points", "gm11_exponential": "GM(1,1), exact rate",
    "gm11_residual": "GM(1,1) + residuals", "verhulst": "Verhulst",
}  # fmt: skip


def grey_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("grey_filter", "GM(1,1) near a set-point. Left: the weights of its five samples, by differences of the "
                "model at 150 N (dots) and of the straight line through the last four (bars). Middle and right: gain "
                "and phase of this filter, of four samples, and of two.", grey_filter),
        Picture("grey_on_a_rise", "Every sample of a rise to 150 N without noise, and what was said of it one sample "
                "before. GM(1,1) over-predicts a rise that levels off: the controller brakes.",
                partial(grey_on_a_rise, loops)),
        Picture("one_step_errors", f"Errors one sample ahead on the filtered force of {LOOP} on {MACHINE}, {RUNS} "
                "noise seeds: median (bar) and all seeds (dots); dashed the last value. Up to 0.8 s, and from 1 s on.",
                partial(one_step, loops)),
    ]  # fmt: skip


def grey_filter() -> Figure:
    """Weights and Bode diagram."""
    figure = Figure(figsize=(10.0, 3.6), layout="constrained")
    left, gain, phase = figure.subplots(1, 3)
    weights = limit(5)
    place = np.arange(-4, 1)
    left.bar(place, weights, color=SKY, width=0.5, label="line of the last four")
    left.plot(place, linearised(SET_POINT), "o", color=VERMILION, label="GM(1,1) at 150 N")
    left.axhline(0.0, color=BLACK, linewidth=0.8)
    left.set(xlabel="sample, 0 is the newest", ylabel="weight", xticks=place)
    left.legend(loc="upper left")
    w = np.linspace(1e-3, np.pi, 2000)
    lines = (
        ("GM(1,1), five samples", weights, VERMILION, "-"),
        ("GM(1,1), four samples", limit(4), ORANGE, "--"),
        ("two points", np.array([-1.0, 2.0]), GREEN, ":"),
    )
    for name, taps, colour, style in lines:
        h = response(taps, w)
        gain.plot(w / np.pi, np.abs(h), color=colour, linestyle=style, label=name)
        phase.plot(w / np.pi, np.degrees(np.angle(h)), color=colour, linestyle=style)
    low = w < np.pi / 3
    phase.plot(w[low] / np.pi, np.degrees(w[low]), color=BLACK, linewidth=0.8, label="one sample ahead")
    phase.legend(loc="lower left")
    gain.legend(loc="upper left")
    gain.axhline(1.0, color=BLACK, linewidth=0.8)
    gain.set(xlabel="frequency, of half the sampling", ylabel="gain", ylim=(0.0, 4.2), xlim=(0.0, 1.0))
    phase.set(xlabel="frequency, of half the sampling", ylabel="phase, deg", xlim=(0, 1), ylim=(-95, 70))
    for axes in (left, gain, phase):
        axes.grid(alpha=0.3)
    return figure


def grey_on_a_rise(loops: Loops) -> Figure:
    """Force and predictions, and the errors below."""
    force = filtered(loops.run("corrected.tfc_stfc", "noise_free", seconds=1.0))
    t = PERIOD_S * np.arange(force.size)
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    upper.plot(t, force, color=BLACK, label="filtered force")
    for name, look in PENS.items():
        said = predictions(force, name)[4:-1]
        upper.plot(t[5:], said, linestyle="", markersize=4, label=f"{NAMES[name]}, said one sample before", **look)
        lower.plot(t[5:], said - force[5:], markersize=3, linewidth=1.0, **look)
    lower.axhline(0.0, color=BLACK, linewidth=0.8)
    upper.set(ylabel="force, N", xlim=(0.0, 0.8))
    upper.legend(loc="lower right")
    lower.set(xlabel="time, s", ylabel="prediction error, N")
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return figure


def one_step(loops: Loops) -> Figure:
    """Errors of all predictors, apart for the rise and for the rest."""
    found = errors(closed_loops(loops, LOOP, MACHINE))
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    for axes, part, title in zip(
        figure.subplots(1, 2, sharey=True), ("transient", "steady"), ("up to 0.8 s", "from 1 s on"), strict=True
    ):
        for i, name in enumerate(SHOWN):
            seen = getattr(found[name], part)
            axes.plot(seen, np.full(seen.size, i), ".", color=SKY, markersize=4)
            axes.plot([np.median(seen)], [i], "|", color=BLACK, markersize=14, markeredgewidth=2)
        axes.set_xscale("log")
        axes.axvline(float(np.median(getattr(found["last"], part))), color=VERMILION, linewidth=0.8, linestyle="--")
        axes.set(title=title, xlabel="RMS error one sample ahead, N")
        axes.set_yticks(range(len(SHOWN)), [NAMES[k] for k in SHOWN])
        axes.grid(alpha=0.3)
    figure.axes[0].invert_yaxis()
    return figure
