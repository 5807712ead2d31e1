"""How a recorded run used the rules: inputs and outputs against time, and below them a row for each rule that fired."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLACK, BLUE
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.explanation import activity, rising
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import Rule, System
from leadscrew.report.fuzzy.words import GREY, HATCH, SMALL, labelled, short, ticks
from leadscrew.util import escape
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

WIDEST = 1200
"""Columns of the map; rows of a longer run are put together, each rule at its strongest."""
TEXTS = 36
"""Rules that get their text; of more, only the numbers stand there."""
NUMBERS = 60
LETTERS = 60


def activity_figure(system: System, time: Any, points: Any, *, unit: str = "s") -> Figure:
    """The strength of the rules along a run: only rules that fire, in the order of the system.

    ``points`` holds one row for each time and one column an input. Times in which no rule fires are hatched. Without a
    ``unit`` the times are the numbers of the rows.

    Raises:
        ValueRefused: times that do not rise, points of another shape or less than two of them.
    """
    from leadscrew.figures.figure import Figure

    x = np.asarray(points, dtype=float)
    strengths = np.nan_to_num(activity(system, x))
    t = rising(time, len(x))
    if len(t) < 2:
        raise ValueRefused(f"{len(t)} points of a run: a picture needs two or more")
    y = compiled(system).many(x).reshape(len(x), -1)
    variables = [*system.inputs, *system.outputs]
    fired = np.flatnonzero((strengths > 0.0).any(axis=0))
    row = 0.155 if len(fired) <= TEXTS else max(0.03, 5.5 / len(fired))
    heights = [0.75] * len(variables) + [max(0.8, row * len(fired))]
    figure = Figure(figsize=(8.0, 0.9 + 1.12 * sum(heights)), layout="constrained")
    axes = figure.subplots(len(heights), 1, sharex=True, gridspec_kw={"height_ratios": heights})
    for at, (variable, signal) in enumerate(zip(variables, np.column_stack([x, y]).T, strict=True)):
        axes[at].plot(t, signal, color=BLUE if at < len(system.inputs) else BLACK, linewidth=1.1)
        axes[at].set_ylabel(labelled(variable, 36), fontsize=8, rotation=0, ha="right", va="center")
        axes[at].grid(color="0.92", linewidth=0.6)
        ticks(axes[at].yaxis, count=4)
    _rules(axes[-1], system, t, strengths, fired)
    axes[-1].set_xlabel(f"time ({unit})" if unit else "row", fontsize=8)
    axes[-1].set_xlim(t[0], t[-1])
    ticks(axes[-1].xaxis, count=9)
    figure.suptitle(
        escape.figure(f"{short(system.name, 60)}: {len(fired)} of {len(system.rules)} rules fire"), fontsize="medium"
    )
    figure.align_ylabels(axes[:-1])
    return figure


def _rules(ax: Any, system: System, t: np.ndarray, strengths: np.ndarray, fired: np.ndarray) -> None:
    """The map of the rules."""
    from matplotlib.patches import Patch

    few = len(fired) <= TEXTS
    if not fired.size:
        ax.text(0.5, 0.5, "no rule fires", transform=ax.transAxes, ha="center", va="center", color=GREY)
        ax.set_yticks([])
        return
    edges, cells = gathered(t, strengths[:, fired])
    none = ~(gathered(t, strengths.max(axis=1, keepdims=True), np.minimum)[1][:, 0] > 0.0)
    if none.any():
        where = np.append(none, none[-1]).tolist()
        ax.fill_between(edges, 0, 1, where=where, step="post", transform=ax.get_xaxis_transform(), **HATCH)
        patch: Any = Patch(label="no rule fires", **HATCH)
        ax.legend(handles=[patch], fontsize=SMALL, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False,
                  borderaxespad=0.1)  # fmt: skip
    mesh = ax.pcolormesh(edges, np.arange(len(fired) + 1) - 0.5, np.ma.masked_less_equal(cells.T, 0.0),
                         cmap="viridis_r", vmin=0.0, vmax=max(1.0, float(cells.max())), rasterized=True)  # fmt: skip
    ax.set_ylim(len(fired) - 0.5, -0.5)
    ax.set_yticks(range(len(fired)), _labels(system, fired), fontsize=6.5 if few else 5.5)
    ax.set_yticks(np.arange(len(fired) - 1) + 0.5, minor=True)
    ax.grid(which="minor", axis="y", color="0.9", linewidth=0.5 if few else 0.2)
    ax.tick_params(axis="y", which="both", length=0)
    if not few:
        ax.set_ylabel("rule", fontsize=8)
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.01, aspect=30)
    bar.set_label("strength of the rule" if len(fired) > 6 else "strength", fontsize=8)
    ticks(bar.ax.yaxis)


def brief(rule: Rule) -> str:
    """A rule as short as it can be said: ``e ZE and de NS → u NS``."""
    for most in (LETTERS, 14, 10, 7, 5):
        text = rule_text(rule, partial(short, most=most))
        text = text.removeprefix("if ").replace(" then ", " → ").replace(" is ", " ")
        if len(text) <= LETTERS:
            return text
    asked, _, then = text.partition(" → ")
    then = short(then, LETTERS - 11)
    return f"{short(asked, LETTERS - len(then) - 3)} → {then}"


def _labels(system: System, fired: np.ndarray) -> list[str]:
    """Text and number of each rule that fired; only every few numbers where there are many."""
    if len(fired) > TEXTS:
        every = -(-len(fired) // NUMBERS)
        return [str(i + 1) if k % every == 0 else "" for k, i in enumerate(fired)]
    rules = system.rules
    return [escape.figure(f"{brief(rules[i])}  {i + 1:>3}") for i in fired]


def gathered(t: np.ndarray, strengths: np.ndarray, by: Any = np.maximum) -> tuple[np.ndarray, np.ndarray]:
    """Edges in time and the strengths between them: rows of a long run are put together, the strongest counts."""
    starts = np.arange(len(t)) if len(t) <= WIDEST else np.unique(np.linspace(0, len(t) - 1, WIDEST).astype(int))
    return np.append(t[starts], 2.0 * t[-1] - t[-2]), by.reduceat(strengths, starts, axis=0)
