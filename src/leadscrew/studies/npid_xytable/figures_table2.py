"""Table II as bars, its wrong percentages marked, and the two spectra that the paper prints of it."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import colour
from leadscrew.studies.npid_xytable.scenarios import SPEEDS
from leadscrew.studies.npid_xytable.table2 import at, compared
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PID, NPID = "paper.pid", "corrected.npid_um"
"""Whose colours the columns have."""

TITLES = {"npid_um": "N-PID FFT tracking error at spindle speed of 1000 rpm",
          "pid_um": "PID FFT tracking error at spindle speed of 1000 rpm"}  # fmt: skip
"""Captions of the paper's figures, printed as 4 and 5, named 5 and 6 in its text."""


def table2_pictures() -> list[Picture]:
    """Three pictures."""
    return [
        Picture(
            "table2_printed",
            "Table II as printed. Above each pair the printed reduction; where it does not follow from the two "
            "amplitudes it is framed, with the right one below it",
            bars,
        ),
        *(
            Picture(
                f"spectrum_{field.removesuffix('_um')}_1000",
                f"{title}: the lines of Table II (the paper's own figure is not in the text that we have)",
                partial(printed_spectrum, field),
            )
            for field, title in TITLES.items()
        ),
    ]


def bars() -> Figure:
    """Fifteen pairs of amplitudes with their percentages."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    for axes, rpm in zip(figure.subplots(1, 3, sharey=True), SPEEDS, strict=True):
        some = at(rpm)
        places = np.arange(len(some))
        for shift, field, name in ((-0.2, "pid_um", PID), (0.2, "npid_um", NPID)):
            axes.bar(places + shift, [getattr(r, field) for r in some], 0.38, color=colour(name),
                     label=field.removesuffix("_um").upper() if rpm == SPEEDS[0] else None)  # fmt: skip
        for place, row in zip(places, some, strict=True):
            top = max(row.pid_um, row.npid_um)
            text = f"{row.printed:g} %" if row.agrees else f"{row.printed:g} %\n({row.reduction:.0f} %)"
            frame = None if row.agrees else {"facecolor": "white", "edgecolor": "black", "pad": 2.0, "linewidth": 1.0}
            axes.annotate(text, (place, top), (0, 5), textcoords="offset points", ha="center", va="bottom",
                          fontsize="small", bbox=frame)  # fmt: skip
        found = compared(some)
        axes.set_title(f"{rpm:,} 1/min\nmean {found.mean:.2g} %, printed {found.printed_mean:.1f} %", fontsize="medium")
        axes.set_xticks(places, [f"{r.hz:g}" for r in some])
        axes.set_xlabel("printed frequency (Hz)")
        axes.set_ylim(0.0, 1.65)
        axes.grid(axis="y", color="0.9", linewidth=0.6)
        axes.set_axisbelow(True)
    figure.axes[0].set_ylabel("amplitude of the error (µm)")
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


def printed_spectrum(field: str) -> Figure:
    """A column of Table II at 1,000 1/min as lines: ``npid_um`` or ``pid_um``."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.0), layout="constrained")
    axes = figure.subplots()
    for row in at(1000):
        value = getattr(row, field)
        axes.vlines(row.hz, 0.0, value, color=colour(NPID if field == "npid_um" else PID), linewidth=2.0)
        axes.annotate(f"{value:g}", (row.hz, value), (0, 3), textcoords="offset points", ha="center", fontsize="small")
    axes.set_title(TITLES[field], fontsize="medium")
    axes.set(xlim=(0.0, 10.0), ylim=(0.0, 1.0), xlabel="frequency (Hz)", ylabel="amplitude (µm)")
    axes.grid(color="0.92", linewidth=0.6)
    return figure
