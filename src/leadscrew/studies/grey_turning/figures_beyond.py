"""Pictures beyond the paper: one controller from entry to the last step of the depth, and what preview is worth."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLUE, VERMILION, pen
from leadscrew.studies.grey_turning import beyond
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture


def beyond_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("beyond_stairs", "The stairs 1 to 0.4 mm on plant F, the depth moved by the radial servo: filtered and "
                "true force and the feed voltage of the best TFC, the same with depth feed-forward and 65 ms of "
                "preview, and of the controller that has everything. One noise seed.", partial(stairs, loops)),
        Picture("beyond_preview", "Worst deviations on these stairs by the preview of the depth feed-forward (left), "
                "and with a wrong exponent or depth at 65 ms (right); mean of ten seeds. Dashed: what M2 asks.",
                partial(preview, loops)),
        Picture("beyond_draws", "Overshoot of the filtered force and integral of its error over the 300 draws of the "
                "Monte Carlo on plant F: share of the draws that stay below a value.", partial(spread, loops)),
    ]  # fmt: skip


def stairs(loops: Loops) -> Figure:
    """Forces and voltage over the whole cut."""
    found = beyond.beyond_of(loops)
    cases = {
        "tfc": found.stairs("tfc", "plant_f_radial"),
        "tfc_ff": found.stairs("tfc_ff", "plant_f_radial", beyond.TRIED),
        "constant_force": found.stairs("constant_force", "plant_f_radial"),
    }
    figure = Figure(figsize=(8.2, 7.0), layout="constrained")
    filtered, true, volts = figure.subplots(3, 1, sharex=True)
    for name, run in cases.items():
        row = beyond.BEST if name == "tfc_ff" else 0
        style = pen(beyond.NAMES[name]) | {"linewidth": 1.1}
        filtered.plot(run.time, run.force[row, 0], **style)
        true.plot(run.time, run.true[row, 0], **style)
        volts.plot(run.time, run.output[row, 0], drawstyle="steps-post", **style)
    for axes, words in ((filtered, "filtered force (N)"), (true, "true force (N)")):
        axes.set(ylabel=words, ylim=(100.0, 170.0))
        axes.axhline(150.0, color="0.6", linewidth=0.8, linestyle=":")
    volts.set(ylabel="feed voltage (V)", xlabel="time (s)", ylim=(0.0, 0.9))
    volts.legend(loc="upper left", fontsize="small")
    return figure


def preview(loops: Loops) -> Figure:
    """What preview and wrong beliefs do."""
    cases = beyond.beyond_of(loops).stairs("tfc_ff", "plant_f_radial", beyond.TRIED)
    read = [cases.of(k) for k in range(len(beyond.TRIED))]
    figure = Figure(figsize=(8.2, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    ahead = 1e3 * np.array(beyond.PREVIEWS_S)
    known = read[: len(ahead)]
    left.plot(ahead, [s.worst for s in known], "o-", color=BLUE, label="filtered force")
    left.plot(ahead, [s.true_worst for s in known], "s--", color=VERMILION, label="true force")
    left.set(xlabel="preview (ms)", ylabel="worst deviation (%)", ylim=(0.0, 12.0))
    shown = (beyond.BEST, *beyond.WRONG)
    at = np.arange(len(shown))
    right.bar(at - 0.18, [read[k].worst for k in shown], 0.34, color=BLUE, label="filtered force")
    right.bar(at + 0.18, [read[k].true_worst for k in shown], 0.34, color=VERMILION, hatch="//", label="true force")
    right.set_xticks(at, ["as it is", "P 0.70", "P 0.85", "+0.05 mm"])
    right.set(xlabel="belief, the true P being 0.77")
    for axes in (left, right):
        axes.axhline(3.0, color=BLUE, linewidth=0.8, linestyle="--")
        axes.axhline(5.0, color=VERMILION, linewidth=0.8, linestyle="--")
    left.legend(loc="upper center", fontsize="small")
    return figure


def spread(loops: Loops) -> Figure:
    """Distributions over the draws."""
    found = beyond.beyond_of(loops)
    figure = Figure(figsize=(8.2, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for name in ("tfc", "gain_normalised", "inversion", "constant_force"):
        drawn = found.drawn(name)
        share = np.arange(1, len(drawn.iae) + 1) / len(drawn.iae)
        style = pen(beyond.NAMES[name]) | {"linestyle": "--" if name == "tfc" else "-"}
        left.plot(np.sort(drawn.overshoot), share, **style)
        right.plot(np.sort(drawn.iae), share, **style)
    left.axhline(0.9, color="0.6", linewidth=0.8, linestyle=":")
    left.set(xscale="log", xlim=(0.3, 50.0), xlabel="overshoot of the filtered force (%)", ylabel="share of the draws")
    right.set(xlabel="integral of the absolute error (N s)", xlim=(15.0, 90.0))
    right.legend(loc="lower right", fontsize="small")
    return figure
