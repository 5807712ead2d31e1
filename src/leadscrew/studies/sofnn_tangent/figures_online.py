"""Pictures of learning while cutting: rules and RMS over laps, the camera lost, what the rules keep when held."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.neural.inference_net import LABELS, SETS
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.studies.sofnn_tangent.claims_online import LAP_SAMPLES, LAPS
from leadscrew.studies.sofnn_tangent.claims_recall import TEXTURES
from leadscrew.studies.sofnn_tangent.claims_safeguards import LOST_S
from leadscrew.studies.sofnn_tangent.online import LINES, TABLE, TUNED, loop_of, recall, rms, rules
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EVERY = 79
"""Samples between two looks at the rules."""
LOST_FROM_S = 4.0


def online_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("weights_over_laps", f"Rules in the row EC = ZO over {LAPS} laps of the flower in fabric, and RMS of "
                "each lap. Left: the literal network without a leak; right: the tuned one with its leak. The "
                "rule ZO swings with every bend, NS and PS rest near the clamp, the others hardly fire: an integrator, "
                "not a memory.", partial(weights_over_laps, loops)),
        Picture("lost_camera", f"The camera loses the cut for {LOST_S:.0f} s (shaded) on the wave in fabric, tuned "
                "network. Told of it, the learning stops and the offset fades; not told, it learns from a reading that "
                "stands, and drives the cut away.", partial(lost_camera, loops)),
        Picture("held_rules", "RMS of a sixth piece in fabric: without compensation, with the trained rules held, with "
                "learning on, and with the rules that five pieces have taught, held. Mean of "
                f"{TEXTURES} histories.", partial(held_rules, loops)),
    ]  # fmt: skip


def weights_over_laps(loops: Loops) -> Figure:
    """Seven rules and the RMS, two networks."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 5.0), layout="constrained")
    grid = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=(3, 1))
    middle = SETS * (SETS // 2)
    hues = (VERMILION, ORANGE, SKY, BLACK, SKY, ORANGE, BLUE)
    for column, name in enumerate((TABLE, TUNED)):
        live = loop_of(loops, name, "flower_laps").start()
        seen, e = [rules(live).weights], []
        for _ in range(LAPS * LAP_SAMPLES // EVERY):
            e.append(live.advance(EVERY, record=("actual.deviation",))["actual.deviation"])
            seen.append(rules(live).weights)
        lap = EVERY * np.arange(len(seen)) / LAP_SAMPLES
        upper, lower = grid[:, column]
        for i, label in enumerate(LABELS):
            row = [w[middle + i] for w in seen]
            upper.plot(lap, row, color=hues[i], linestyle="-" if i < 4 else "--", label=label, linewidth=1.0)
        each = [rms(part) for part in np.concatenate(e).reshape(LAPS, LAP_SAMPLES)]
        lower.step(np.arange(LAPS + 1), [each[0], *each], where="pre", color=BLACK)
        upper.set(title=name)
        lower.set(xlabel="lap", xlim=(0, LAPS), ylim=(0.0, 2.2))
    grid[0, 0].set(ylabel="consequent, levels", ylim=(-6.5, 6.5))
    grid[1, 0].set(ylabel="RMS, deg")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, ncols=7, fontsize="small", loc="outside upper center", title="set of E")
    for axes in grid.ravel():
        axes.grid(alpha=0.3)
    return figure


def lost_camera(loops: Loops) -> Figure:
    """Deviation and offset around the loss."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    lost = {"sensor.lost_from_s": LOST_FROM_S, "sensor.lost_for_s": LOST_S}
    for label, blind, changes, hue, style in (
        ("never lost", False, {}, BLACK, ":"),
        ("told: learning stops", False, lost, GREEN, "-"),
        ("not told", True, lost, VERMILION, "--"),
    ):
        run = loop_of(loops, TUNED, "wave_fabric", changes, blind=blind).run(
            9.24, record=("actual.deviation", "output")
        )
        upper.plot(run["time"], run["actual.deviation"], color=hue, linestyle=style, label=label)
        lower.plot(run["time"], run["output"], color=hue, linestyle=style)
    for axes in (upper, lower):
        axes.axvspan(LOST_FROM_S, LOST_FROM_S + LOST_S, color=SKY, alpha=0.3, linewidth=0.0)
        axes.grid(alpha=0.3)
    upper.set(ylabel="deviation, deg", xlim=(LOST_FROM_S - 1.0, LOST_FROM_S + LOST_S + 2.0))
    lower.set(ylabel="offset angle, deg", xlabel="time, s")
    upper.legend(loc="upper right")
    return figure


def held_rules(loops: Loops) -> Figure:
    """Four bars by line and network."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    fills = (BLACK, SKY, GREEN, ORANGE)
    words = ("none", "trained rules, held", "learning on", "learned rules, held")
    for axes, name in zip(figure.subplots(1, 2, sharey=True), (TABLE, TUNED), strict=True):
        for k, line in enumerate(LINES):
            seen = recall(loops, name, line, textures=TEXTURES)
            for i, value in enumerate((seen.none, seen.prior, seen.learning, seen.held)):
                axes.bar(k + 0.2 * (i - 1.5), value, 0.18, color=fills[i], label=words[i] if k == 0 else None)
            axes.annotate(f"keeps {seen.kept:.0f} %", (k + 0.3, seen.held + 0.06), ha="center", fontsize="small")
        axes.set(title=name, xticks=range(len(LINES)), ylim=(0.0, 3.4))
        axes.set_xticklabels(LINES)
        axes.grid(alpha=0.3, axis="y")
    figure.axes[0].set_ylabel("RMS deviation, deg")
    figure.axes[1].legend(loc="upper center", ncols=2, fontsize="small")
    return figure
