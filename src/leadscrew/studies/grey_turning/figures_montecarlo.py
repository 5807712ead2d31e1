"""Pictures of the Monte Carlo: distributions of the overshoot, and pairs of TFC and GPFC on the same draws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, GREEN, VERMILION
from leadscrew.studies.grey_turning.montecarlo import BAD_OVERSHOOT, COUNTS
from leadscrew.studies.grey_turning.montecarlo_runs import MonteCarlo, montecarlo_of
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAWS = (
    ("corrected.tfc", "TFC", VERMILION, "-"), ("corrected.gpfc_b", "GPFC-B", BLUE, "-"),
    ("ours.two_point", "two-point", GREEN, "--"),
)  # fmt: skip
DISTRIBUTIONS = ("s6", "s9", "s9_half")
PAIRS = (("s6", "plant_f"), ("s9_half", "plant_f"), ("stfc", "plant_f"), ("sbn", "plant_n"))
LEAST = 0.3
"""Percent: smaller overshoots are drawn there."""


def montecarlo_pictures(loops: Loops) -> list[Picture]:
    """Two pictures."""
    made = montecarlo_of(loops)
    return [
        Picture(
            "montecarlo_overshoot",
            f"Overshoot of the filtered force on {COUNTS['plant_f']} random plants F, the same draws and factors for "
            "all three laws; right of the dotted line a run is bad by its overshoot",
            lambda: _distributions(made),
        ),
        Picture(
            "montecarlo_pairs",
            "Overshoot of GPFC-B against TFC draw by draw, four sets of factors; below the line GPFC overshoots less. "
            f"Overshoots below {LEAST:g} % are drawn at {LEAST:g} %",
            lambda: _pairs(made),
        ),
    ]


def _distributions(made: MonteCarlo) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    for axes, factors in zip(figure.subplots(1, len(DISTRIBUTIONS), sharey=True), DISTRIBUTIONS, strict=True):
        for law, words, hue, line in LAWS:
            seen = np.maximum(made.of(f"{law}_{factors}").overshoot, LEAST)
            axes.ecdf(seen, color=hue, linestyle=line, label=words)
        axes.axvline(BAD_OVERSHOOT, color=BLACK, linestyle=":", linewidth=1.0)
        axes.set_xscale("log")
        axes.set_xlim(LEAST, 300.0)
        axes.set_xlabel("overshoot (%)")
        axes.set_title(f"factors {factors}", fontsize="medium", loc="left")
        axes.grid(alpha=0.3)
        if factors == DISTRIBUTIONS[0]:
            axes.set_ylabel("share of the draws")
            axes.legend(fontsize="small", loc="lower right")
    return figure


def _pairs(made: MonteCarlo) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 7.0), layout="constrained")
    for axes, (factors, plant) in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, PAIRS, strict=True):
        tfc, b = (made.of(f"{law}_{factors}", plant) for law in ("corrected.tfc", "corrected.gpfc_b"))
        spoiled = b.bad & ~tfc.bad
        for chosen, hue, mark, words in (
            (~tfc.bad & ~b.bad, GREEN, "o", "neither is bad"), (tfc.bad & ~b.bad, BLUE, "^", "TFC alone is bad"),
            (tfc.bad & b.bad, VERMILION, "x", "both are bad"), (spoiled, BLACK, "s", "GPFC-B alone is bad"),
        ):  # fmt: skip
            at = (np.maximum(each.overshoot[chosen], LEAST) for each in (tfc, b))
            axes.plot(*at, linestyle="", marker=mark, markersize=4, color=hue, alpha=0.7,
                      label=f"{words}: {int(chosen.sum())}")  # fmt: skip
        axes.plot([LEAST, 300.0], [LEAST, 300.0], color=BLACK, linewidth=0.8)
        axes.set(xscale="log", yscale="log", xlim=(0.9 * LEAST, 300.0), ylim=(0.9 * LEAST, 300.0), aspect="equal")
        axes.set_title(f"{factors}, plant {plant[-1].upper()}, {len(tfc.bad)} draws", fontsize="medium", loc="left")
        axes.grid(alpha=0.3)
        axes.legend(fontsize="x-small", loc="upper left")
    figure.supxlabel("overshoot of TFC (%)")
    figure.supylabel("overshoot of GPFC-B (%)")
    return figure
