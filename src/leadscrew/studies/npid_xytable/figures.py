"""The study's figures: the law, Table II, stability and chatter, controllers under cutting, friction, the spindle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.harmonics import Sampling, spectrum
from leadscrew.analysis.stability.criteria import ask
from leadscrew.controllers import _npid as cosh
from leadscrew.controllers import _npid_slope as limited
from leadscrew.controllers import _resonant as resonant
from leadscrew.figures.panels import grid, with_legend
from leadscrew.figures.stability import draw_popov, finish
from leadscrew.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    colour,
    pen,
)
from leadscrew.kernel.parameters import entries
from leadscrew.studies.exhibits import figure
from leadscrew.studies.lab import Lab
from leadscrew.studies.npid_xytable import chatter, friction, spindle
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.claims import NPID, PID, RETUNED
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.cutting import FEW, SPEED_KNOWN, lines_um, trial
from leadscrew.studies.npid_xytable.experiments import BOXED, chatter_rows
from leadscrew.studies.npid_xytable.intercept import PRINTED
from leadscrew.studies.npid_xytable.laws import straight_fit
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.studies.npid_xytable.rejection import let_through, opened
from leadscrew.studies.npid_xytable.table2 import BASE_HZ, LINES_HZ, NPID_UM, PID_UM, SPEEDS, at, compared
from leadscrew.studies.npid_xytable.tunings import TUNINGS, XY_TABLE, fed_forward

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.kernel.run import Run

SHOWN = (PID, NPID, "ours.pid_159_ff", "ours.resonant_full")
"""Controllers of bars and traces, worst first."""
GUIDE: dict[str, Any] = {"color": "0.5", "linewidth": 0.8, "linestyle": ":", "zorder": 0}
POINTS: dict[str, Any] = {"color": BLACK, "linestyle": "none"}
"""What the paper prints."""
HIGHEST_HZ = 60.0
FREQUENCIES = [f"{hz:.1f}" for hz in LINES_HZ]


def cut(lab: Lab, controller: str) -> Run:
    """A controller's run at 1,000 1/min, with the spindle's speed where it takes it."""
    if controller not in SPEED_KNOWN:
        return lab.run(controller, "spindle_1000")
    keys = [e.key for e in entries(CONTROLLERS[controller].params, "controller.") if e.key.endswith("spindle_hz")]
    return lab.run(controller, "spindle_1000", changes={min(keys, key=len): 1000.0 / 60.0})


# ---- the law
@figure("The largest gain against e_max for α = 0.5 (Figure 4), which the paper calls linearly proportional.")
def gain_against_e_max(lab: Lab) -> Figure:
    fig, axes = grid(6.4, 4.2)
    x, k, line, r2 = straight_fit()
    axes.plot(x, k, color=BLUE, label="K = cosh(0.5 e_max)")
    axes.plot(x, line, color=ORANGE, linestyle="-.", label=f"straight line, R² = {r2:.3f}")
    axes.axhline(2.5, **pen("paper says", "paper: limit 2.5"))
    axes.plot([3.0], [2.35], "o", color=BLACK, label="Table I")
    axes.set(xlabel="e_max (unit of the error)", ylabel="K(e_max) (1)", xlim=(0.0, 3.1))
    return with_legend(fig, axes)


@figure(
    "Gain and slope of the laws against the error: the gain of NPID stays below the gain limit of L*, its slope not."
)
def laws(lab: Lab) -> Figure:
    fig, panels = grid(8.6, 4.0, 1, 2)
    e = 1e-3 * np.linspace(0.004, 8.0, 800)
    for name, module in (("paper.npid_mm", cosh), (NPID, cosh), ("ours.npid_slope", limited)):
        p = CONTROLLERS[name].params
        panels[0].plot(1e3 * e, [module.curve(p, v) / v for v in e.tolist()], **pen(name))
        panels[1].plot(1e3 * e, [module.slope(p, v) for v in e.tolist()], **pen(name))
    limit = chatter.linear(lab).gain_limit()
    for axes, name in zip(panels, ("gain f/e (1)", "slope df/de (1)"), strict=True):
        axes.axhline(limit, **GUIDE, label=f"gain limit of L*, {limit:.2f}")
        axes.set(xlabel="error (µm)", ylabel=name, xlim=(0.0, 8.0), ylim=(0.0, 6.0))
    return with_legend(fig, panels[0], columns=4)


# ---- Table II
@figure(
    "Table II as printed. Above each pair the printed reduction; where it does not follow from the two amplitudes it "
    "is framed, with the right one below it."
)
def table2_printed(lab: Lab) -> Figure:
    fig, panels = grid(10.0, 4.2, 1, 3, sharey=True)
    for axes, rpm in zip(panels, SPEEDS, strict=True):
        some, places = at(rpm), np.arange(5)
        for shift, field, name in ((-0.2, "pid_um", PID), (0.2, "npid_um", NPID)):
            label = field.removesuffix("_um").upper()
            axes.bar(places + shift, [getattr(r, field) for r in some], 0.38, color=colour(name), label=label)
        for place, row in zip(places, some, strict=True):
            text = f"{row.printed:g} %" if row.agrees else f"{row.printed:g} %\n({row.reduction:.0f} %)"
            frame = None if row.agrees else {"facecolor": "white", "edgecolor": "black", "pad": 2.0}
            where = {"textcoords": "offset points", "ha": "center", "va": "bottom", "fontsize": "small"}
            axes.annotate(text, (place, max(row.pid_um, row.npid_um)), (0, 5), bbox=frame, **where)
        axes.set_title(f"{rpm:,} 1/min: mean {compared(some).mean:.2g} %", fontsize="medium")
        axes.set_xticks(places, [f"{r.hz:g}" for r in some])
        axes.set(xlabel="printed frequency (Hz)", ylim=(0.0, 1.65))
    panels[0].set_ylabel("amplitude of the error (µm)")
    return with_legend(fig, panels[0])


@figure(
    "The fifteen rows of Table II, printed and simulated at 1 mm (bars: mean over the phases of the forces, lines: 5 "
    "to 95 %). PID is calibrated to its column.",
    key=True,
)
def table2_simulated(lab: Lab) -> Figure:
    fig, panels = grid(8.0, 6.4, 3, 1, sharex=True)
    places, width = np.arange(len(LINES_HZ)), 0.8 / len(SHOWN)
    for rpm, axes in zip(SPEEDS, panels, strict=True):
        for k, name in enumerate(SHOWN):
            rows = trial(lab, name, 1.0, FEW).at(rpm)
            (low, high), mean = np.percentile(rows, (5, 95), axis=0), rows.mean(axis=0)
            spread = {"yerr": np.abs([mean - low, high - mean]), "error_kw": {"lw": 1, "capsize": 2}}
            axes.bar(places + (k - 1.5) * width, mean, width, color=colour(name), label=name, **spread)
        axes.plot(places, PID_UM[rpm], marker="_", markersize=9, label="PID, printed", **POINTS)
        axes.plot(places, NPID_UM[rpm], marker="x", markersize=7, label="NPID, printed", **POINTS)
        axes.set_ylabel(f"{rpm:,} 1/min\namplitude (µm)")
    panels[-1].set_xticks(places, FREQUENCIES)
    panels[-1].set_xlabel("line (Hz)")
    return with_legend(fig, panels[0], columns=3)


def draw_spectrum(lab: Lab, name: str, printed: dict[int, tuple[float, ...]]) -> Figure:
    fig, axes = grid(8.0, 3.6)
    run = lab.run(name, "spindle_1000")
    error = 1e3 * run["true_error"][len(run.time) // 2 :]
    seen = spectrum(Sampling(len(error), 0.0, PERIOD_S), error, "hann")
    shown = (seen.frequencies > 0.0) & (seen.frequencies <= HIGHEST_HZ)
    axes.plot(seen.frequencies[shown], seen.amplitudes[shown], linewidth=0.9, color=colour(name), label=name)
    axes.plot(LINES_HZ, lines_um(lab, name, "spindle_1000"), marker="x", **POINTS, label="by least squares")
    axes.plot(LINES_HZ, printed[1000], ".", color=ORANGE, markersize=9, label="Table II")
    axes.set(yscale="log", ylim=(1e-4, 30.0), xlim=(0.0, HIGHEST_HZ), xlabel="frequency (Hz)", ylabel="amplitude (µm)")
    axes.set_title(f"motion at {BASE_HZ:g} Hz, spindle at 16.7 Hz", fontsize="medium")
    return with_legend(fig, axes, columns=3)


@figure("FFT of the tracking error under NPID at 1,000 1/min (Figure 4 of section III), simulated, with Table II.")
def spectrum_npid_1000(lab: Lab) -> Figure:
    return draw_spectrum(lab, NPID, NPID_UM)


@figure("FFT of the tracking error under PID at 1,000 1/min (Figure 5 of section III), simulated, with Table II.")
def spectrum_pid_1000(lab: Lab) -> Figure:
    return draw_spectrum(lab, PID, PID_UM)


# ---- stability
@figure(
    "The paper's Popov plot, redrawn. As printed the loop never reaches the axis; with 1.2888 ms of dead time it "
    "crosses at −0.4. Left the best line for a range of gains from 0, right for one from 1."
)
def popov_paper(lab: Lab) -> Figure:
    fig, (left, right) = grid(8.6, 4.6, 1, 2)
    loops = reference_loops()
    w = np.geomspace(1.0, 1e5, 1000)
    g = loops["no_delay"].response(w)
    zero, one = (ask("popov", loops["Lc"], k) for k in (0.0, 1.0))
    draw_popov(left, zero, BLUE, VERMILION, "G with 1.2888 ms of dead time")
    bounds = left.get_xlim(), left.get_ylim()
    left.plot(g.real, w * g.imag, color=SKY, linewidth=1.1, label="G as printed")
    left.plot([PRINTED], [0.0], marker="x", markersize=8, label="paper: (−0.4, j0)", **POINTS)
    left.set(xlim=bounds[0], ylim=bounds[1])
    draw_popov(right, one, PURPLE, GREEN)
    for axes, found, k in ((left, zero, 0), (right, one, 1)):
        axes.set_title(f"range [{k}, K]: the best line proves K = {found.limit:.3f}", fontsize="medium", loc="left")
        finish(axes, columns=1)
        axes.set(xlabel="Re G (1)", ylabel="ω Im G (rad/s)")
    return fig


@figure(
    "Chatter of NPID in L*. Left: under a constant load, simulated after a kick and predicted. Right: under a load "
    "that slowly rises and falls, without a kick."
)
def chatter_against_load(lab: Lab) -> Figure:
    fig, (axes, slow) = grid(9.0, 4.2, 1, 2, sharey=True)
    rows = [row for row in chatter_rows(lab).values() if row.e_max == 3.0 and row.delay_s == chatter.DEAD_TIME_S]
    rows = sorted({row.load_um: row for row in rows}.values())
    loads = [row.load_um for row in rows]
    axes.plot(loads, [row.peak_to_peak_um for row in rows], marker="o", **POINTS, label="simulated")
    loud = [row for row in rows if row.peak_to_peak_um > chatter.QUIET_UM]
    for many, ink, name in ((True, BLUE, "harmonic balance"), (False, SKY, "describing function")):
        sizes = [chatter.predicted_um(lab, row, many) for row in loud]
        axes.plot([row.load_um for row in loud], sizes, color=ink, label=name)
    load, size = chatter.slow_sweep(lab)
    half = len(load) // 2
    slow.plot(load[20:half], size[20:half], color=VERMILION, label="slowly rising")
    slow.plot(load[half:], size[half:], color=GREEN, linestyle="-.", label="slowly falling")
    for panel in (axes, slow):
        panel.set(xlabel="load, as what the curve carries (µm)", xlim=(0.0, 20.0))
    axes.set_ylabel("error, peak to peak (µm)")
    return with_legend(fig, axes, slow, columns=5)


# ---- controllers
@figure("Error over one period of the motion at 1,000 1/min, spindle lines included, read without an encoder.")
def errors_1000(lab: Lab) -> Figure:
    fig, panels = grid(8.0, 6.4, len(SHOWN), 1, sharex=True)
    for axes, name in zip(panels, SHOWN, strict=True):
        run = cut(lab, name)
        last = run.time >= run.time[-1] - 1.0 / BASE_HZ
        axes.plot(run.time[last] - run.time[last][0], 1e3 * run["true_error"][last], linewidth=0.9, **pen(name))
        axes.set_ylabel("error (µm)")
        axes.set_title(name, fontsize="medium", loc="left")
    panels[-1].set_xlabel("time (s)")
    return fig


@figure("RMS error of every run on the twelve plants of the box, three spindle speeds.")
def box_errors(lab: Lab) -> Figure:
    fig, axes = grid(7.5, 4.2)
    for place, name in enumerate(BOXED):
        size = trial(lab, name, 1.0, 1, box=True).rms
        axes.plot(size, np.full(size.size, place) + np.linspace(-0.25, 0.25, size.size), ".", color=colour(name))
    axes.set_yticks(np.arange(len(BOXED)), BOXED)
    axes.invert_yaxis()
    axes.set(xscale="log", xlabel="rms error of a run (µm)")
    return fig


@figure(
    "Error for 1 mV at the plant's input against frequency, in L*. Dotted: the lines of Table II, and of a spindle at "
    "3,000 1/min with two teeth, where the resonators have their zeros."
)
def disturbance_gain(lab: Lab) -> Figure:
    fig, axes = grid(8.0, 4.8)
    spindle_hz = (50.0, 100.0)
    full = fed_forward(resonant.resonant(TUNINGS[RETUNED], spindle_hz=spindle_hz[0], model=XY_TABLE))
    beside = np.outer([*resonant.ODD_HZ, *spindle_hz], 1.0 + np.geomspace(1e-4, 0.05, 8)).ravel()
    hz = np.unique(np.concatenate([np.geomspace(0.3, 990.0, 400), beside]))
    names = (PID, "ours.pid_dob_60", "ours.cascade", RETUNED)
    for name, block in {**{n: CONTROLLERS[n] for n in names}, "ours.resonant_full": full}.items():
        axes.loglog(hz, let_through(opened(block), hz), **pen(name))
    for line in (*LINES_HZ, *spindle_hz):
        axes.axvline(line, **GUIDE)
    axes.set(xlim=(hz[0], hz[-1]), ylim=(1e-4, 2.0), xlabel="frequency (Hz)", ylabel="error per disturbance (µm/mV)")
    return with_legend(fig, axes, columns=3)


# ---- friction, spindle
@figure(
    "Error around a reversal, 15 mm at 0.7 Hz against 150 mV of LuGre friction. Right: with the learned feed-forward, "
    "read by an encoder of 0.5 µm."
)
def friction_reversal(lab: Lab) -> Figure:
    fig, panels = grid(8.6, 3.8, 1, 2)
    turns = np.arange(0.25, BASE_HZ * friction.RUN_S, 0.5) / BASE_HZ
    turn = turns[turns < friction.RUN_S - 0.15][-1]
    time = friction.RUN_S - PERIOD_S * np.arange(friction.COUNTS, 0, -1)
    seen = (time > turn - 0.02) & (time < turn + 0.1)
    traces = {name: found.error[3] for name, found in friction.sines_on_friction(lab).items()}
    traces["ours.learned"] = friction.learned_sines(lab)["as believed"].error[0]
    for axes, names in ((panels[0], tuple(traces)), (panels[1], ("ours.learned",))):
        for name in names:
            axes.plot(1e3 * (time[seen] - turn), traces[name][seen], **pen(name))
        axes.axvline(0.0, **GUIDE)
        axes.set(xlabel="time from the reversal (ms)", ylabel="error (µm)")
    return with_legend(fig, panels[0], columns=4)


@figure(
    "Error at the lines of spindle (1 mV) and four teeth (2 mV) from 500 to 24,000 1/min: simulated (marks) and in "
    "closed form (lines). Right of the dotted line the teeth pass faster than half the sampling frequency."
)
def spindle_sweep(lab: Lab) -> Figure:
    fig, panels = grid(7.6, 6.0, 2, 1, sharex=True)
    for axes, what in zip(panels, ("spindle", "tooth"), strict=True):
        for name, mark in zip(spindle.SWEPT, "os^vD", strict=True):
            values = np.where(spindle.APART, getattr(spindle.sweep(lab, name), what), np.nan)
            label, ink = (f"{RETUNED}, resonators", GREEN) if name == "resonant" else (name, colour(name))
            axes.plot(spindle.RPM, values, mark, color=ink, markersize=4, label=label)
            if name in (PID, RETUNED):
                expected = np.where(spindle.APART, getattr(spindle.closed_form(name), what), np.nan)
                axes.plot(spindle.RPM, expected, color=ink, linewidth=0.9)
        axes.axvline(spindle.FOLDS_RPM, **GUIDE)
        axes.set(xscale="log", yscale="log", ylim=(1e-5, 5.0), ylabel=f"error at the {what} line (µm)")
    panels[1].set_xticks((500, 1000, 2000, 5000, 10000, 24000), ("500", "1,000", "2,000", "5,000", "10,000", "24,000"))
    panels[1].minorticks_off()
    panels[1].set_xlabel("spindle speed (1/min)")
    return with_legend(fig, panels[0], columns=3)
