"""The picture of the ablation: what each predictor gains over the TFC, with intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, ORANGE
from leadscrew.studies.grey_turning.ablation import HELD_OUT, PLANTS, difference, judgement_of
from leadscrew.studies.grey_turning.claims_ablation import HELD, WORDS
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def ablation_pictures(loops: Loops) -> list[Picture]:
    """One picture."""
    return [
        Picture(
            "ablation",
            "Change of the cost J against the TFC, every controller tuned by itself with equal effort, on "
            f"{len(HELD_OUT)} noise seeds that no search saw; bars: mean and 95 % interval of the paired change; "
            "crosses: the digest, in its own cost; points: on the noise tuned on",
            lambda: _bars(loops),
        )
    ]


def _bars(loops: Loops) -> Figure:
    from matplotlib.figure import Figure

    found = judgement_of(loops)
    figure = Figure(figsize=(8.5, 4.2), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(WORDS))
    for k, (plant, hue) in enumerate(zip(PLANTS, (BLUE, ORANGE), strict=True)):
        tfc = found[plant, "tfc"]
        at = places + 0.36 * (k - 0.5)
        changes = [difference(found[plant, name], tfc) for name in WORDS]
        mean = np.array([c.percent for c in changes])
        ends = np.abs(np.array([[c.percent - c.low, c.high - c.percent] for c in changes])).T
        axes.bar(at, mean, 0.34, color=hue, yerr=ends, error_kw={"lw": 1.2, "capsize": 3},
                 label=f"plant {plant[-1].upper()}")  # fmt: skip
        trained = [100.0 * (found[plant, name].trained / tfc.trained - 1.0) for name in WORDS]
        axes.plot(at, trained, linestyle="", marker="o", markersize=4, color=BLACK, markerfacecolor="white",
                  label="on the noise tuned on" if k == 0 else None)  # fmt: skip
        digest = [HELD[plant].get(name, np.nan) for name in WORDS]
        axes.plot(at, digest, linestyle="", marker="x", color=BLACK, label="digest" if k == 0 else None)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    words = ("GPFC-B", "line of 4", "line of 2", "GM,\n2 ahead", "DGM(1,1)", "GPFC-A", "Smith", "exponential\ncorr.",
             "GM of\nresiduals", "Verhulst")  # fmt: skip
    axes.set_xticks(places, words)
    axes.set_ylabel("change of J against TFC (%)")
    axes.grid(axis="y", alpha=0.3)
    axes.legend(fontsize="small", loc="upper left", ncols=2)
    return figure
