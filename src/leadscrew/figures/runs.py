"""The picture of a run, and of several runs over one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.figure import Figure
from leadscrew.figures.signals import signal_unit
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.figures.table import unit as shown_unit
from leadscrew.kernel.frame import pairs, signal_tree, under
from leadscrew.kernel.parameters import nearest
from leadscrew.util import escape
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run

AXIS_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
"""One for each axis of a machine, or for each of several runs."""
DASHES = ("-", "--", ":", "-.")
"""One for each number of a signal where the colour says which run it is."""

Line = tuple[str, str, dict[str, Any]]
"""A signal, its label and its style."""
Panel = tuple[str, list[Line]]
"""Title and lines."""


def run_figure(run: Run, signals: str | Sequence[str] | None = None) -> Figure:
    """Command and true output, true error, controller output against time, as far as they were recorded.

    A loop of several axes gives one line an axis. ``signals`` of the user's own choice get a panel each.

    Raises:
        NameUnknown: a signal that was not recorded.
    """
    panels = _chosen(run, signals)
    figure, axes = _panels(len(panels))
    for ax, (title, lines) in zip(axes, panels, strict=False):
        for name, label, style in lines:
            ax.plot(run.time, run.signals[name], label=label or None, linewidth=1.1, **style)
        ax.set_ylabel(_labelled(title, signal_unit(run.loop, lines[0][0])))
        if any(label for _, label, _ in lines):
            ax.legend(frameon=False, fontsize="small")
    axes[0].set_title(escape.figure(run.loop.name) + (f"\n{run.diverged}" if run.diverged else ""), fontsize="medium")
    figure.align_ylabels(axes)
    return figure


@entry_point
def plot_runs(runs: Sequence[Run] | Mapping[str, Run], signals: str | Sequence[str] | None = None) -> Figure:
    """Several runs over one another: a panel for each signal, a colour for each run, one legend.

    Args:
        runs: by name, or in a list; those of a list are named by the parameters in which they differ.
        signals: recorded names; command over true output, true error and output where not given.

    Raises:
        ValueRefused: no run, or runs that have a signal in different units.
        NameUnknown: a signal that a run did not record.
    """
    named = dict(runs) if isinstance(runs, Mapping) else dict(zip(_names(runs), runs, strict=True))
    if not named:
        raise ValueRefused("plot_runs: expected one run at least")
    chosen = {name: _chosen(run, signals) for name, run in named.items()}
    titles = list(dict.fromkeys(title for panels in chosen.values() for title, _ in panels))
    figure, axes = _panels(len(titles))
    handles: dict[str, Any] = {}
    for ax, title in zip(axes, titles, strict=False):
        units: dict[str, None] = {}
        commands: list[np.ndarray] = []
        for (name, run), colour in zip(named.items(), cycle(AXIS_COLOURS), strict=False):
            lines = next((lines for panel, lines in chosen[name] if panel == title), [])
            units |= dict.fromkeys(signal_unit(run.loop, signal) for signal, _, _ in lines[:1])
            own = [line for line in lines if line[2].get("color") != BLACK]
            for (signal, _, _), dash in zip(own, cycle(DASHES), strict=False):
                handles[name] = ax.plot(run.time, run.signals[signal], dash, color=colour, linewidth=1.1)[0]
            for signal, _, style in lines:
                values = run.signals[signal]
                if style.get("color") == BLACK and not any(np.array_equal(values, known) for known in commands):
                    handles.setdefault("command", ax.plot(run.time, values, linewidth=1.1, **style)[0])
                    commands.append(values)
        if len(units) > 1:
            raise ValueRefused(f"plot_runs: {title} is in {' and in '.join(u or 'no unit' for u in units)}")
        ax.set_ylabel(_labelled(title, *units))
    order = [*named, "command"]
    legend = {k: handles[k] for k in order if k in handles}
    figure.legend(
        legend.values(), [escape.figure(k) for k in legend], loc="outside lower center", ncols=3, frameon=False
    )
    figure.align_ylabels(axes)
    return figure


def _panels(count: int) -> tuple[Figure, Any]:
    figure = Figure(figsize=(7.0, 1.2 + 1.9 * max(1, count)), layout="constrained")
    axes = figure.subplots(max(1, count), 1, sharex=True, squeeze=False)[:, 0]
    for ax in axes:
        ax.grid(color="0.92", linewidth=0.6)
        ax.margins(x=0)
    axes[-1].set_xlabel("time (s)")
    return figure, axes


def _names(runs: Sequence[Run]) -> list[str]:
    """Names of runs by what tells them apart: the loop's name, else the parameters that differ, else a number."""
    names = [run.loop.name for run in runs]
    if len(set(names)) == len(names):
        return names
    sheets = [run.loop.parameters for run in runs]
    shared = [key for key in sheets[0] if all(key in sheet for sheet in sheets)]
    apart = [key for key in shared if any(not np.array_equal(s[key], sheets[0][key]) for s in sheets)]
    scalar = [key for key in apart if not np.shape(sheets[0][key])]
    names = [", ".join(f"{key} = {sheet[key]:g}" for key in scalar[:3]) for sheet in sheets]
    if len(set(names)) == len(names):
        return names
    return [f"{k}: {name or run.loop.name}" for k, (name, run) in enumerate(zip(names, runs, strict=True), 1)]


def _chosen(run: Run, signals: str | Sequence[str] | None) -> list[Panel]:
    """The panels of a run: of the signals asked for, or the usual ones, or all that there are."""
    if signals is None:
        panels = [p for p in (_way(run), _lines(run, "true_error"), _lines(run, "output")) if p[1]]
        return panels or [(name, [(name, "", {"color": BLUE})]) for name in run.signals if name != "time"]
    panels = [_lines(run, name) for name in ([signals] if isinstance(signals, str) else signals)]
    for name, lines in panels:
        if not lines:
            raise NameUnknown(f"{run.loop.name}: {name!r} was not recorded{nearest(name, list(run.signals))}")
    return panels


def _labelled(title: str, unit: str = "") -> str:
    text = title.replace("_", " ")
    return f"{text} ({shown_unit(unit)})" if unit else text


def _way(run: Run) -> Panel:
    """Command over actual, axis by axis."""
    lines: list[Line] = []
    trees = (signal_tree(run.loop.signals[k]) for k in ("command", "actual"))
    for pair, colour in zip(pairs(*trees), AXIS_COLOURS, strict=False):
        for root, key, style in (
            ("actual", pair.other, {"color": colour}),
            ("command", pair.command, {"color": BLACK, "linestyle": ":"}),
        ):
            name = under(root, key)
            if name in run.signals:
                lines.append((name, name, style))
    return "position" if any("position" in name for name, _, _ in lines) else "command, actual", lines


def _lines(run: Run, root: str) -> Panel:
    names = [n for n in run.signals if n == root or n.startswith(f"{root}.")]
    several = len(names) > 1
    return root, [(n, n if several else "", {"color": c}) for n, c in zip(names, AXIS_COLOURS, strict=False)]
