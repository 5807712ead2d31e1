"""Pictures of the adaptive feed-forward: its first and its third piece beside no compensation and an observer."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.controllers.tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers.tangent.tangent_dob import tangent_dob
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.studies.sofnn_tangent.lines import MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.taught import series
from leadscrew.studies.study import Picture

SHOWN = "flower_foam"
WEIGHTS = ("30 k(s)", "30 k(s-3)", "30 k(s-8)", "30 k(s-16)", "sin 2 phi", "cos 2 phi", "1")


def feed_forward_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("feed_forward_pieces", "Flower in foam: deviation of the tangent without compensation, under the "
                "disturbance observer, and under the adaptive feed-forward in its first and its third piece. One "
                "texture and noise, the third piece on another.", partial(deviations, loops)),
        Picture("feed_forward_weights", "Weights of the feed-forward after three flowers, mean of five runs (bars: "
                "standard deviation). Four lags of the curvature stand for the lag of the material, "
                "sin 2 phi for its fibre, 1 for the bevel.", partial(weights, loops)),
    ]  # fmt: skip


def deviations(loops: Loops) -> Figure:
    """Deviation along the flower."""
    learned = series(loops, "feed_forward").learned
    row = MATERIAL_NAMES.index("foam") * series(loops, "feed_forward").rms.shape[-1]
    third = curvature_feed_forward(
        prior=learned.prior["flower"][row], prior_covariance=learned.covariance["flower"][row]
    )
    cases = (
        ("paper.uncompensated", "no compensation", "0.6", 0),
        (tangent_dob, "disturbance observer", ORANGE, 0),
        (curvature_feed_forward, "feed-forward, first piece", BLUE, 0),
        (third, "feed-forward, third piece", BLACK, 2),
    )
    figure = Figure(figsize=(8.2, 3.6), layout="constrained")
    axes = figure.subplots()
    scenario = loops.asked(SHOWN)
    for block, words, colour, number in cases:
        loop = loops.get(block, scenario)
        run = loop.run(scenario.duration_s, record=("actual.deviation", "actual.travel"), run=number)
        axes.plot(run["actual.travel"], run["actual.deviation"], color=colour, linewidth=1.0, label=words)
    axes.axhline(0.0, color="0.8", linewidth=0.6)
    axes.set(xlabel="way along the line (mm)", ylabel="deviation of the tangent (deg)", ylim=(-10.5, 8.5))
    axes.legend(fontsize="small", loc="lower right", ncols=2)
    return figure


def weights(loops: Loops) -> Figure:
    """What was learned, by material."""
    rows = series(loops, "feed_forward").learned.prior["flower"]
    rows = rows.reshape(len(MATERIAL_NAMES), -1, rows.shape[-1])
    figure = Figure(figsize=(8.2, 3.4), layout="constrained")
    axes = figure.subplots()
    at = np.arange(rows.shape[-1])
    for i, (name, colour, hatch) in enumerate(
        zip(MATERIAL_NAMES, (SKY, GREEN, VERMILION), ("", "//", ".."), strict=True)
    ):
        mean, spread = rows[i].mean(axis=0), rows[i].std(axis=0, ddof=1)
        axes.bar(at + 0.27 * (i - 1), mean, 0.25, yerr=spread, color=colour, hatch=hatch, label=name, capsize=2)
    axes.axhline(0.0, color="0.5", linewidth=0.6)
    axes.set_xticks(at, WEIGHTS)
    axes.set(ylabel="weight (deg)", xlabel="regressor (k: curvature, 1/mm; lags in samples)")
    axes.legend(fontsize="small")
    return figure
