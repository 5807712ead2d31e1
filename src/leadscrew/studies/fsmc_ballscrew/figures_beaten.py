"""Pictures of the controller that learns its friction: what it leaves, how fast it learns, and its circle."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from leadscrew.friction.lugre import LuGre
from leadscrew.report.ballbar_picture import CIRCLE, COLOURS, WORDS, centred, division_um, polar
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION, pen
from leadscrew.studies.fsmc_ballscrew.beaten import BEFORE, OURS, Runs
from leadscrew.studies.fsmc_ballscrew.claims_beaten import TURNS
from leadscrew.studies.fsmc_ballscrew.claims_circle import both
from leadscrew.studies.fsmc_ballscrew.naming import WAY
from leadscrew.studies.fsmc_ballscrew.runs import PERIOD_S, Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.study import Picture

PERIODS = {"sine_slow": 2.0 * math.pi, "sine_wide": 2.0 * math.pi, "sine_fast": 1.0}
"""Of the sines, in s."""
NEAR = {"sine_slow": 1.5, "sine_wide": 0.03, "sine_fast": 0.012}
"""Time on both sides of a reversal in the right column, s."""
ASKED = 0.05
"""The largest error that is asked for, um."""
WAY_S = 12.0
"""Of learning shown on the fast sine."""
LEARNED = (("F_C", r"$F_C$", BLUE, "-"), ("sigma_0", r"$\sigma_0 = F_C / g$", VERMILION, "--"),
           ("sigma_1", r"$\sigma_1$", GREEN, "-."), ("sigma_2", r"$\sigma_2$", ORANGE, ":"))  # fmt: skip


def beaten_pictures(loops: Loops, runs: Runs | None = None) -> list[Picture]:
    """All of them, drawn on demand; ``runs`` of the claims saves making them again."""
    kept = runs or Runs(loops)
    return [
        Picture("learned_sines", "The reversal with the largest error of each sine, after learning, at 4 kHz with a "
                "scale of 10 nm: a PD with disturbance observer that believes Table 2's hats, and the one that learns "
                "its friction. Right, near the reversal at time 0; each is drawn as far as its run lasts.",
                partial(sines, kept)),
        Picture("learned_way", "Above, the largest error at each reversal from the first on; below, what is learned "
                "on sin 2 pi t mm, over the truth.", partial(way, kept)),
        Picture("learned_circle", "R = 100 mm at 1,000 mm/min, before and after, with the same magnification.",
                partial(circle, kept)),
    ]  # fmt: skip


def late(runs: Runs, name: str, scenario: str) -> Any:
    """True error in um over a run that the claims judge, up to its end; the second half counts."""
    if name == "ours.pd_dob":
        return 1e3 * runs.loops.run(name, scenario)["true_error"]
    return runs.error(OURS, scenario)


def around(error: Any, period: float) -> tuple[Any, Any]:
    """Time in s from the reversal with the largest error of the second half, and half a period to both sides.

    A reversal at the negative end is drawn with its error turned round, as if it were at the positive one.
    """
    half = 0.5 * period
    worst = len(error) // 2 + int(np.abs(error[len(error) // 2 :]).argmax())
    reversal = math.floor(worst * PERIOD_S / half)
    centre = (reversal + 0.5) * half
    t = np.arange(len(error)) * PERIOD_S - centre
    inside = (np.abs(t) <= half) & (np.arange(len(error)) >= len(error) // 2)
    return t[inside], (1.0 if reversal % 2 == 0 else -1.0) * error[inside]


def sines(runs: Runs) -> Figure:
    """True error from half a period before to half a period after the worst reversal, and near it."""
    figure = Figure(figsize=(9.6, 7.2), layout="constrained")
    panels: Any = figure.subplots(3, 2, sharey="row", width_ratios=(3, 2))
    for (left, right), scenario in zip(panels, SINES, strict=True):
        largest = []
        for name in ("ours.pd_dob", "ours.pd_learned"):
            error = late(runs, name, scenario)
            largest.append(float(np.abs(error[len(error) // 2 :]).max()))
            t, e = around(error, PERIODS[scenario])
            near = np.abs(t) <= NEAR[scenario]
            left.plot(t, e, linewidth=0.8, **pen(name))
            right.plot(1e3 * t[near], e[near], linewidth=1.0, **pen(name))
        for axes in (left, right):
            axes.grid(color="0.92", linewidth=0.6)
            for limit in (-ASKED, ASKED):
                axes.axhline(limit, color="0.5", linewidth=0.8, linestyle=":")
        left.set_title(f"{WAY[scenario]}: largest {largest[0]:.3f} and {largest[1]:.3f} µm", fontsize="medium",
                       loc="left")  # fmt: skip
        left.set_ylabel("true error (µm)")
        right.xaxis.set_major_locator(MaxNLocator(5))
    panels[-1][0].set_xlabel("time from the reversal (s)")
    panels[-1][1].set_xlabel("time from the reversal (ms)")
    handles, labels = panels[0][0].get_legend_handles_labels()
    handles.append(panels[0][0].lines[-1])
    figure.legend(handles, [*labels, f"±{ASKED:g} µm, asked"], loc="outside lower center", ncols=3, frameon=False)
    return figure


def learned_over_truth(runs: Runs) -> tuple[Any, dict[str, Any]]:
    """Time in s, and by name what is learned on the fast sine over the stage's parameter."""
    live = runs.loops.get(OURS, "sine_fast").start()
    run = live.advance(round(WAY_S / PERIOD_S), record=("controller",), every=4)
    truth = LuGre()
    return run.time, {
        "F_C": run["controller.coulomb"] / truth.coulomb,
        "sigma_0": run["controller.coulomb"] / run["controller.bend"] / truth.stiffness,
        "sigma_1": run["controller.bristle_damping"] / truth.damping,
        "sigma_2": run["controller.viscous"] / truth.viscous,
    }


def way(runs: Runs) -> Figure:
    """Peaks by reversal, and the parameters over time."""
    figure = Figure(figsize=(7.4, 7.0), layout="constrained")
    above, below = figure.subplots(2, 1)
    for scenario, ink, mark in (("sine_wide", BLUE, "s"), ("sine_fast", BLACK, "o")):
        peaks = runs.by_reversal(OURS, scenario)
        above.semilogy(np.arange(1, len(peaks) + 1), peaks, color=ink, marker=mark, markersize=4, linewidth=1.0,
                       label=f"learning, {WAY[scenario]}")  # fmt: skip
        before = tail_um(runs.loops.run("ours.pd_dob", scenario))[0]
        above.axhline(before, color=ink, linestyle="--", linewidth=1.0, label=f"ours.pd_dob, {WAY[scenario]}")
    above.axhline(ASKED, color="0.5", linestyle=":", label=f"{ASKED:g} µm, asked")
    above.set(xlabel="reversal", ylabel="largest error around it (µm)")
    t, found = learned_over_truth(runs)
    for name, label, ink, line in LEARNED:
        below.semilogx(t, found[name], color=ink, linestyle=line, label=label)
    below.axhline(1.0, color="0.5", linewidth=0.8, zorder=0)
    for reversal in range(6):
        below.axvline(0.25 + 0.5 * reversal, color="0.85", linewidth=0.8, zorder=0)
    below.set(xlabel="time on sin 2 pi t mm (s); grey: the first six reversals", ylabel="learned over true",
              xlim=(t[1], WAY_S))  # fmt: skip
    for axes in (above, below):
        axes.grid(color="0.92", linewidth=0.6)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    return figure


def circle(runs: Runs) -> Figure:
    """Polar traces of both controllers, a division the same."""
    from matplotlib.lines import Line2D

    figure = Figure(figsize=(9.6, 5.7), layout="constrained")
    tests = {"ours.pd_dob": runs.circle(BEFORE, 2.0), "ours.pd_learned": runs.circle(OURS, TURNS)}
    paths = {name: centred(test) for name, test in tests.items()}
    division = max(division_um(max(float(np.abs(r).max()) for _, r in p.values())) for p in paths.values())
    far = max(float(r.max()) for p in paths.values() for _, r in p.values())
    for i, (name, test) in enumerate(tests.items()):
        axes: Any = figure.add_subplot(1, 2, i + 1, projection="polar")
        polar(axes, paths[name], division, test)
        axes.set_rlim(0.0, CIRCLE + far / division + 0.6)
        axes.set_title(f"{name}: G(b) {both(test).circular:.4f} µm\n{axes.get_title()}", fontsize="small")
    lines = [Line2D([], [], color=colour) for colour in COLOURS.values()]
    figure.legend(lines, [WORDS[d] for d in COLOURS], loc="outside lower center", ncols=2, frameon=False)
    return figure
