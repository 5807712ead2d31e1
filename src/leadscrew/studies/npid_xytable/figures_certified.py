"""Figures about proofs: moonshot M4's rows, and the gap between what is proved and what is true on random plants."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from leadscrew.controllers.npid_split import parted
from leadscrew.report.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable import certified as m4
from leadscrew.studies.npid_xytable import random_plants
from leadscrew.studies.npid_xytable.calibration import LINES_HZ
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.scenarios import SPEEDS
from leadscrew.studies.npid_xytable.trials import Trial, trial
from leadscrew.studies.study import Picture

DRAWS = 6


def certified_pictures(loops: Loops) -> list[Picture]:
    """The rows of M4, and the random plants."""
    return [
        Picture("m4_rows", "Moonshot M4: the proved law in two paths against the best linear PID of the same Ms and "
                "the same change of the output at rest. Left, how it parts the error; right, the rows of Table II at "
                "1 mm.",
                partial(m4_rows, loops)),
        Picture("proof_gap", "What is proved and what is true, on random plants with delay: each gain in parts of the "
                "Nyquist limit of its plant. Up to a mark it is proved, beyond the cross an example breaks it, between "
                "the two nothing is known.", proof_gap),
    ]  # fmt: skip


def m4_rows(loops: Loops) -> Figure:
    """The two parts of the error, and the rows of both laws."""
    figure = Figure(figsize=(8.6, 3.6), layout="constrained")
    law, bars = figure.subplots(1, 2, width_ratios=(1.0, 2.2))
    error = np.linspace(0.0, 3.0, 200)
    small = 1e3 * np.array([parted(m4.SPLIT.params, 1e-3 * e) for e in error])
    law.plot(error, small, color=SKY, label="to the quiet PID")
    law.plot(error, error - small, color=VERMILION, label="to the firm PID")
    law.set(xlabel="error, um", ylabel="part of the error, um")
    law.legend(frameon=False, fontsize="small")
    place = np.arange(len(SPEEDS) * len(LINES_HZ)) + np.repeat(np.arange(len(SPEEDS)), len(LINES_HZ))
    shown: list[tuple[str, str, Trial]] = [
        ("best linear PID", ORANGE, trial(loops, m4.LINEAR, draws=DRAWS)),
        ("proved law in two paths", BLUE, trial(loops, m4.SPLIT, draws=DRAWS)),
    ]
    for k, (name, colour, found) in enumerate(shown):
        bars.bar(place + 0.4 * (k - 0.5), found.by_row(), 0.4, color=colour, label=name)
    middle = place.reshape(len(SPEEDS), -1)
    bars.set_xticks(place, [f"{f:g}" for f in LINES_HZ] * len(SPEEDS), fontsize="x-small")
    top = 1.3 * float(shown[0][2].by_row().max())
    for rpm, at in zip(SPEEDS, middle, strict=True):
        bars.text(float(at.mean()), 0.86 * top, f"{rpm} 1/min", ha="center", fontsize="small")
    bars.set(xlabel="line, Hz", ylabel="amplitude of the error, um", ylim=(0.0, top))
    bars.legend(frameon=False, fontsize="small", ncols=2, loc="upper center")
    return figure


def proof_gap() -> Figure:
    """A line a plant: circle and switching, Tsypkin, in parts of the Nyquist limit."""
    found = sorted(random_plants.gaps(), key=lambda g: g.circle / g.nyquist)
    figure = Figure(figsize=(8.2, 4.4), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(found))
    proved = np.array([g.circle / g.nyquist for g in found])
    broken = np.array([g.switching / g.nyquist for g in found])
    axes.hlines(rows, proved, broken, color=SKY, linewidth=3.0, label="gains that vary: unknown")
    axes.plot(proved, rows, "o", color=BLUE, markersize=5, label="gains that vary: proved (circle)")
    axes.plot(broken, rows, "x", color=VERMILION, markersize=7, label="broken by a switching gain")
    axes.plot([g.tsypkin / g.nyquist for g in found], rows, "s", color=GREEN, markersize=4.5, markerfacecolor="none",
              label="fixed monotone laws: proved (Tsypkin)")  # fmt: skip
    axes.plot([g.simulated / g.nyquist for g in found], rows, "|", color=PURPLE, markersize=10,
              label="fixed gain: limit in simulation")  # fmt: skip
    axes.set(xlabel="upper bound of the sector from 0, in parts of the Nyquist limit", ylabel="plant", xlim=(0.0, 1.06))
    axes.set_yticks([])
    axes.grid(axis="x", alpha=0.3)
    figure.legend(loc="outside lower center", ncols=3, fontsize="small", frameon=False)
    return figure
