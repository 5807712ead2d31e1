"""Figures about sampled controllers and real drives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.studies.fsmc_ballscrew.claims_drive import EMPTY, FULL, sweep
from leadscrew.studies.fsmc_ballscrew.driven import DRIVES, driven
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.study import Picture

SHOWN = (
    ("ours.pd_dob", "ideal", BLACK),
    ("ours.pd_dob_delay", "delay", BLUE),
    ("ours.pd_dob_late", "delay_filter", GREEN),
    ("ours.pd_dob_1khz", "1khz", ORANGE),
    ("ours.pd_dob_drive", "all", VERMILION),
)
"""Controller, the drive that it is tuned for, and its colour."""

SWEPT = (
    ("ours.pd_dob", BLACK, "o"),
    ("ours.pd_dob_robust", BLUE, "s"),
    ("ours.pd_dob_fixed", GREEN, "^"),
    ("ours.fsmc_4khz", ORANGE, "v"),
    ("ours.csmc_tuned", VERMILION, "D"),
)


def sampled_pictures(loops: Loops) -> list[Picture]:
    """The drive's part in the error at a reversal, and the error over the inertia of the table."""
    return [
        Picture("drive_reversal", "A reversal of sin 2 pi t mm on drives from ideal to everything at once, each with a "
                "setting made for it.", partial(reversal, loops)),
        Picture("inertia_sweep", "Largest error on sin 2 pi t mm from an empty to a full table; all controllers "
                "believe the full one.", partial(inertia, loops)),
    ]  # fmt: skip


def reversal(loops: Loops, shown: Sequence[tuple[str, str, str]] = SHOWN) -> Figure:
    """True error of the table around a reversal, one panel a drive."""
    figure = Figure(figsize=(7.0, 1.5 * len(shown)), layout="constrained")
    panels: Any = figure.subplots(len(shown), 1, sharex=True)
    for axes, (name, drive, ink) in zip(panels, shown, strict=True):
        run = driven(loops, name, "sine_fast", drive).run(2.0, record="true_error")
        inside = (run.time >= 1.4) & (run.time <= 1.8)
        axes.plot(1e3 * (run.time[inside] - 1.5), 1e3 * run["true_error"][inside], color=ink, linewidth=0.9)
        axes.set_title(f"{name}: {DRIVES[drive].said}", fontsize="medium", loc="left")
        axes.set_ylabel("error (µm)")
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("time after the reversal (ms)")
    return figure


def inertia(loops: Loops) -> Figure:
    """Largest error over the inertia at the screw."""
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes: Any = figure.subplots()
    values = np.linspace(EMPTY, FULL, 5)
    for name, ink, mark in SWEPT:
        axes.semilogy(1e4 * values, sweep(loops, name, values), color=ink, marker=mark, markersize=4, label=name)
    axes.set(xlabel="inertia at the screw (1e-4 kg m²)", ylabel="largest error (µm)")
    axes.grid(alpha=0.3, which="both")
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    return figure
