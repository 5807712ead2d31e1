"""Pictures of the process: Figure 5 of the paper redrawn, and how the force builds up."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, ORANGE, SKY, VERMILION
from leadscrew.studies.grey_turning.claims_errata import SCATTER_N, figure_5
from leadscrew.studies.grey_turning.claims_plant import CLOCK_S, OPEN, STIFFNESS, open_response
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.reproduction import Reproduction
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture


def process_pictures(loops: Loops, found: Reproduction | None = None) -> list[Picture]:
    """Both of them; ``found`` is not needed."""
    return [
        Picture("fig5_digital_filter", "The paper's Fig. 5: force feedback without and with the digital filter, "
                f"{SCATTER_N:.0f} N of noise, TFC with S6 on plant F.", partial(digital_filter, loops)),
        Picture("open_loop_force", "Force after a step to the feed of 150 N, plant F: it builds up over the servo and "
                "a revolution of 50 ms, the later the more the tool yields. Dots: the digest's numbers.",
                partial(open_loop_force, loops)),
    ]  # fmt: skip


def digital_filter(loops: Loops) -> Figure:
    """Raw and filtered force over 6 s."""
    figure = Figure(figsize=(7.6, 5.0), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    raw, filtered = figure_5(loops)
    t = PERIOD_S * np.arange(raw.shape[1])
    for axes, y, colour, name in zip(
        panels, (raw[0], filtered[0]), (SKY, BLUE), ("without filter", "with filter, 0.8"), strict=True
    ):
        axes.axhline(150.0, color=BLACK, linestyle=":", linewidth=1.0)
        axes.plot(t, y, color=colour, linewidth=1.0, label=name)
        axes.set(ylabel="force (N)", xlim=(0.0, 6.0), ylim=(0.0, 250.0))
        axes.legend(frameon=False, loc="lower right")
        axes.grid(alpha=0.3)
    panels[1].set_xlabel("time (s)")
    return figure


def open_loop_force(loops: Loops) -> Figure:
    """Force after a step of the feed, by stiffness."""
    figure = Figure(figsize=(6.8, 4.2), layout="constrained")
    axes = figure.subplots()
    shown = ((1e9, "rigid", ORANGE, ":"), (40_000.0, "40 kN/mm", VERMILION, "-."), (20_000.0, "20 kN/mm", BLUE, "-"),
             (10_000.0, "10 kN/mm", BLACK, "--"))  # fmt: skip
    for stiffness, name, colour, line in shown:
        force = open_response(loops, stiffness, 0.3)
        axes.plot(1e3 * CLOCK_S * np.arange(force.size), force, color=colour, linestyle=line, label=name)
    early = {t: force for t, force in OPEN.items() if t < 0.3}
    axes.plot([1e3 * (t + CLOCK_S) for t in early], list(early.values()), "o", color=BLUE, markersize=5)
    for (stiffness, target), (_, _, colour, _) in zip(sorted(STIFFNESS.items()), (shown[3], shown[1], shown[0]),
                                                      strict=True):  # fmt: skip
        del stiffness
        axes.plot([1e3 * (0.1 + CLOCK_S)], [target], "o", color=colour, markersize=5)
    axes.set(xlabel="time (ms)", ylabel="force (N)", xlim=(0.0, 300.0), ylim=(0.0, 165.0))
    axes.legend(frameon=False, loc="lower right", title="stiffness of tool and work")
    axes.grid(alpha=0.3)
    return figure
