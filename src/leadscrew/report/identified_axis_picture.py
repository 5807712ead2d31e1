"""Pictures of an identified axis: measured against simulated, what is left of the force, friction curve, intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.report.identified_axis_friction import band, medians, resistance, shown_by_log
from leadscrew.report.identified_axis_words import closed_loop, display, force_unit, merged, num, scaled, state_of
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadscrew.identify.axis.result import AxisFit, Judged

MOST_POINTS = 5000
"""Samples of a stretch that a picture shows; of more, every n-th."""
LAGS = 400
POSITION = "Measured and simulated position, and what is between them"
RESIDUAL = (
    "What inverse dynamics leaves of the force, and its autocorrelation; within the window of its filter neighbours "
    "are alike by that alone"
)
FRICTION = "Drive's force minus inertia against speed, and the friction of the model"
INTERVALS = "Half of the 95 % interval of each parameter, in percent of its value"


def pictures(fit: AxisFit) -> dict[str, tuple[str, Figure]]:
    """Caption and figure by name, as far as the fit has what they show."""
    found = {
        "position": (POSITION, position_figure(fit)), "residual": (RESIDUAL, residual_figure(fit)),
        "friction": (FRICTION, friction_figure(fit)), "parameters": (INTERVALS, interval_figure(fit)),
    }  # fmt: skip
    return {name: (caption, figure) for name, (caption, figure) in found.items() if figure is not None}


def unseen(fit: AxisFit) -> Judged | None:
    """The stretch to show: the hold-out, or what there is."""
    return fit.judgement("hold-out") or (fit.judged[0] if fit.judged else None)


def position_figure(fit: AxisFit) -> Figure | None:
    """Measured and simulated position with the error below: the hold-out, and the closed loop where there is one."""
    from matplotlib.figure import Figure

    first = unseen(fit)
    if first is None:
        return None
    shown = [j for j in (first, closed_loop(fit)) if j is not None]
    figure = Figure(figsize=(5.4 * len(shown) + 1.6, 4.6), layout="constrained")
    axes = figure.subplots(2, len(shown), squeeze=False, sharex="col", height_ratios=(3, 2))
    for (above, below), j in zip(axes.T, shown, strict=True):
        every = slice(None, None, max(1, len(j.time) // MOST_POINTS))
        factor, unit = display(float(np.abs(j.measured).max()), fit.position_unit)
        above.plot(j.time[every], factor * j.measured[every], color=BLACK, linewidth=2.0, label="measured")
        above.plot(j.time[every], factor * j.simulated[every], color=ORANGE, linestyle="--", label="simulated")
        above.set(title=f"{j.what}: {scaled(j.rms, fit.position_unit)} rms", ylabel=f"position ({unit})")
        left = j.measured - j.simulated
        factor, unit = display(float(np.abs(left).max()), fit.position_unit)
        below.plot(j.time[every], factor * left[every], color=BLUE, linewidth=0.8)
        below.set(xlabel="time (s)", ylabel=f"error ({unit})")
        below.axhline(0.0, color=BLACK, linewidth=0.6)
    _tidy(*axes.ravel())
    figure.align_ylabels(axes[:, 0])
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure


def residual_figure(fit: AxisFit) -> Figure | None:
    """Residual force against time, and its autocorrelation with the bounds of white noise."""
    from matplotlib.figure import Figure

    j = unseen(fit)
    if j is None or np.count_nonzero(np.isfinite(j.force_left)) < 8:
        return None
    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    every = slice(None, None, max(1, len(j.time) // MOST_POINTS))
    left.plot(j.time[every], j.force_left[every], color=BLUE, linewidth=0.6)
    left.axhline(0.0, color=BLACK, linewidth=0.6)
    unit = force_unit(fit)
    left.set(xlabel="time (s)", ylabel=f"residual force ({unit})")
    left.set_title(f"{j.what}: {num(j.rms_force, 3)} {unit} rms, {num(j.force_percent, 3)} % of the force")
    lags = autocorrelation(j.force_left)
    bound = 1.96 / np.sqrt(np.count_nonzero(np.isfinite(j.force_left)))
    times = np.arange(len(lags)) * (j.time[-1] - j.time[0]) / (len(j.time) - 1)
    right.axhspan(-bound, bound, color="0.85", label="95 % of white noise")
    right.plot(times, lags, color=VERMILION, linewidth=1.2, label="of the residual")
    right.axhline(0.0, color=BLACK, linewidth=0.6)
    right.set(xlabel="lag (s)", ylabel="autocorrelation", ylim=(min(-0.25, float(lags.min())), 1.03))
    right.legend(frameon=False, fontsize="small")
    _tidy(left, right)
    return figure


def autocorrelation(values: np.ndarray, lags: int = LAGS) -> np.ndarray:
    """Autocorrelation from lag 0 on, 1 there, up to a quarter of the samples; NaN marks samples that are left out."""
    from scipy.signal import correlate

    known = np.isfinite(values)
    x = np.where(known, values - np.mean(values[known]), 0.0)
    kept = slice(len(x) - 1, len(x) + max(2, min(lags, len(x) // 4)))
    sums, pairs = (correlate(v, v, mode="full", method="fft")[kept] for v in (x, known.astype(float)))
    found = sums / np.maximum(np.rint(pairs), 1.0)
    return np.asarray(found / found[0] if found[0] > 0.0 else np.zeros_like(found))


def friction_figure(fit: AxisFit) -> Figure | None:
    """Force minus inertia against speed: samples, their medians, and the model with its band."""
    from matplotlib.figure import Figure

    j = unseen(fit)
    if j is None or np.count_nonzero(np.isfinite(j.force_left)) < 8:
        return None
    figure = Figure(figsize=(7.6, 4.4), layout="constrained")
    ax: Any = figure.subplots()
    factor, unit = display(float(np.abs(j.speed).max()), f"{fit.position_unit}/s")
    kept = np.isfinite(j.force_left)
    every = slice(None, None, max(1, int(kept.sum()) // MOST_POINTS))
    speed, forces = j.speed[kept], shown_by_log(fit, j)[kept]
    ax.plot(factor * speed[every], forces[every], ".", color="0.6", markersize=1.5, rasterized=True)
    ax.plot([], [], "s", color="0.6", markersize=4, label=f"samples, {j.what}")
    middle, low, median, high = medians(speed, forces)
    ax.errorbar(factor * middle, median, [median - low, high - median], fmt="o", markersize=4, color=BLACK,
                linewidth=0.8, label="their median and quartiles")  # fmt: skip
    for side in (-1.0, 1.0):
        end = float((side * speed).max())
        if end <= 0.0:
            continue
        speeds = side * np.linspace(end / 1000.0, end, 300)
        shown = resistance(fit.values, speeds)
        first = side < 0.0 or float(speed.min()) >= 0.0
        ax.plot(factor * speeds, shown, color=BLUE, linewidth=1.8, label="model" if first else None)
        reach = band(fit, speeds)
        if reach is not None:
            ax.fill_between(factor * speeds, shown - reach, shown + reach, color=ORANGE, alpha=0.5, linewidth=0.0,
                            label="95 % interval of the model" if first else None)  # fmt: skip
    spread = np.percentile(forces, (0.5, 99.5))
    ax.set(xlabel=f"speed ({unit})", ylabel=f"force minus inertia ({force_unit(fit)})",
           ylim=(spread[0] - 0.15 * np.ptp(spread), spread[1] + 0.15 * np.ptp(spread)))  # fmt: skip
    _tidy(ax)
    ax.margins(x=0.02)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    return figure


def interval_figure(fit: AxisFit) -> Figure | None:
    """Half of each 95 % interval in percent of the value; filled where the log tells the parameter."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import StrMethodFormatter

    rows = merged(fit)
    figure = Figure(figsize=(7.6, 1.2 + 0.34 * len(rows)), layout="constrained")
    ax: Any = figure.subplots()
    drawn = {k: p.percent for k, p in rows.items() if p.how == "fitted" and 0.0 < p.percent < np.inf}
    low, high = (min(drawn.values()), max(drawn.values())) if drawn else (0.1, 100.0)
    low, high = low / 2.0, max(high * 2.0, low * 100.0)
    for at, (key, p) in enumerate(rows.items()):
        if key in drawn:
            ax.plot([low, drawn[key]], [at, at], color="0.75", linewidth=1.0)
            ax.plot(drawn[key], at, "o" if p.told else "D", color=BLUE if p.told else VERMILION, markersize=7,
                    fillstyle="full" if p.told else "none")  # fmt: skip
        else:
            ax.text(low * 1.1, at, f"{state_of(p)}: no interval", va="center", fontsize="small", color="0.35")
    ax.set(xscale="log", xlim=(low, high), ylim=(len(rows) - 0.4, -0.6),
           xlabel="half of the 95 % interval, % of the value")  # fmt: skip
    ax.set_yticks(range(len(rows)), list(rows))
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.axvline(100.0, color=GREEN, linewidth=1.0, linestyle=":")
    ax.plot([], [], "o", color=BLUE, label="told by the log")
    ax.plot([], [], "D", color=VERMILION, fillstyle="none", label="not told")
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    ax.grid(axis="x", color="0.92", linewidth=0.6)
    ax.set_axisbelow(True)
    return figure


def _tidy(*axes: Any) -> None:
    for ax in axes:
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.margins(x=0)
