"""The picture of which runs fail: the share of failed runs in each tenth of a parameter, with its interval."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from leadscrew import escape
from leadscrew.report.style import BLACK, VERMILION
from leadscrew.tune.failures import questions, shares
from leadscrew.tune.montecarlo_figures import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from leadscrew.tune.montecarlo import MonteCarlo

ACROSS = 3


def failure_pictures(found: MonteCarlo) -> Iterator[tuple[str, str, Callable[[], Figure]]]:
    """Name, caption and drawing of one figure a tolerance that some runs miss and others keep."""
    if not len(found.space):
        return
    for name, failed in questions(found).items():
        caption = f"{name}: the part of runs that {'diverge' if name == 'diverged' else 'miss it'}, by parameter."
        keys = [row.key for row in found.failures if row.tolerance == name]
        yield file_name(name), caption, partial(failure_figure, found, failed, keys)


def file_name(tolerance: str) -> str:
    """The name of a tolerance's picture."""
    return escape.file_name("fails_" + tolerance.replace("<=", "_at_most_").replace(">=", "_at_least_"))


def failure_figure(found: MonteCarlo, failed: np.ndarray, keys: list[str]) -> Figure:
    """One panel a parameter, the one that separates best first."""
    across = min(ACROSS, len(keys))
    down = -(-len(keys) // across)
    figure = Figure(figsize=(1.0 + 3.0 * across, 0.5 + 2.5 * down), layout="constrained")
    axes = figure.subplots(down, across, sharey=True, squeeze=False).ravel()
    for ax, key in zip(axes, keys, strict=False):
        _panel(ax, found.samples.columns[key], failed, key)
    for ax in axes[len(keys) :]:
        ax.set_visible(False)
    for ax in axes[::across]:
        ax.set_ylabel("failed runs (%)")
    axes[0].set_ylim(bottom=0.0)
    return figure


def _panel(ax: Axes, values: np.ndarray, failed: np.ndarray, key: str) -> None:
    parts = shares(values, failed)
    start, end, share, low, high = (
        np.array([getattr(p, name) for p in parts]) for name in ("start", "end", "value", "low", "high")
    )
    if (start == end).all():
        wide = 0.5 * float(np.diff(start).min()) if len(start) > 1 else 1.0
        start, end = start - 0.5 * wide, end + 0.5 * wide
    ax.bar(start, 100.0 * share, end - start, align="edge", color=VERMILION, alpha=0.6, edgecolor="white")
    ax.vlines(0.5 * (start + end), 100.0 * low, 100.0 * high, color=BLACK, linewidth=0.9)
    ax.axhline(100.0 * failed.mean(), color=BLACK, linestyle=":", linewidth=0.9)
    ax.set_xlabel(key, fontsize="small")
    ax.ticklabel_format(axis="x", scilimits=(-3, 4))
    plain(ax)
