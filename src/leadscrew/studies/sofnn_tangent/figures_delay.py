"""Pictures of the delay: where the loop of equation (3) settles, by simulation and by its roots; how much it bears."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.report.style import BLACK, BLUE, ORANGE, SKY, VERMILION, colour
from leadscrew.studies.sofnn_tangent.claims_delay import (
    HIGH_KE,
    LITERAL_KE,
    MAP,
    MIDDLE_KE,
    agreement,
    on_the_wave,
)
from leadscrew.studies.sofnn_tangent.delay import radius
from leadscrew.studies.sofnn_tangent.online import PNN, TABLE, TUNED
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FINE = tuple(range(0, 25, 2))


def delay_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("delay_map", "Whether a step settles, by the delay that the learning assumes and the true one. "
                "Marks: simulation (dot: settles, cross: swings). Shaded: all roots of the linear loop lie inside the "
                "unit circle. At the printed ranges nearly everything settles and the roots say so; with six times the "
                "gain a band remains, and large swings do not follow the roots.", partial(delay_map, loops)),
        Picture("delay_borne", "RMS on the wave in fabric by the true delay of the camera. The literal loops bear any; "
                "the accumulating form of the tuned one has to know it.", partial(delay_borne, loops)),
        Picture("delay_roots", "Largest root of the linear loop of equation (3) by the true delay, for the steady gain "
                "of the filter and for a replacement as (3) is printed (kappa = 1), m_c = 6, printed ranges.",
                delay_roots),
    ]  # fmt: skip


def delay_map(loops: Loops) -> Figure:
    """Three maps."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 3.9), layout="constrained")
    for axes, k_e, name in zip(
        figure.subplots(1, 3, sharey=True),
        (LITERAL_KE, MIDDLE_KE, HIGH_KE),
        ("k_e = 6/90, printed", "k_e = 6/30", "k_e = 6/15"),
        strict=True,
    ):
        seen = agreement(loops, k_e)
        axes.pcolormesh(*MAP, np.where(seen.stable.T, 1.0, np.nan), cmap="Blues", vmin=0.0, vmax=4.0, shading="nearest")
        for i, assumed in enumerate(MAP[0]):
            for j, late in enumerate(MAP[1]):
                settles = bool(seen.settled[i, j])
                axes.plot(assumed, late, "o" if settles else "x", color=BLUE if settles else VERMILION, markersize=5)
        axes.plot([2, 16], [0, 14], color=BLACK, linewidth=0.8, linestyle=":")
        axes.set(title=f"{name}: {seen.same} of {seen.points} agree", xlabel="assumed delay m_c, samples",
                 xticks=MAP[0])  # fmt: skip
    figure.axes[0].set_ylabel("true delay m of the camera, samples")
    return figure


def delay_borne(loops: Loops) -> Figure:
    """RMS by true delay."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    axes = figure.subplots()
    for name, values, label, style in (
        (TABLE, {"delay": 4}, "literal, table, m_c = 4", "-"),
        (TABLE, {"delay": 6}, "literal, table, m_c = 6", "--"),
        (PNN, {"delay": 4}, "literal, network, m_c = 4", "-"),
        (TUNED, {}, "accumulate, kg = 0.7", "-"),
        (TUNED, {"kg": 0.4}, "accumulate, kg = 0.4", "--"),
    ):
        means = [float(on_the_wave(loops, name, m, **values).mean()) for m in FINE]
        axes.plot(FINE, means, marker="o", markersize=3, color=colour(name), linestyle=style, label=label)
    none = float(on_the_wave(loops, "paper.uncompensated", 0).mean())
    axes.axhline(none, color=BLACK, linestyle=":", linewidth=1.0, label="without compensation")
    axes.set(
        xlabel="true delay of the camera, samples of 10 ms", ylabel="RMS deviation, deg", yscale="log", xlim=(0, 24)
    )
    figure.legend(fontsize="small", loc="outside upper center", ncols=2)
    axes.grid(alpha=0.3, which="both")
    return figure


def delay_roots() -> Figure:
    """Largest root by true delay."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.5), layout="constrained")
    axes = figure.subplots()
    late = range(25)
    axes.plot(late, [radius(6, m, LITERAL_KE) for m in late], color=BLUE, marker="o", markersize=3,
              label="Kalman filter, kappa = 0.854")  # fmt: skip
    axes.plot(late, [radius(6, m, LITERAL_KE, kappa=1.0) for m in late], color=VERMILION, marker="s", markersize=3,
              label="replaced at once, kappa = 1")  # fmt: skip
    axes.plot(late, [radius(6, m, MIDDLE_KE) for m in late], color=ORANGE, marker="^", markersize=3,
              label="Kalman filter, k_e = 6/30")  # fmt: skip
    axes.axhspan(1.0, 1.06, color=SKY, alpha=0.3, linewidth=0.0)
    axes.annotate("unstable", (0.3, 1.045), color=BLACK)
    axes.set(xlabel="true delay of the camera, samples", ylabel="largest root", xlim=(0, 24), ylim=(0.94, 1.06))
    figure.legend(fontsize="small", loc="outside upper center", ncols=3)
    axes.grid(alpha=0.3)
    return figure
