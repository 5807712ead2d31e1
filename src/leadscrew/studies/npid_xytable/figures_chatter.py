"""Pictures of the chatter: against load, in time, the curve and its slope, and the describing function's two loci."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable import chatter as c
from leadscrew.studies.npid_xytable import chatter_theory as th
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.study import Picture

TIME_UM = (2.5, 3.0, 7.0, 15.0)
"""Loads of the traces."""
LOCI_UM = (3.0, 7.0, 12.0)
DRAWN_UM = (2.82, 2.9, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 7.1, 7.5, 8.0, 9.0, 10.0, 11.0, 12.0, 12.5, 13.0, 13.3, 13.5, 13.6)


def chatter_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    rows = c.rows_for(loops)
    return [
        Picture("chatter_against_load", "Chatter of NPID in L* against a constant load: simulated, and predicted by "
                "describing function and harmonic balance; dashed the unstable cycle, the edge over which a kick "
                "starts the stable one. Right: under a load that slowly rises, and falls.",
                partial(against_load, rows)),
        Picture("chatter_in_time", "The error of NPID in L* under four constant loads, 2 s after the kick has ended.",
                partial(in_time, rows)),
        Picture("chatter_slope", "Why it chatters: the gain K stays below the gain limit of the loop, the slope of the "
                "curve does not.", slope),
        Picture("chatter_loci", "Nyquist curve of L* with -1/N(A) under three loads, and N against amplitude.", loci),
    ]  # fmt: skip


def against_load(rows: c.Rows) -> Figure:
    """Peak to peak against load, with predictions, and the slow sweep."""
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    axes, slow = figure.subplots(1, 2, sharey=True)
    single = [th.predicted(v * c.TAKEN_OVER, many=False) for v in DRAWN_UM]
    several = [th.predicted(v * c.TAKEN_OVER) for v in DRAWN_UM]
    for found, colour, name in ((single, SKY, "describing function"), (several, BLUE, "harmonic balance")):
        for stable in (True, False):
            sizes = [[1e3 * x.peak_to_peak for x in p.cycles if x.stable is stable] for p in found]
            axes.plot(
                DRAWN_UM, [max(s) if s else np.nan for s in sizes], color=colour, linestyle="-" if stable else "--",
                label=name + ("" if stable else ", unstable"),
            )  # fmt: skip
    loads = [v for v in c.LOADS_UM if v <= 15.0]
    axes.plot(loads, rows.table.peak_to_peak_um[: len(loads)], "o", color=BLACK, label="simulated")
    axes.set(xlabel="load, as what the curve carries (um)", ylabel="error, peak to peak (um)")
    axes.set_ylim(-0.3, 14.5)
    axes.legend(frameon=False, fontsize="small", loc="upper left")
    load, size = rows.sweep
    half = len(load) // 2
    slow.plot(load[20:half], size[20:half], color=VERMILION, label="slowly rising")
    slow.plot(load[half:], size[half:], color=GREEN, linestyle="--", label="slowly falling")
    slow.set(xlabel="load, as what the curve carries (um)")
    slow.legend(frameon=False, fontsize="small", loc="upper left")
    return figure


def in_time(rows: c.Rows) -> Figure:
    """Traces under four loads."""
    figure = Figure(figsize=(7.6, 4.6), layout="constrained")
    panels = figure.subplots(len(TIME_UM), 1, sharex=True)
    loop = c.chatter_loop(c.npid)
    done = loop.batch(c.RUN_S, {"disturbance.size": c.volts(TIME_UM)}, record=("true_error",))
    shown = slice(-round(0.06 / c.PERIOD_S), None)
    for axes, load, error in zip(panels, TIME_UM, done["true_error"], strict=True):
        e, mean = 1e3 * error[shown], 1e3 * error[-round(c.JUDGED_S / c.PERIOD_S) :].mean()
        axes.plot(1e3 * c.PERIOD_S * np.arange(len(e)), e - mean, ".-", color=BLUE, linewidth=0.8, markersize=3.5)
        axes.set_ylim(-4.6, 4.6)
        axes.set_title(f"load {load:g} um: about a mean of {abs(mean):.2f} um", fontsize="small", loc="left")
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("time (ms)")
    figure.supylabel("error less its mean (um)")
    return figure


def slope() -> Figure:
    """The curve, its gain and its slope against the error, with the gain limit."""
    figure = Figure(figsize=(9.2, 3.8), layout="constrained")
    curve, gains = figure.subplots(1, 2)
    e = np.linspace(0.0, 6.0, 1201)
    curve.plot(e, 1e3 * th.curve(1e-3 * e), color=BLUE, label="phi(e) = K(e) e")
    curve.plot(e, e, color=BLACK, linestyle=":", label="PID, phi(e) = e")
    curve.set(xlabel="error (um)", ylabel="phi (um)")
    curve.legend(frameon=False)
    limit = th.linear().gain_limit()
    gains.plot(e, th.slope(e), color=VERMILION, label="slope phi'")
    gains.plot(e[1:], 1e3 * th.curve(1e-3 * e[1:]) / e[1:], color=BLUE, label="gain K")
    gains.axhline(limit, color=BLACK, linestyle="--", label=f"gain limit of L*, {limit:.3f}")
    over = e[th.slope(e) > limit]
    gains.axvspan(over[0], over[-1], color=ORANGE, alpha=0.15, label="rest is unstable")
    gains.set(xlabel="error at rest (um)", ylabel="gain, slope (1)")
    gains.legend(frameon=False, fontsize="small")
    return figure


def loci() -> Figure:
    """Both halves of the describing function's condition."""
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    plane, gains = figure.subplots(1, 2)
    colours: tuple[Any, ...] = (GREEN, ORANGE, PURPLE)
    w = 2.0 * np.pi * np.geomspace(40.0, 1000.0, 1200)
    g = th.linear().response(w)
    plane.plot(g.real, g.imag, color=BLUE, label="G")
    plane.axhline(0.0, color=BLACK, linewidth=0.5)
    for k, (load, colour) in enumerate(zip(LOCI_UM, colours, strict=True)):
        found = th.predicted(load, many=False)
        locus = found.locus
        assert locus is not None
        seen = (locus.amplitude > 5e-5) & (locus.amplitude < 0.05)
        edge = -1.0 / locus.gain[seen]
        # drawn a little apart: all three lie on the real axis
        plane.plot(
            edge, np.full(edge.shape, -0.03 * (k + 1)), color=colour, linewidth=3.0, label=f"-1/N, load {load:g} um"
        )
        gains.semilogx(2e3 * locus.amplitude[seen], locus.gain[seen], color=colour, label=f"load {load:g} um")
        for cycle in found.cycles:
            gains.plot([2e3 * cycle.amplitude], [cycle.gain], "o" if cycle.stable else "x", color=colour)
    limit = th.linear().gain_limit()
    gains.axhline(limit, color=BLACK, linestyle="--", label=f"gain limit {limit:.3f}")
    plane.plot([-1.0 / limit], [0.0], "o", color=BLACK, label=f"crossing {-1.0 / limit:.4f}")
    plane.set(xlabel="Re G", ylabel="Im G", xlim=(-0.6, 0.15), ylim=(-0.45, 0.3))
    plane.legend(frameon=False, fontsize="small", loc="lower right")
    gains.set(xlabel="peak to peak of the fundamental (um)", ylabel="describing function N (1)")
    gains.legend(frameon=False, fontsize="small")
    return figure
