"""Pictures of the laws: the paper's Fig. 4 with its straight line, all curves, both clips, and the add-ons at work."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.controllers import npid as cosh
from leadscrew.controllers import npid_slope as limited
from leadscrew.controllers.dead_zone_inverse import dead_zone_inverse
from leadscrew.controllers.npid import READINGS
from leadscrew.controllers.npid_slope import TUNINGS as LIMITED
from leadscrew.controllers.pid import pid
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.claims_add_ons import DRIVE, followed_rate
from leadscrew.studies.npid_xytable.claims_law import straight_fit
from leadscrew.studies.npid_xytable.runs import Loops, build
from leadscrew.studies.npid_xytable.scenarios import SCENARIOS
from leadscrew.studies.study import Picture

SMALL_COSH = cosh.npid(e_max=1.7469)
"""alpha e_max = 0.8734: slopes up to 2.27."""

LAWS: tuple[tuple[str, Any, Any, dict[str, Any]], ...] = (
    ("paper.npid_mm: e in mm", cosh, READINGS["paper.npid_mm"].params, {"color": BLACK, "linestyle": "--"}),
    ("corrected.npid_um: e in um", cosh, READINGS["corrected.npid_um"].params, {"color": BLUE}),
    ("the same, e itself clipped", cosh, READINGS["corrected.npid_um_clipped"].params,
     {"color": ORANGE, "linestyle": ":", "linewidth": 2.4}),
    ("cosh with slopes to 2.27", cosh, SMALL_COSH.params, {"color": GREEN, "linestyle": "-."}),
    ("ours.npid_slope: k = 2.2, es = 0.5 um", limited, LIMITED["ours.npid_slope"].params, {"color": VERMILION}),
    ("ours.npid_slope_159: k = 1.5", limited, LIMITED["ours.npid_slope_159"].params,
     {"color": PURPLE, "linestyle": (0, (5, 1))}),
)  # fmt: skip
"""Label, module, parameters, pen. npid_after has the gain of corrected.npid_um, behind the PID."""


def law_pictures(loops: Loops) -> list[Picture]:
    """All of them."""
    return [
        Picture("gain_against_e_max", "The paper's Fig. 4: the largest gain against e_max for alpha = 0.5, called "
                "linearly proportional; the straight line of least squares beside it.", gain_against_e_max),
        Picture("laws", "Scaled error, gain and slope of every law against the error. The gain margin of L* bounds "
                "the gain for a loop at rest, and the slope for a loop under load.", laws),
        Picture("clip_readings", "A sine of 2 mm with e_max clipping the error inside the gain only, and the error "
                "itself: the second loses the motion.", partial(clip_readings, loops)),
        Picture("add_ons", "The paper's future work. Left: a dead zone of 20 mV in the drive, compensated whole, by "
                "80 % and not at all. Right: the rate of the error by difference and by a tracking differentiator.",
                partial(add_ons, loops)),
    ]  # fmt: skip


def gain_against_e_max() -> Figure:
    """K(e_max), its straight line, the limit and the choice."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    x, k, line, r2 = straight_fit()
    axes.plot(x, k, color=BLUE, label="K = cosh(0.5 e_max)")
    axes.plot(x, line, color=ORANGE, linestyle="--", label=f"straight line, R$^2$ = {r2:.3f}")
    axes.axhline(2.5, color=BLACK, linestyle=":", label="the paper's limit, 2.5")
    axes.plot([3.0], [2.35], "o", color=BLACK, label="Table I: e_max = 3, K = 2.35")
    axes.set(xlabel="e_max (unit of the error)", ylabel="K(e_max)", xlim=(0.0, 3.1))
    axes.legend(frameon=False, fontsize="small", loc="lower right")
    axes.grid(alpha=0.3)
    return figure


def laws() -> Figure:
    """Three panels: curve, gain, slope, against the error in um."""
    figure = Figure(figsize=(10.5, 4.6), layout="constrained")
    panels = figure.subplots(1, 3)
    e = 1e-3 * np.linspace(0.004, 8.0, 2000)
    for label, module, p, pen in LAWS:
        curve = np.array([module.curve(p, v) for v in e.tolist()])
        slope = np.array([module.slope(p, v) for v in e.tolist()])
        for axes, y in zip(panels, (1e3 * curve, curve / e, slope), strict=True):
            axes.plot(1e3 * e, y, label=label, **pen)
    for axes, name in zip(panels, ("scaled error f (um)", "gain f / e", "slope df/de"), strict=True):
        axes.set(xlabel="error (um)", ylabel=name, xlim=(0.0, 8.0))
        axes.grid(alpha=0.3)
    for axes in panels[1:]:
        axes.axhline(2.51, color=SKY, linewidth=1.0)
        axes.text(7.9, 2.55, "gain margin of L*, 2.51", color=BLACK, ha="right", va="bottom", fontsize="x-small")
    panels[1].set_ylim(0.0, 2.9)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure


def clip_readings(loops: Loops) -> Figure:
    """Position and error under both readings."""
    figure = Figure(figsize=(7.6, 5.2), layout="constrained")
    position, error = figure.subplots(2, 1, sharex=True)
    run = loops.get("corrected.npid_um", "sine_1mm").batch(
        8.0,
        {"controller.clip_error": np.array([False, True]), "reference.amplitude": np.array([2.0, 2.0])},
        record=("command", "actual", "true_error"),
    )
    late = slice(round(5.0 / PERIOD_S), None, 4)
    t = np.asarray(run.time)[late]
    position.plot(t, run["command"][0][late], color=BLACK, linestyle=":", linewidth=2.4, label="command")
    for k, (name, colour, pen) in enumerate((("clipped inside K", BLUE, "-"), ("error itself clipped", ORANGE, "--"))):
        position.plot(t, run["actual"][k][late], color=colour, linestyle=pen, label=name)
        error.semilogy(t, np.maximum(1e3 * np.abs(run["true_error"][k][late]), 1e-2), color=colour, linestyle=pen)
    position.set(ylabel="position (mm)", ylim=(-2.3, 3.4))
    position.legend(frameon=False, fontsize="small", ncols=3, loc="upper center")
    error.set(xlabel="time (s)", ylabel="size of the error (um)")
    error.grid(alpha=0.3)
    return figure


def add_ons(loops: Loops) -> Figure:
    """Error with a dead zone, and the error's rate."""
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    zone, rate = figure.subplots(1, 2)
    loop = build(dead_zone_inverse(pid), SCENARIOS["sine_1mm"], actuator=DRIVE)
    shares = np.array([0.0, 0.8, 1.0])
    run = loop.batch(6.0, {"controller.width": DRIVE.params.threshold * shares}, record="true_error")
    late = slice(round(3.0 / PERIOD_S), None)
    pens = ((VERMILION, "--"), (ORANGE, "-."), (BLUE, "-"))
    for share, e, (colour, pen) in zip(shares.tolist(), run["true_error"], pens, strict=True):
        zone.plot(np.asarray(run.time)[late], 1e3 * e[late], color=colour, linestyle=pen,
                  label=f"{100.0 * share:.0f} %")  # fmt: skip
    zone.set(xlabel="time (s)", ylabel="error (um)", ylim=(-27.0, 38.0))
    zone.legend(frameon=False, fontsize="small", loc="upper center", ncols=3, title="of the dead zone compensated",
                title_fontsize="small")  # fmt: skip
    plain, followed, true = followed_rate(1e-3)
    shown = slice(round(2.0 / PERIOD_S), round(2.05 / PERIOD_S))
    t = 1e3 * PERIOD_S * np.arange(len(true))
    rate.plot(t[shown], plain[shown], color=SKY, label="difference")
    rate.plot(t[shown], followed[shown], color=BLUE, label="followed, h = 1 ms")
    rate.plot(t[shown], true[shown], color=BLACK, linestyle=":", linewidth=2.0, label="true")
    rate.set(xlabel="time (ms)", ylabel="rate of the error (mm/s)", ylim=(-1.9, 2.7))
    rate.legend(frameon=False, fontsize="small", loc="upper center", ncols=3)
    for axes in (zone, rate):
        axes.grid(alpha=0.3)
    return figure
