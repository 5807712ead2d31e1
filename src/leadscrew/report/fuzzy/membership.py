"""The membership functions of a system, a panel for each variable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.fuzzy.circuit import CONSEQUENTS
from leadscrew.fuzzy.shapes import membership_function
from leadscrew.fuzzy.system import System, Term, Variable
from leadscrew.fuzzy.tables import peak
from leadscrew.report.fuzzy.words import (
    COLOURS,
    GREY,
    SMALL,
    dark,
    ends,
    formula,
    kind,
    labelled,
    number,
    pen,
    short,
    ticks,
)
from leadscrew.util import escape

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from leadscrew.figures.figure import Figure

POINTS = 1001
PANEL = (3.5, 1.85)
"""Inches of a panel."""
ROWS = 3
"""Rows of labels above a panel; terms that need more go to a legend."""
LINES = 9
"""Lines of text in a panel."""
LEGEND_ROW = 0.12
"""Inches of a row of a legend."""
MOST_NAMES = 24
"""Names in a legend; more terms are only counted."""


def membership_figure(system: System) -> Figure:
    """Every variable of a system: its terms over its universe; Takagi-Sugeno consequents as stems or formulas."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    from leadscrew.figures.figure import Figure

    variables: list[Variable] = [*system.inputs, *system.outputs]
    across = 1 if len(variables) == 1 else 2
    down = -(-len(variables) // across)
    figure = Figure(
        figsize=(PANEL[0] * across, 0.35 + PANEL[1] * down), layout=ConstrainedLayoutEngine(h_pad=0.06, w_pad=0.06)
    )
    axes = figure.subplots(down, across, squeeze=False).ravel()
    more = [0.0] * down
    for at, variable in enumerate(variables):
        more[at // across] = max(more[at // across], LEGEND_ROW * _panel(axes[at], system, variable))
    figure.set_figheight(figure.get_figheight() + sum(more))
    for ax in axes[len(variables) :]:
        ax.set_axis_off()
    figure.suptitle(escape.figure(short(system.name, 80)), fontsize="medium")
    return figure


def _panel(ax: Axes, system: System, variable: Variable) -> int:
    """Draws a variable; gives the rows of its legend."""
    words = f"{kind(variable)}, {number(variable.low)} to {number(variable.high)}"
    # a bold letter is about 0.68, another 0.53 of its size wide
    room = (72.0 * (PANEL[0] - 0.55) - 0.53 * SMALL * len(words)) / 0.68
    size = max(6.5, min(9.0, room / len(labelled(variable))))
    ax.set_title(labelled(variable, int(room / size)), loc="left", fontsize=size, fontweight="bold")
    ax.set_title(words, loc="right", fontsize=SMALL, color=GREY)
    ticks(ax.xaxis, ax.yaxis)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    if not variable.terms:
        _texts(ax, ["no terms"])
    elif any(term.shape == "linear" for term in variable.terms):
        _texts(ax, [f"{term.name} = {formula(term, system)}" for term in variable.terms])
    elif all(term.shape in CONSEQUENTS for term in variable.terms):
        return _stems(ax, system, variable)
    else:
        return _sets(ax, system, variable)
    return 0


def _texts(ax: Axes, lines: list[str]) -> None:
    """Sentences instead of curves."""
    ax.set_axis_off()
    shown = lines if len(lines) <= LINES else [*lines[: LINES - 1], f"and {len(lines) - LINES + 1} more"]
    text = "\n".join(escape.figure(short(line, 62)) for line in shown)
    ax.text(0.02, 0.97, text, transform=ax.transAxes, va="top", fontsize=SMALL + 0.5, linespacing=1.45)


# ---- sets
def _sets(ax: Axes, system: System, variable: Variable) -> int:
    low, high = ends(system, variable)
    labels, tallest = [], max(1.0, *(t.height for t in variable.terms))
    for at, term in enumerate(variable.terms):
        colour = COLOURS[at % len(COLOURS)]
        if term.shape in ("singleton", "constant"):
            where = term.parameters[0]
            ax.plot([where, where], [0.0, term.height], color=colour, linewidth=1.4, marker="o", markevery=[1],
                    markersize=3.5)  # fmt: skip
        else:
            xs, ys = curve(term, low, high)
            ax.plot(xs, without_zeros(ys), linewidth=1.4, **pen(at))
            top = peak(term, low, high)
            where = float(xs[np.argmax(ys)]) if top != top or not low <= top <= high else top
        labels.append((min(max(where, low), high), term.name, colour))
    ax.set_xlim(low, high)
    ax.set_yticks([0.0, 0.5 * tallest, tallest])
    ax.set_ylabel("membership", fontsize=SMALL)
    return _named(ax, labels, tallest, (low, high))


def curve(term: Term, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """A set over its universe, with its corners and jumps where they are."""
    own = np.array(term.parameters[::2] if term.shape == "discrete" else term.parameters)
    own = own[np.isfinite(own) & (own >= low) & (own <= high)]
    near = np.concatenate([np.nextafter(own, -np.inf), own, np.nextafter(own, np.inf)])
    xs = np.union1d(np.linspace(low, high, POINTS), near[(near >= low) & (near <= high)])
    membership = membership_function(term)
    return xs, np.array([membership(float(x)) for x in xs])


def without_zeros(ys: np.ndarray) -> np.ndarray:
    """A set without the stretches where it is zero, which would hide one another."""
    nought = ys == 0.0
    inner = nought & np.append(nought[1:], True) & np.insert(nought[:-1], 0, True)
    return np.where(inner, np.nan, ys)


# ---- constants
def _stems(ax: Axes, system: System, variable: Variable) -> int:
    """Constants as stems; those of the same value as one."""
    values: dict[float, list[str]] = {}
    for term in variable.terms:
        values.setdefault(term.parameters[0], []).append(term.name)
    low, high = ends(system, variable)
    inside = [x for x in (*values, low, high) if np.isfinite(x)]
    pad = 0.04 * (max(inside) - min(inside))
    span = (min(inside) - pad, max(inside) + pad)
    labels = []
    for at, (x, names) in enumerate(sorted(values.items())):
        colour = COLOURS[at % len(COLOURS)]
        ax.plot([x, x], [0.0, 1.0], color=colour, linewidth=1.6, marker="o", markevery=[1], markersize=4)
        labels.append((x, f"{short(', '.join(names), 24)}\n{number(x)}", colour))
    ax.set_xlim(*span)
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    return _named(ax, labels, 1.0, span)


# ---- labels
def rows_of(places: list[tuple[float, float, float]]) -> list[int] | None:
    """The row of each label, given left end, right end; so that none touches its neighbour. None: too many rows."""
    free = [-np.inf] * ROWS
    found = [0] * len(places)
    for at in sorted(range(len(places)), key=lambda i: places[i][:2]):
        left, right, _ = places[at]
        row = next((r for r in range(ROWS) if left >= free[r]), None)
        if row is None:
            return None
        free[row], found[at] = right, row
    return found


def _named(ax: Axes, labels: list[tuple[float, str, str]], tallest: float, span: tuple[float, float]) -> int:
    """The names at the peaks, in as many rows as they need; a legend where these are too many, whose rows it gives."""
    letter = 0.62 * SMALL / 72.0 / (PANEL[0] - 0.75) * (span[1] - span[0])
    lines = max(text.count("\n") + 1 for _, text, _ in labels)
    places = []
    for x, text, _ in labels:
        wide = letter * (max(map(len, text.split("\n"))) + 0.8)
        left = min(max(x - 0.5 * wide, span[0] - 2.0 * letter), span[1] + 2.0 * letter - wide)
        places.append((left, left + wide, wide))
    rows = rows_of(places)
    if rows is None:
        return _legend(ax, labels, tallest)
    step = 0.125 * lines * tallest
    for (_, text, colour), (left, _, wide), row in zip(labels, places, rows, strict=True):
        ax.text(left + 0.5 * wide, (1.05 * tallest) + row * step, escape.figure(text), ha="center", va="bottom",
                fontsize=SMALL, color=dark(colour), linespacing=1.05)  # fmt: skip
    ax.set_ylim(0.0, 1.07 * tallest + (max(rows) + 1) * step)
    ax.spines["left"].set_bounds(0.0, tallest)
    return 0


def _legend(ax: Axes, labels: list[tuple[float, str, str]], tallest: float) -> int:
    ax.set_ylim(0.0, 1.07 * tallest)
    lines: list[Any] = ax.get_lines()
    names = [escape.figure(short(text.replace("\n", ": "), 18)) for _, text, _ in labels]
    if len(names) > MOST_NAMES:
        for line in lines:
            line.set(color=COLOURS[0], linestyle="-", linewidth=1.0, markersize=3.0)
        ax.set_xlabel(f"{len(names)} terms, from {names[0]} to {names[-1]}", fontsize=SMALL)
        return 1
    across = min(3, max(1, 48 // (max(map(len, names)) + 7)))
    ax.legend(lines, names, fontsize=6, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=across,
              handlelength=2.4, labelspacing=0.2, columnspacing=1.0, borderaxespad=0.3)  # fmt: skip
    return -(-len(names) // across)
