"""Pictures of the first mode: peak of sensitivity by controller and mode, and what speed a notch allows."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLUE, VERMILION
from leadscrew.studies.npid_xytable.two_mass import LINEAR, MODES_HZ, TwoMassMap
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORST_MS = 8.0
"""End of the colour scale."""


def two_mass_pictures(found: TwoMassMap) -> list[Picture]:
    """Two pictures."""
    return [
        Picture(
            "two_mass_map",
            "The axis on two masses: peak of sensitivity Ms by controller and frequency of the first mode, feedback "
            "from "
            "a scale at the table or an encoder on the motor; a cross is an unstable loop",
            partial(mode_map, found),
        ),
        Picture(
            "two_mass_speed",
            "Share of its speed at which ours.pid_ms_159 keeps Ms 2 on an axis with a mode, with and without a notch "
            "at it",
            partial(speed, found),
        ),
    ]  # fmt: skip


def mode_map(found: TwoMassMap) -> Figure:
    """Rows controllers, columns modes; four panels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for row, at_table in enumerate((True, False)):
        for column, what in enumerate(("plain", "notch")):
            axes = panels[row, column]
            ms = np.array([[getattr(found.cells[n, at_table, hz], what).ms for hz in MODES_HZ] for n in LINEAR])
            shown = np.where(np.isfinite(ms), np.minimum(ms, WORST_MS), np.nan)
            image = axes.imshow(shown, cmap="cividis_r", vmin=1.0, vmax=WORST_MS, aspect="auto")
            for (i, k), value in np.ndenumerate(ms):
                text = f"{value:.1f}" if np.isfinite(value) else "x"
                dark = np.isfinite(value) and value > 0.6 * WORST_MS
                axes.text(k, i, text, ha="center", va="center", fontsize="small", color="white" if dark else "black")
            where = "scale at the table" if at_table else "encoder on the motor"
            axes.set_title(f"{where}, {'with a notch' if what == 'notch' else 'no notch'}", fontsize="medium")
            axes.set_xticks(range(len(MODES_HZ)), [f"{hz:g}" for hz in MODES_HZ])
            axes.set_yticks(range(len(LINEAR)), LINEAR)
            if row:
                axes.set_xlabel("first mode (Hz)")
    figure.colorbar(image, ax=panels, label="Ms", shrink=0.7)
    return figure


def speed(found: TwoMassMap) -> Figure:
    """Two panels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 3.2), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, at_table in zip(panels, (True, False), strict=True):
        without, behind = np.array([found.speeds[at_table, hz] for hz in MODES_HZ]).T
        axes.plot(MODES_HZ, without, "o-", color=VERMILION, markersize=4, label="no notch")
        axes.plot(MODES_HZ, behind, "s--", color=BLUE, markersize=4, label="notch at the mode")
        axes.set(
            title="scale at the table" if at_table else "encoder on the motor", xlabel="first mode (Hz)", ylim=(0, 1.05)
        )
        axes.grid(color="0.92", linewidth=0.6)
        axes.legend(frameon=False, fontsize="small", loc="lower right")
    panels[0].set_ylabel("share of its speed within Ms 2")
    return figure
