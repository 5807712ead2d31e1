"""Pictures of a tuning: how the search went, before and after on held-out plants, the Pareto front."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadscrew import escape
from leadscrew.report.style import BLACK, BLUE, ORANGE, VERMILION
from leadscrew.tune.objective import Constraint, Goal
from leadscrew.tune.tuned import Tuned


def figures(tuned: Tuned, units: dict[str, str] | None = None) -> dict[str, Figure]:
    """All of them, by name."""
    found = {"search": search(tuned, units or {}), "held_out": held_out(tuned, units or {})}
    return found | ({"front": front(tuned, units or {})} if tuned.front else {})


def _plain(ax: Axes) -> None:
    ax.grid(color="0.92", linewidth=0.6)
    ax.set_axisbelow(True)


def label(wanted: Goal, units: dict[str, str]) -> str:
    """What an axis is called."""
    unit = units.get(wanted.metric, "")
    where = f"\n{wanted.scenario}" if wanted.scenario else ""
    return f"{wanted.statistic} {wanted.metric.replace('_', ' ')}{f' ({unit})' if unit and unit != '1' else ''}{where}"


def search(tuned: Tuned, units: dict[str, str]) -> Figure:
    """The best goal after each population; a cross while it still missed a constraint."""
    count = len(tuned.goals)
    figure = Figure(figsize=(7.0, 1.0 + 2.4 * count), layout="constrained")
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    x = np.array([g.evaluations for g in tuned.history])
    missed = np.array([g.violation > 0.0 for g in tuned.history])
    for i, (ax, wanted) in enumerate(zip(axes, tuned.goals, strict=True)):
        y = np.array([g.best[i] for g in tuned.history])
        ax.plot(x[~missed], y[~missed], color=BLUE, linewidth=1.2, drawstyle="steps-post", marker="o", markersize=2.5,
                label="best so far")  # fmt: skip
        if missed.any():
            ax.plot(x[missed], y[missed], "x", color=VERMILION, markersize=5, label="misses a constraint")
        before = tuned.before.values[str(wanted)]
        if np.isfinite(before):
            ax.axhline(before, color=BLACK, linewidth=0.9, linestyle=":", label="before")
        ax.set_ylabel(label(wanted, units))
        _plain(ax)
    axes[0].legend(frameon=False, fontsize="small")
    axes[-1].set_xlabel("evaluations")
    axes[0].set_title(
        f"{escape.figure(str(tuned.controller))}: {tuned.optimiser}, seed {tuned.seed}", fontsize="medium"
    )
    return figure


def held_out(tuned: Tuned, units: dict[str, str]) -> Figure:
    """Every metric that counts, before and after, one dot a held-out plant; lines are bounds."""
    shown: list[tuple[str, str]] = []
    for wanted in (*tuned.goals, *tuned.constraints):
        for scenario in tuned.scenarios:
            if wanted.scenario in ("", scenario) and (wanted.metric, scenario) not in shown:
                shown.append((wanted.metric, scenario))
    rows = -(-len(shown) // 3)
    columns = -(-len(shown) // rows)  # as even as it goes: four are two and two, not three and one
    figure = Figure(figsize=(1.0 + 2.9 * columns, 0.6 + 2.9 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, (metric, scenario) in zip(axes, shown, strict=False):
        for at, (name, colour) in enumerate((("before", ORANGE), ("tuned", BLUE))):
            strip(ax, at, tuned.samples[name].metrics[scenario][metric], colour)
        for c in _bounds(tuned.constraints, metric, scenario):
            ax.axhline(c.bound, color=VERMILION, linewidth=1.0, linestyle="--")
            ax.annotate(f"{'≤' if c.at_most else '≥'} {c.bound:g}", (1.45, c.bound), color=VERMILION, fontsize="small",
                        ha="right", va="bottom" if c.at_most else "top")  # fmt: skip
        ax.margins(y=0.12)
        ax.set_xticks([0, 1], ["before", "tuned"])
        ax.set_xlim(-0.5, 1.5)
        unit = units.get(metric, "")
        ax.set_ylabel(f"{metric.replace('_', ' ')}{f' ({unit})' if unit and unit != '1' else ''}")
        ax.set_title(scenario, fontsize="small")
        _plain(ax)
    for ax in axes[len(shown) :]:
        ax.set_visible(False)
    figure.suptitle(f"{tuned.held_out_plants} held-out plant{'s' if tuned.held_out_plants > 1 else ''}; bar: median",
                    fontsize="medium")  # fmt: skip
    return figure


def _bounds(constraints: tuple[Constraint, ...], metric: str, scenario: str) -> list[Constraint]:
    return [c for c in constraints if c.metric == metric and c.scenario in ("", scenario)]


def strip(ax: Axes, at: float, values: np.ndarray, colour: Any, width: float = 0.28, flat: bool = False) -> None:
    """Dots side by side in the order of their number, a bar at the median; how many could not be judged in words.

    ``flat``: values lie along the x axis.
    """
    known = values[np.isfinite(values)]
    if len(known):
        across = at + width * (2.0 * (np.arange(len(known)) * 0.618034 % 1.0) - 1.0)
        middle, bar = [np.median(known)] * 2, [at - width, at + width]
        ax.plot(*((known, across) if flat else (across, known)), "o", color=colour, markersize=3.2, alpha=0.7,
                markeredgewidth=0.0)  # fmt: skip
        ax.plot(*((middle, bar) if flat else (bar, middle)), color=BLACK, linewidth=1.4)
    if len(known) < len(values):
        ax.annotate(
            f"{len(values) - len(known)} not judged", (0.98, at) if flat else (at, 0.02),
            xycoords=("axes fraction", "data") if flat else ("data", "axes fraction"), ha="right" if flat else "center",
            va="center" if flat else "bottom", fontsize="small", color=VERMILION,
        )  # fmt: skip


def front(tuned: Tuned, units: dict[str, str]) -> Figure:
    """Goals against each other: on the plants of the search and on held-out ones."""
    pairs = [(i, j) for i in range(len(tuned.goals)) for j in range(i + 1, len(tuned.goals))]
    figure = Figure(figsize=(0.6 + 5.4 * min(2, len(pairs)), 0.4 + 4.4 * -(-len(pairs) // 2)), layout="constrained")
    axes = figure.subplots(-(-len(pairs) // 2), min(2, len(pairs)), squeeze=False).ravel()
    trained, far = (
        np.array([[getattr(m, part).values[str(g)] for g in tuned.goals] for m in tuned.front])
        for part in ("trained", "held_out")
    )
    chosen = np.array([m.chosen for m in tuned.front])
    for ax, (i, j) in zip(axes, pairs, strict=False):
        for a, b in zip(trained, far, strict=True):
            ax.plot([a[i], b[i]], [a[j], b[j]], color="0.75", linewidth=0.7, zorder=1)
        ax.plot(trained[:, i], trained[:, j], "o", color=BLUE, markersize=4.5, label="plants of the search")
        ax.plot(
            far[:, i], far[:, j], "o", color=ORANGE, markersize=4.5, markerfacecolor="none", label="held-out plants"
        )
        ax.plot(trained[chosen, i], trained[chosen, j], "o", color=BLACK, markersize=10, markerfacecolor="none",
                label=f"taken: nearest to {'both' if len(tuned.goals) == 2 else 'all'} best")  # fmt: skip
        ax.set_xlabel(label(tuned.goals[i], units))
        ax.set_ylabel(label(tuned.goals[j], units))
        _plain(ax)
    for ax in axes[len(pairs) :]:
        ax.set_visible(False)
    axes[0].legend(frameon=False, fontsize="small")
    axes[0].set_title(f"{escape.figure(str(tuned.controller))}: Pareto front", fontsize="medium")
    return figure
