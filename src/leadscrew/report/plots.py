"""The picture of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from leadscrew import escape
from leadscrew.kernel.frame import pairs, signal_tree, under
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.report.tables import signal_unit

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run

AXIS_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
"""One for each axis of a machine."""


def run_figure(run: Run) -> Figure:
    """Command and true output, true error, controller output against time, as far as they were recorded.

    A loop of several axes gives one line an axis. Signals of the user's own choice get a panel each.
    """
    panels = [p for p in (_way(run), _lines(run, "true_error"), _lines(run, "output")) if p[1]]
    if not panels:
        panels = [(name, [(name, "", {"color": BLUE})]) for name in run.signals if name != "time"]
    figure = Figure(figsize=(7.0, 1.2 + 1.9 * max(1, len(panels))), layout="constrained")
    axes = figure.subplots(max(1, len(panels)), 1, sharex=True, squeeze=False)[:, 0]
    for ax, (title, lines) in zip(axes, panels, strict=False):
        for name, label, style in lines:
            ax.plot(run.time, run.signals[name], label=label or None, linewidth=1.1, **style)
        ax.set_ylabel(_labelled(title, signal_unit(run.loop, lines[0][0])))
        if any(label for _, label, _ in lines):
            ax.legend(frameon=False, fontsize="small")
        ax.grid(color="0.92", linewidth=0.6)
        ax.margins(x=0)
    axes[-1].set_xlabel("time (s)")
    axes[0].set_title(escape.figure(run.loop.name) + (f"\n{run.diverged}" if run.diverged else ""), fontsize="medium")
    figure.align_ylabels(axes)
    return figure


Panel = tuple[str, list[tuple[str, str, dict[str, Any]]]]
"""Title, and for each line its signal, its label and its style."""


def _labelled(title: str, unit: str) -> str:
    return f"{title.replace('_', ' ')} ({unit})" if unit else title.replace("_", " ")


def _way(run: Run) -> Panel:
    """Command over actual, axis by axis."""
    lines: list[tuple[str, str, dict[str, Any]]] = []
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
