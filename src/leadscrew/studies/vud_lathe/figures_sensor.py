"""Figures of the grating ruler: from the signals to the count, and what Heydemann's correction does."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.sensors.grating import counting
from leadscrew.sensors.grating.heydemann import fit_ellipse
from leadscrew.sensors.grating.moire import GRATING
from leadscrew.sensors.grating.quadrature import Floats, first_order_error, interpolation_error, quadrature
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.claims_sensor import SEED, TRIAL

NOISE = 0.005
"""Of each signal, in the picture of the ellipse."""


def sensor_pictures() -> list[Picture]:
    """The figures of the sensor; they need no run."""
    return [
        Picture("grating_count", "Grating ruler on a travel with a reversal: the slide, the two signals, the eight "
                "comparators, the count.", count_chain),
        Picture("grating_heydemann", "Signals with errors before and after Heydemann's correction, and the error of "
                "position over a pitch.", correction),
    ]  # fmt: skip


def travel_mm() -> tuple[Floats, Floats]:
    """Time in ms and position in mm: 18 um forward and back by 12 um, smoothly, with 10 us between samples."""
    time_ms = np.linspace(0.0, 10.0, 1001)
    share = np.clip(time_ms / 6.0, 0.0, 1.0)
    back = np.clip((time_ms - 6.0) / 4.0, 0.0, 1.0)
    return time_ms, 0.018 * share**2 * (3.0 - 2.0 * share) - 0.012 * back**2 * (3.0 - 2.0 * back)


def count_chain() -> Figure:
    """Position, signals, comparator bits and count over time, the reversal marked."""
    time_ms, x = travel_mm()
    u, v = quadrature(x)
    code = counting.comparators(u, v)
    count = counting.counts(counting.sectors(code))
    figure = Figure(figsize=(7.0, 6.4), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.5, 1.4))
    panels[0].plot(time_ms, u, color=BLUE, label="u")
    panels[0].plot(time_ms, v, color=ORANGE, linestyle="--", label="v")
    panels[0].set(ylabel="signal (1)", title=f"One count is {1000.0 * GRATING.resolution_mm:g} µm")
    for i, bit in enumerate(code.T):
        panels[1].step(time_ms, i + 0.7 * bit, where="post", color=BLACK, linewidth=0.9)
    panels[1].set(ylabel="comparator (number)", yticks=np.arange(8) + 0.35)
    panels[1].set_yticklabels([f"$w_{i}$" for i in range(8)])
    panels[2].step(time_ms, 1000.0 * GRATING.resolution_mm * count, where="post", color=GREEN, label="count")
    panels[2].plot(time_ms, 1000.0 * x, color=VERMILION, linestyle=":", label="slide")
    panels[2].set(ylabel="position (µm)", xlabel="time (ms)")
    for axes in panels:
        axes.axvline(6.0, color="0.7", linewidth=0.8, zorder=0)
    panels[2].annotate("reversal", (6.0, 1.0), textcoords="offset points", xytext=(4, 0), fontsize="small", color="0.4")
    for axes in (panels[0], panels[2]):
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def correction() -> Figure:
    """The ellipse and its circle, and the error over a pitch before and after, with the first-order formula."""
    x = GRATING.pitch_mm * np.arange(1000) / 1000
    u, v = quadrature(x, errors=TRIAL, noise=NOISE, seed=SEED)
    sine, cosine = fit_ellipse(u, v).corrected(u, v)
    figure = Figure(figsize=(8.6, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
    raw = {"color": VERMILION, "linestyle": "none", "marker": ".", "markersize": 2.0}
    new = {"color": BLUE, "linestyle": "none", "marker": ".", "markersize": 2.0}
    left.plot(v, u, **raw)
    left.plot(cosine, sine, **new)
    left.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
    left.axvline(0.0, color="0.8", linewidth=0.8, zorder=0)
    left.set(xlabel="v (amplitudes of u)", ylabel="u (amplitudes of u)", aspect="equal")
    before, after = (1000.0 * interpolation_error(x, *pair) for pair in ((u, v), (sine, cosine)))
    right.plot(1000.0 * x, before, **raw, label=f"before: {before.std():.3f} µm rms about the mean")
    right.plot(1000.0 * x, after, **new, label=f"after: {after.std():.4f} µm")
    right.plot(
        1000.0 * x, 1000.0 * first_order_error(x, errors=TRIAL), color=BLACK, linewidth=1.0, label="first-order formula"
    )
    right.set(xlabel="position in the pitch (µm)", ylabel="error of position (µm)")
    figure.legend(loc="outside lower center", ncols=3, frameon=False, markerscale=4.0)
    return figure
