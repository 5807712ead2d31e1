"""Drawings of stability: Popov plot with its line, Nyquist curve with its circle, conditions over frequency, cycles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from leadscrew.figures.figure import Figure
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.util import escape

if TYPE_CHECKING:
    from collections.abc import Callable

    from leadscrew.analysis.stability.certificate import Certificate
    from leadscrew.analysis.stability.harmonic_balance import CyclePrediction
    from leadscrew.analysis.stability.linear import LinearLoop


def popov_plot(cert: Certificate) -> Figure:
    """``w Im G1`` over ``Re G1``, the line of the best multiplier, and the phase crossover."""
    figure = Figure(figsize=(6.0, 4.6), layout="constrained")
    axes: Any = figure.subplots()
    draw_popov(axes, cert, BLUE, VERMILION)
    axes.set_title(f"{escape.figure(cert.loop['name'])}: {cert.criterion}, {cert.grade}", fontsize="medium", loc="left")
    finish(axes)
    return figure


def draw_popov(axes: Axes, cert: Certificate, curve: str, line: str, label: str = "") -> None:
    """One Popov plot into axes: curve, line, the point that the line goes through, the crossing."""
    w = cert.data["loop"].frequencies
    g = cert.data["response"](w)
    k1, q, m = cert.data["k1"], cert.data["q_s"], cert.data["m"]
    x, y = g.real, w * g.imag
    name = "G" if k1 == 0.0 else "G/(1 + G)" if k1 == 1.0 else f"G/(1 + {k1:g} G)"
    left = min(float(x.min()), -m if m > 0.0 else 0.0)
    window = (1.25 * left - 0.02, max(-0.6 * left, 0.1))
    shown = (x > 2 * window[0]) & (x < 3 * window[1])
    axes.plot(np.where(shown, x, np.nan), np.where(shown, y, np.nan), color=curve, linewidth=1.1, label=label or name)
    if m > 0.0:
        ends = np.array(window)
        if abs(q) > 0.0:
            axes.plot(ends, (ends + m) / q, color=line, linestyle="--", label=f"line of q = {q:.4g} s")
        else:
            axes.axvline(-m, color=line, linestyle="--", label="line of q = 0")
        axes.plot([-m], [0.0], "s", color=line, label=f"-1/(k2 - k1) = {-m:.4g}")
    low, high = float(y[shown].min()), float(y[shown].max())
    axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
    axes.set_xlim(*window)
    crossed = [c for c in cert.data["loop"].phase_crossings if k1 * c.value > -1.0]
    if crossed:
        last = min(crossed, key=lambda c: c.value)
        at = last.value / (1.0 + k1 * last.value)
        axes.plot([at], [0.0], "o", color=BLACK, markerfacecolor="none", markersize=8,
                  label=f"phase crossover {at:.4g} at {last.w / (2 * math.pi):.4g} Hz")  # fmt: skip
    axes.set_xlabel(f"Re {name}")
    axes.set_ylabel(f"ω Im {name} (rad/s)")


def circle_plot(cert: Certificate) -> Figure:
    """The Nyquist curve of ``G`` and the circle (or the line) of the sector: the one asked for and the largest."""
    figure = Figure(figsize=(6.0, 4.8), layout="constrained")
    axes: Any = figure.subplots()
    loop, k1 = cert.data["loop"], cert.data["k1"]
    draw_nyquist(axes, loop)
    if cert.limit is not None:
        draw_sector(axes, k1, cert.limit, GREEN, f"largest sector [{k1:g}, {cert.limit_text}]")
    if cert.sector is not None and math.isfinite(cert.sector[1]):
        draw_sector(axes, k1, cert.sector[1], ORANGE, f"asked [{k1:g}, {cert.sector[1]:.4g}]")
    axes.set_title(f"{escape.figure(cert.loop['name'])}: {cert.criterion}, {cert.grade}", fontsize="medium", loc="left")
    left = -1.6 / k1 if k1 > 0.0 else -2.5
    window(axes, left)
    return figure


def nyquist_plot(cert: Certificate) -> Figure:
    """The Nyquist curve with the unit circle, the crossings, and the circle of the sensitivity's peak."""
    figure = Figure(figsize=(6.0, 4.8), layout="constrained")
    axes: Any = figure.subplots()
    gain, ms = cert.data["gain"], cert.data["ms"]
    draw_nyquist(axes, cert.data["loop"], gain)
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(turn), np.sin(turn), color="0.6", linewidth=0.8, linestyle=":", label="unit circle")
    axes.plot(-1.0 + np.cos(turn) / ms, np.sin(turn) / ms, color=VERMILION, linewidth=0.9, label=f"Ms = {ms:.3g}")
    axes.set_title(f"{escape.figure(cert.loop['name'])}: {cert.statement.split(':')[0]}", fontsize="medium", loc="left")
    window(axes, -2.0)
    return figure


def draw_nyquist(
    axes: Axes, loop: LinearLoop, gain: float = 1.0, colour: str = BLUE, label: str = "", marker: str = "o"
) -> None:
    """The curve of ``gain * G`` for positive frequencies, the point -1 and the phase crossover of most gain."""
    w = loop.frequencies
    g = gain * loop.response(w)
    near = np.abs(g) < 8.0
    said = label or ("G" if gain == 1.0 else f"{gain:.4g} G")
    axes.plot(np.where(near, g.real, np.nan), np.where(near, g.imag, np.nan), color=colour, linewidth=1.2, label=said)
    axes.plot([-1.0], [0.0], "+", color=BLACK, markersize=10)
    crossed = loop.phase_crossings
    if crossed:
        last = min(crossed, key=lambda c: c.value)
        axes.plot([gain * last.value], [0.0], marker, color=BLACK, markerfacecolor="none", markersize=7,
                  label=f"phase crossover {gain * last.value:.4g} at {last.w / (2 * math.pi):.4g} Hz")  # fmt: skip


def draw_sector(axes: Axes, k1: float, k2: float, colour: str, label: str) -> None:
    """The circle over the diameter from ``-1/k1`` to ``-1/k2``, or for ``k1 = 0`` the line through ``-1/k2``."""
    end = 0.0 if math.isinf(k2) else -1.0 / k2
    if k1 == 0.0:
        axes.axvline(end, color=colour, linestyle="--", label=label)
        return
    centre, radius = 0.5 * (end - 1.0 / k1), 0.5 * abs(end + 1.0 / k1)
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(centre + radius * np.cos(turn), radius * np.sin(turn), color=colour, linestyle="--", label=label)


def condition_plot(cert: Certificate) -> Figure:
    """What a criterion with a multiplier asks, over frequency: it has to stay above 0."""
    figure = Figure(figsize=(6.0, 3.8), layout="constrained")
    axes: Any = figure.subplots()
    loop, k1 = cert.data["loop"], cert.data["k1"]
    w = loop.frequencies
    r, s = cert.data["lines"](w)
    tight = r + cert.data["size"] * s
    for k2, colour, said in (
        (cert.limit, GREEN, "largest sector"),
        (None if cert.sector is None else cert.sector[1], ORANGE, "asked"),
    ):
        if k2 is not None and math.isfinite(k2):
            left = 1.0 / (k2 - k1) - tight
            axes.semilogx(w / (2 * np.pi), left, color=colour, label=f"{said} [{k1:g}, {k2:.4g}]")
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    at = cert.data["tightest_rad_s"]
    if math.isfinite(at):
        axes.axvline(at / (2 * np.pi), color="0.5", linestyle=":", label=f"tightest at {at / (2 * math.pi):.4g} Hz")
    axes.set_xlim(0.1, float(w[-1]) / (2 * np.pi))
    axes.set_xlabel("frequency (Hz)")
    axes.set_ylabel("left side of the condition (above 0)")
    axes.set_title(f"{escape.figure(cert.loop['name'])}: {cert.criterion}, {cert.grade}", fontsize="medium", loc="left")
    finish(axes, lines=False)
    return figure


def window(axes: Axes, left: float) -> None:
    """Equal scales around the point -1."""
    axes.set_aspect("equal")
    axes.set_xlim(left, 0.6)
    axes.set_ylim(-1.3, 0.9)
    axes.set_xlabel("Re G")
    axes.set_ylabel("Im G")
    finish(axes)


def finish(axes: Axes, lines: bool = True, columns: int = 2) -> None:
    """Grid, axes through 0, legend below the picture where it hides nothing."""
    axes.grid(color="0.92", linewidth=0.6)
    if lines:
        axes.axhline(0.0, color="0.5", linewidth=0.6)
        axes.axvline(0.0, color="0.5", linewidth=0.6)
    axes.legend(frameon=False, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=columns)


def slopes_plot(cert: Certificate) -> Figure:
    """The Nyquist curve and the disc that it must stay out of."""
    loop, (s1, s2) = cert.data["loop"], cert.sector or (0.0, 0.0)
    g = loop.response(loop.frequencies)
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    axes: Any = figure.subplots()
    axes.plot(g.real, g.imag, color=BLUE, label="G")
    if 0.0 < s1 < s2:
        centre, radius = -0.5 * (1.0 / s1 + 1.0 / s2), 0.5 * (1.0 / s1 - 1.0 / s2)
        disc = Circle((centre, 0.0), radius, color=VERMILION, alpha=0.4, label=f"disc of slopes {cert.sector_text}")
        axes.add_patch(disc)
    axes.plot([-1.0], [0.0], "k+", ms=10)
    near = max(2.0 / s1 if s1 > 0.0 else 2.0, 1.5)
    axes.set(xlim=(-near, 0.5 * near), ylim=(-near, near), xlabel="Re G", ylabel="Im G",
             title=f"{cert.loop['name']}: {cert.grade}")  # fmt: skip
    axes.set_aspect("equal")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    return figure


def cycles_figure(prediction: CyclePrediction) -> Figure:
    """Nyquist curve with the locus ``-1 / N(A)``, and ``N`` against amplitude with the gain of each crossing."""
    figure = Figure(figsize=(9.2, 4.2), layout="constrained")
    axes: Any = figure.subplots(1, 2)
    plane, curve = axes
    factor, unit = prediction.shown_in
    locus = prediction.locus
    if locus is not None:
        plane.plot(locus.response.real, locus.response.imag, color=BLUE, label="G")
        edge = -1.0 / locus.gain
        plane.plot(edge, np.zeros_like(edge), color=VERMILION, linewidth=4.0, alpha=0.5, label="-1/N(A)")
        curve.semilogx(2.0 * factor * locus.amplitude, locus.gain, color=BLUE, label="N(A)")
    for hertz, gain in prediction.crossings:
        if locus is not None and gain <= 2.0 * float(locus.gain.max()):
            curve.axhline(gain, color=BLACK, linestyle=":", label=f"-1/G at {hertz:.4g} Hz")
    for c in prediction.cycles:
        mark = {"marker": "o" if c.stable else "x", "color": GREEN if c.stable else VERMILION, "linestyle": ""}
        name = "stable cycle" if c.stable else "unstable cycle"
        plane.plot([-1.0 / c.gain], [0.0], **mark)
        curve.plot([2.0 * factor * c.amplitude], [c.gain], label=name, **mark)
    plane.set(xlabel="Re G", ylabel="Im G")
    plane.set_xlim(-1.2, 0.2)
    plane.set_ylim(-0.8, 0.6)
    plane.grid(alpha=0.3)
    plane.legend(frameon=False, loc="lower left")
    curve.set(xlabel=f"peak to peak of the fundamental ({unit})", ylabel="gain N (1)")
    curve.legend(frameon=False)
    return figure


DRAWINGS: dict[str, Callable[[Certificate], Figure]] = {
    "popov": popov_plot, "circle": circle_plot, "nyquist": nyquist_plot, "condition": condition_plot,
    "slopes": slopes_plot,
}  # fmt: skip
"""What a certificate draws, by its ``drawing``."""
