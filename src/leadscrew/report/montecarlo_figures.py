"""Figures of a Monte Carlo: distributions with their tolerances, what matters, wear over a life."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.figures.figure import Figure
from leadscrew.figures.runs import AXIS_COLOURS
from leadscrew.figures.style import BLACK, BLUE, VERMILION
from leadscrew.tune.montecarlo import Tolerance, questions, shares
from leadscrew.tune.statistics import PERCENTILES
from leadscrew.util import escape

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from leadscrew.tune.montecarlo import MonteCarlo
    from leadscrew.tune.parameter_drift import Envelope


BINS = 60
POINTS = 800
"""Of a cumulative curve."""


class Picture(NamedTuple):
    """One figure of the report."""

    name: str
    caption: str
    draw: Callable[[], Figure]


def labelled(metric: str, unit: str) -> str:
    """A metric with its unit, for an axis."""
    return f"{metric.replace('_', ' ')} ({unit})" if unit else metric.replace("_", " ")


def plain(ax: Axes) -> None:
    """The look of all panels."""
    ax.grid(color="0.92", linewidth=0.6)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def distribution(found: MonteCarlo, metric: str, unit: str) -> Figure:
    """Histogram and cumulative distribution of a metric, one colour a scenario, with its tolerances."""
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    samples = found.samples
    known = {s: v[metric][~np.isnan(v[metric])] for s, v in samples.metrics.items()}
    wanted = [t for t in found.tolerances if t.metric == metric]
    low, high = _window(np.concatenate(list(known.values())), wanted)
    several = len(known) > 1
    for (scenario, values), colour in zip(known.items(), _colours(len(known)), strict=True):
        if not len(values):
            continue
        counts, edges = np.histogram(values, edges_of(values, low, high))
        label = scenario if several else None
        left.stairs(counts / len(found), edges, fill=not several, color=colour, alpha=1.0 if several else 0.55)
        n = len(values)
        at = np.unique(np.linspace(0, n - 1, min(n, POINTS)).astype(int))
        right.step(np.sort(values)[at], (at + 1) / len(found), where="post", color=colour, label=label, linewidth=1.3)
        if not several:
            marks = np.percentile(values, (5, 50, 95))
            for ax in (left, right):
                for x, style in zip(marks, (":", "-", ":"), strict=True):
                    ax.axvline(x, color=BLUE, linestyle=style, linewidth=0.9)
            right.plot([], [], color=BLUE, linewidth=0.9, label=f"median {marks[1]:.4g}")
            right.plot(
                [], [], color=BLUE, linestyle=":", linewidth=0.9, label=f"5, 95 %: {marks[0]:.4g}, {marks[2]:.4g}"
            )
    for t in wanted:
        held = found.yields[str(t)]
        sign = "≤" if t.sense == "<=" else "≥"
        where = f" in {t.scenario}" if t.scenario else ""
        label = f"tolerance {sign} {t.bound:g}{where}: {_percent(held.value)}"
        inside = low <= t.bound <= high
        for ax in (left, right):
            if inside:
                ax.axvline(t.bound, color=BLACK, linestyle="--", linewidth=1.2)
        right.plot([], [], color=BLACK, linestyle="--", label=label if inside else f"{label}, off the picture")
    for ax in (left, right):
        ax.set_xlim(low, high)
        ax.set_xlabel(labelled(metric, unit))
        ax.ticklabel_format(axis="x", scilimits=(-3, 4))
        plain(ax)
    left.set_ylabel("part of the runs in a bin")
    right.set_ylabel("part of the runs at or below")
    right.set_ylim(0.0, 1.03)
    _legend(figure, right)
    return figure


def edges_of(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Bins; of values on a grid (times in whole periods) each takes as many of its points as the others."""
    apart = np.diff(np.unique(values))
    step = float(apart.min()) if len(apart) else 0.0
    wide = (high - low) / BINS
    if step <= 1e-3 * wide or len(apart) > 0.5 * len(values):
        return np.linspace(low, high, BINS + 1)
    wide = max(1.0, np.ceil(wide / step - 1e-6)) * step
    first = float(values.min()) - 0.5 * step
    start = first - np.ceil(max(0.0, first - low) / wide) * wide
    return np.asarray(np.arange(start, high + wide, wide))


def _legend(figure: Figure, ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper center", ncols=4, frameon=False, fontsize="small")


def _percent(part: float) -> str:
    return f"{100.0 * part:.4g} %"


def _colours(count: int) -> list[str]:
    return [AXIS_COLOURS[i % len(AXIS_COLOURS)] for i in range(count)]


def _window(values: np.ndarray, wanted: Sequence[Tolerance]) -> tuple[float, float]:
    """What of the axis is shown: nearly all runs, and tolerances that are not far away."""
    low, high = np.percentile(values, (0.1, 99.9))
    span = max(high - low, 1e-3 * abs(high), 1e-12)
    for t in wanted:
        if low - span < t.bound < high + span:
            low, high = min(low, t.bound), max(high, t.bound)
    return float(low - 0.04 * span), float(high + 0.04 * span)


Bar = tuple[float, float, float, float]
"""Value, lower and upper end of its interval, second value."""


def bars(
    rows: Mapping[str, Mapping[str, Mapping[str, Bar]]], title: str, second: str, span: tuple[float, float]
) -> Figure:
    """Horizontal bars, one panel a metric, one bar a parameter and scenario: ``rows[metric][scenario][key]``.

    The parameter that matters most stands on top.
    """
    first = next(iter(rows.values()))
    scenarios = list(first)
    weight = {
        k: max(abs(r[s][k][0]) for r in rows.values() for s in scenarios if not np.isnan(r[s][k][0]))
        if any(not np.isnan(r[s][k][0]) for r in rows.values() for s in scenarios)
        else 0.0
        for k in first[scenarios[0]]
    }
    keys = sorted(weight, key=lambda k: weight[k])
    across = min(3, len(rows))
    down = -(-len(rows) // across)
    tall = 0.22 * len(keys) * (1 + len(scenarios)) / 2 + 0.35
    size = (2.6 + 2.4 * across, 0.9 + down * (0.75 + tall))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(down, across, sharey=True, sharex=True, squeeze=False).ravel()
    thick = 0.8 / len(scenarios)
    for ax, (metric, by_scenario) in zip(axes, rows.items(), strict=False):
        for i, (scenario, colour) in enumerate(zip(scenarios, _colours(len(scenarios)), strict=True)):
            at = np.arange(len(keys)) + (0.5 * (len(scenarios) - 1) - i) * thick
            value, low, high, other = np.array([by_scenario[scenario][k] for k in keys]).T
            label = scenario if len(scenarios) > 1 else title
            ax.barh(at, value, 0.9 * thick, color=colour, alpha=0.6, label=label)
            ax.hlines(at, low, high, color=BLACK, linewidth=0.9)
            ax.plot(other, at, "D", color=BLACK, fillstyle="none", markersize=4, label=second if not i else None)
        ax.set_title(metric.replace("_", " "), fontsize="medium")
        ax.set_yticks(np.arange(len(keys)), keys, fontsize="small")
        ax.set_xlim(*span)
        ax.margins(y=0.04)
        ax.axvline(0.0, color=BLACK, linewidth=0.7)
        plain(ax)
    for ax in axes[len(rows) :]:
        ax.set_visible(False)
    for i in range(max(0, len(rows) - across), len(rows)):
        axes[i].tick_params(labelbottom=True)
        axes[i].set_xlabel(title)
    _legend(figure, axes[0])
    return figure


def life_figure(envelope: Envelope, metric: str, unit: str, wanted: Sequence[Tolerance], joined: str) -> Figure:
    """Percentiles of a metric over a life: the median, and the bands that hold half and nine tenths of the runs."""
    scenarios = list(dict.fromkeys(s.scenario for s in envelope.spreads[0]))
    figure = Figure(figsize=(7.0, 3.4), layout="constrained")
    ax = figure.subplots()
    at = {p: i for i, p in enumerate(PERCENTILES)}
    for scenario, colour in zip(scenarios, _colours(len(scenarios)), strict=True):
        band = envelope.band(scenario, metric)
        label = f"{scenario}, " if len(scenarios) > 1 else ""
        for (a, b), alpha, what in (((5, 95), 0.18, "5 to 95 %"), ((25, 75), 0.35, "25 to 75 %")):
            ax.fill_between(
                envelope.life, band[:, at[a]], band[:, at[b]], color=colour, alpha=alpha, linewidth=0,
                label=what if not label else None,
            )  # fmt: skip
        ax.plot(envelope.life, band[:, at[50]], color=colour, linewidth=1.6, label=f"{label}median")
    for t in wanted:
        ax.axhline(t.bound, color=BLACK, linestyle="--", linewidth=1.2, label=f"tolerance {_sign(t)} {t.bound:g}")
    ax.set_ylabel(labelled(metric, unit))
    _life_axis(figure, ax, joined)
    return figure


def _sign(t: Tolerance) -> str:
    return f"{'≤' if t.sense == '<=' else '≥'}"


def yield_figure(envelope: Envelope, level: float, joined: str) -> Figure:
    """The joint yield over a life with its interval, and where it falls below a level."""
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    ax = figure.subplots()
    value, low, high = (100.0 * np.array([getattr(y, n) for y in envelope.yields]) for n in ("value", "low", "high"))
    ax.fill_between(envelope.life, low, high, color=BLUE, alpha=0.25, linewidth=0, label="95 % interval")
    ax.plot(envelope.life, value, "o-", color=BLUE, markersize=3, linewidth=1.4, label="yield, all tolerances")
    ax.axhline(100.0 * level, color=VERMILION, linestyle="--", linewidth=1.2, label=f"level {_percent(level)}")
    end = envelope.crossing(level)
    if not np.isnan(end.life):
        ax.axvline(end.life, color=BLACK, linewidth=0.9, label=f"below it from {end.life:.3g} on")
    ax.set_ylim(min(100.0 * level, float(value.min())) - 5.0, 102.0)
    ax.set_ylabel("yield (%)")
    _life_axis(figure, ax, joined)
    return figure


def _life_axis(figure: Figure, ax: Axes, joined: str) -> None:
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel(f"part of the life; {joined}")
    plain(ax)
    _legend(figure, ax)


def saved(figure: Figure, path: Any) -> None:
    """As PNG, the same bytes every time."""
    figure.savefig(path, format="png", dpi=150, metadata={"Software": None})


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
