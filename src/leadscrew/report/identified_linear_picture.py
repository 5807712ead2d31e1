"""Pictures of a linear model from a log: hold-out, residual, Bode with band beside the log's own response, orders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew import escape
from leadscrew.identify.linear.result import LinearFit
from leadscrew.identify.linear.uncertainty import NORMAL
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_POINTS = 6000
"""Of a drawn line."""


def pictures(fit: LinearFit) -> dict[str, tuple[Figure, str]]:
    """Figures and captions by name."""
    last = fit.stretches[-1]
    found = {
        "simulated": (simulated(fit), f"Measured and simulated, {last.what}: the model is given the input alone"),
        "bode": (bode(fit), "Response from sample to sample, hold included: model with its 95 % band, and the log's "
                            "own estimate without a model; grey where the training does not excite"),
        "residual": (residual(fit), "Autocorrelation of what the training leaves, with the 95 % bounds of white noise"),
    }  # fmt: skip
    if len(fit.candidates) > 1:
        found["orders"] = (orders(fit), "Errors of simulation of all models that were tried, by number of coefficients")
    return found


def simulated(fit: LinearFit) -> Figure:
    """Measured against simulated, and the difference, on the hold-out."""
    figure, (way, error) = _panels((7.5, 5.0), (3, 2))
    s = fit.stretches[-1]
    part = slice(None, None, max(1, len(s.time) // MOST_POINTS))
    way.plot(s.time[part], s.measured[part], color=BLACK, linewidth=1.0, label="measured")
    way.plot(s.time[part], s.simulated[part], color=BLUE, linewidth=1.0, linestyle="--", label="simulated")
    error.plot(s.time[part], (s.measured - s.simulated)[part], color=VERMILION, linewidth=0.8)
    way.set(
        ylabel=escape.figure(f"{fit.output_name} ({fit.output_unit})"),
        title=escape.figure(f"{s.what}: rms {s.rms:.3g} {fit.output_unit}"),
    )
    error.set(xlabel="time (s)", ylabel=escape.figure(f"difference ({fit.output_unit})"))
    way.legend(frameon=False, fontsize="small")
    figure.align_ylabels()
    return figure


def bode(fit: LinearFit) -> Figure:
    """Gain, phase and coherence: model with band, measured points with theirs."""
    figure, (gain, phase, coherence) = _panels((7.5, 7.0), (3, 3, 1.5))
    b = fit.bode
    size, angle = np.abs(b.response), np.degrees(np.unwrap(np.angle(b.response)))
    wide = np.minimum(b.gain_share, 0.99)
    gain.fill_between(b.frequency_hz, size * (1.0 - wide), size * (1.0 + wide), color=BLUE, alpha=0.25, linewidth=0)
    gain.plot(b.frequency_hz, size, color=BLUE, linewidth=1.1, label="model, 95 %")
    reach = np.degrees(np.minimum(b.phase_half_width, np.pi))
    phase.fill_between(b.frequency_hz, angle - reach, angle + reach, color=BLUE, alpha=0.25, linewidth=0)
    phase.plot(b.frequency_hz, angle, color=BLUE, linewidth=1.1)
    m = fit.measured
    if m is not None:
        dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 3, "color": ORANGE}
        low, high = m.gain_confidence()
        gain.vlines(m.frequencies, np.maximum(low, 1e-3 * m.gain), high, color=ORANGE, linewidth=0.6, alpha=0.6)
        gain.plot(m.frequencies, m.gain, label=f"log, {m.method}", **dots)
        model = np.interp(m.frequencies, b.frequency_hz, np.radians(angle))
        near = np.degrees(model + np.angle(m.response * np.exp(-1j * model)))
        phase.plot(m.frequencies, near, **dots)
        coherence.plot(m.frequencies, m.coherence, color=GREEN, linewidth=0.9)
    shown = size[(b.frequency_hz >= fit.excited_hz[0]) & (b.frequency_hz <= fit.excited_hz[1])] if any(
        fit.excited_hz) else size  # fmt: skip
    shown = shown if len(shown) else size
    gain.set(yscale="log", ylabel=escape.figure(f"gain ({fit.output_unit}/{fit.input_unit})"))
    gain.set_ylim(0.03 * float(shown.min()), 5.0 * float(max(shown.max(), 1e-300)))
    phase.set(ylabel="phase (deg)", ylim=(float(angle.min()) - 60.0, float(angle.max()) + 60.0))
    coherence.set(ylabel="coherence", xlabel="frequency (Hz)", xscale="log", ylim=(0.0, 1.05))
    for ax in (gain, phase, coherence):
        ax.axvspan(b.frequency_hz[0], max(fit.excited_hz[0], b.frequency_hz[0]), color="0.9", zorder=-2)
        ax.axvspan(max(fit.excited_hz[1], b.frequency_hz[0]), b.frequency_hz[-1], color="0.9", zorder=-2)
    gain.legend(frameon=False, fontsize="small")
    figure.align_ylabels()
    return figure


def residual(fit: LinearFit) -> Figure:
    """Autocorrelation of the training residual."""
    figure, (ax,) = _panels((7.5, 2.8), (1,))
    lags = np.arange(1, len(fit.autocorrelation) + 1)
    bound = NORMAL / np.sqrt(len(fit.stretches[0].time))
    ax.axhspan(-bound, bound, color=BLUE, alpha=0.15, linewidth=0)
    ax.vlines(lags, 0.0, fit.autocorrelation, color=BLUE, linewidth=1.5)
    ax.plot(lags, fit.autocorrelation, color=BLUE, linestyle="none", marker="o", markersize=3)
    ax.axhline(0.0, color=BLACK, linewidth=0.6)
    ax.set(xlabel="lag (samples)", ylabel="autocorrelation", xlim=(0.0, len(lags) + 1.0))
    return figure


def orders(fit: LinearFit) -> Figure:
    """Errors of all candidates over their number of coefficients."""
    figure, (ax,) = _panels((7.5, 3.4), (1,))
    held = np.isfinite(fit.candidates[0].holdout_rms)
    for q, mark in ((0, "o"), (1, "s"), (2, "D")):
        rows = [c for c in fit.candidates if c.structure.integrators == q]
        if not rows:
            continue
        count = [c.structure.free + c.structure.zeros + 1 for c in rows]
        name = f"{q} pole{'s' * (q != 1)} at 0" if q else "no pole at 0"
        style: dict[str, Any] = {"linestyle": "none", "marker": mark, "markersize": 6}
        if held:
            ax.plot(count, [c.holdout_rms for c in rows], color=BLUE, label=f"{name}, hold-out", **style)
        ax.plot(count, [c.train_rms for c in rows], color=ORANGE, fillstyle="none", label=f"{name}, training", **style)
    best = next(c for c in fit.candidates if c.against == "chosen")
    at = best.structure.free + best.structure.zeros + 1
    error = best.holdout_rms if held else best.train_rms
    ax.annotate(f"chosen: {best.structure.text}", (at, error), (0, -26), textcoords="offset points", ha="center",
                arrowprops={"arrowstyle": "->", "linewidth": 0.8}, fontsize="small")  # fmt: skip
    ax.set(
        yscale="log",
        xlabel="coefficients of numerator and denominator",
        ylabel=escape.figure(f"rms error ({fit.output_unit})"),
    )
    ax.margins(x=0.08, y=0.3)
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.legend(frameon=False, fontsize="small", loc="upper right")
    return figure


def _panels(size: tuple[float, float], heights: tuple[float, ...]) -> tuple[Figure, list[Any]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for ax in axes:
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.margins(x=0)
    return figure, list(axes)
