"""Pictures of circles: Figures 16 to 18, 20 and 21 of the paper drawn from our runs, and what a ball bar would read."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.analysis.circular.instrument import read_by
from leadscrew.report.ballbar_picture import COLOURS, WORDS, centred, division_um, polar
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION
from leadscrew.studies.fsmc_ballscrew.circles import CIRCLES, Way, axis_loop, drawn
from leadscrew.studies.fsmc_ballscrew.claims_circle import HZ, IDEAL, RADIUS, TABLE, Circles, both
from leadscrew.studies.fsmc_ballscrew.claims_creep import LAWS, NAMES, creeps, slow_circle
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.study import Picture

FEED_HZ = (0.1, 2.0, 5.0)
"""Low, medium and high feed of Figure 21."""
FEED_PENS = ((BLUE, "-"), (ORANGE, "--"), (VERMILION, "-."))
SAMPLED = ("ours.smc_4khz", "ours.fsmc_4khz", "ours.pd_dob")
AROUND_S = 0.06
"""Time on both sides of the reversal in Figure 17."""


def circle_pictures(loops: Loops, circles: Circles | None = None) -> list[Picture]:
    """All of them, drawn on demand; ``circles`` of the claims saves drawing them again."""
    kept = circles or Circles(loops)
    return [
        Picture("fig16_circles", "Circles of R = 5 mm at 300 mm/min by the paper's three laws in continuous time, as a "
                "double ball bar without error would draw them.", partial(circles_of, kept, IDEAL)),
        Picture("fig16_circles_4khz", "The same circles at 4 kHz with a scale of 10 nm.",
                partial(circles_of, kept, SAMPLED)),
        Picture("fig17_stick_motion", "Stick motion (Figure 17): the axis stands still behind its reversal until its "
                "error has built up the torque to break away.", partial(stick_motion, loops)),
        Picture("fig18_stick_polar", "The trace of stick motion on the circle (Figure 18).",
                partial(stick_polar, loops)),
        Picture("fig20_stick_slip", "Stick-slip (Figure 20): a circle so slow that each axis jerks where it is slower "
                "than a few um/s, near its reversals.", partial(stick_slip, loops)),
        Picture("stick_slip_feed", "Error at constant feed: stick-slip below 5 um/s, none from there.",
                partial(feeds, loops)),
        Picture("fig21_radius", "The circle against the feed (Figure 21): R = 1 mm by FSMC in continuous time, and how "
                "the radius changes under each law.", partial(radius, kept)),
        Picture("bar_reading", "What a double ball bar with a resolution of 0.1 um reads of the true path.",
                partial(bar_reading, kept)),
    ]  # fmt: skip


def _division(paths: dict[str, tuple[Any, Any]]) -> float:
    return division_um(max(float(np.abs(r).max()) for _, r in paths.values()))


def _directions(figure: Figure) -> None:
    """One legend for the directions, below, where it hides nothing."""
    from matplotlib.lines import Line2D

    lines = [Line2D([], [], color=colour) for colour in COLOURS.values()]
    figure.legend(lines, [WORDS[d] for d in COLOURS], loc="outside lower center", ncols=2, frameon=False)


def circles_of(circles: Circles, names: tuple[str, ...]) -> Figure:
    """Polar plots side by side, each with its own magnification."""
    figure = Figure(figsize=(11.4, 4.6), layout="constrained")
    for i, name in enumerate(names):
        axes = figure.add_subplot(1, len(names), i + 1, projection="polar")
        test = circles.of(name, CIRCLES["r5"])
        paths = centred(test)
        polar(axes, paths, _division(paths), test)
        found = both(test)
        said = f"{name}: G(b) {found.circular:.3f} µm, D {found.mean_radial:+.3f} µm"
        axes.set_title(f"{said}\n{axes.get_title()}", fontsize="small")
    _directions(figure)
    return figure


def stick_motion(loops: Loops) -> Figure:
    """Position and error of one axis around a reversal."""
    figure = Figure(figsize=(7.0, 5.6), layout="constrained")
    place, error = figure.subplots(2, 1, sharex=True)
    way = CIRCLES["r5"]
    turn = math.pi / way.rate_rad_s
    shown = False
    for law, line, colour in (("pid", "-", VERMILION), ("fsmc", "--", BLUE)):
        live = axis_loop(loops, LAWS[law], way, "x").start()
        live.advance(math.floor((turn - AROUND_S) / live.loop.period), record=(), every=0)
        run = live.advance(math.ceil(2.0 * AROUND_S / live.loop.period), record=("true_error", "command.position"))
        ms = 1e3 * (run.time - turn)
        above = 1e3 * (run["command.position"] + way.radius_mm)
        if not shown:
            place.plot(ms, above, color=BLACK, linestyle=":", label="command")
            shown = True
        place.plot(ms, above - 1e3 * run["true_error"], color=colour, linestyle=line, label=NAMES[law])
        error.plot(ms, -1e3 * run["true_error"], color=colour, linestyle=line)
    for axes in (place, error):
        axes.axvline(0.0, color="0.7", linewidth=0.8, zorder=0)
    place.set(ylabel="distance from the end (µm)", title="X at its reversal, R = 5 mm at 300 mm/min")
    error.set(xlabel="time from the commanded reversal (ms)", ylabel="error (µm)")
    handles, labels = place.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def stick_polar(loops: Loops) -> Figure:
    """Polar traces of the laws of Figure 17."""
    figure = Figure(figsize=(8.6, 4.8), layout="constrained")
    for i, law in enumerate(("pid", "fsmc")):
        axes = figure.add_subplot(1, 2, i + 1, projection="polar")
        test = drawn(loops, LAWS[law], CIRCLES["r5"], both=False)
        paths = centred(test)
        polar(axes, paths, _division(paths), test)
        axes.set_title(f"{NAMES[law]}\n{axes.get_title()}", fontsize="small")
    _directions(figure)
    return figure


def stick_slip(loops: Loops) -> Figure:
    """Polar trace of the slow circle, and the same over the angle."""
    test = slow_circle(loops)
    figure = Figure(figsize=(10.0, 4.8), layout="constrained")
    left = figure.add_subplot(1, 2, 1, projection="polar")
    right = figure.add_subplot(1, 2, 2)
    paths = {"ccw": centred(test)["ccw"]}
    polar(left, paths, _division(paths), test)
    angle, deviation = paths["ccw"]
    degrees = np.mod(np.degrees(angle), 360.0)
    order = np.argsort(degrees, kind="stable")
    right.plot(degrees[order], deviation[order], color=COLOURS["ccw"], linewidth=1.0)
    for reversal in range(0, 361, 90):
        right.axvspan(reversal - 14.5, reversal + 14.5, color="0.92", zorder=0)
    right.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel="angle (degrees)", ylabel="radial deviation (µm)",
              title="grey: one axis slower than 5 µm/s")  # fmt: skip
    figure.suptitle(f"R = {test.radius_mm:g} mm at {test.feed_mm_min:g} mm/min, counter-clockwise, {NAMES['fsmc']}",
                    fontsize="small")  # fmt: skip
    return figure


def feeds(loops: Loops) -> Figure:
    """Error against time at some feeds, for two laws."""
    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    shown = ((1.0, VERMILION, "-"), (2.0, ORANGE, "--"), (5.0, BLUE, "-."))
    for axes, law in zip(panels, ("fsmc", "pid"), strict=True):
        runs = creeps(loops, LAWS[law], [feed for feed, *_ in shown], encoder_nm=0.0)
        for feed, colour, line in shown:
            run = runs[feed]
            axes.plot(run.time, run.error_um, color=colour, linestyle=line, linewidth=1.0, label=f"{feed:g} µm/s")
        axes.set(ylabel="error (µm)")
        axes.set_title(NAMES[law], fontsize="small")
    panels[-1].set_xlabel("time (s)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def radius(circles: Circles) -> Figure:
    """Three circles at three feeds with their magnification, and D against frequency."""
    figure = Figure(figsize=(10.6, 5.4), layout="constrained")
    left: Any = figure.add_subplot(1, 2, 1, projection="polar")
    right = figure.add_subplot(1, 2, 2)
    controller = "corrected.fsmc"
    tests = {hz: circles.of(controller, Way(1.0, 2.0 * math.pi * hz)) for hz in FEED_HZ}
    division, ring = 0.1, 8.0
    for (hz, test), (colour, line) in zip(tests.items(), FEED_PENS, strict=True):
        assert test.ccw is not None
        angle, deviation = np.append(test.ccw.angle, test.ccw.angle[0]), test.ccw.deviation_um(test.radius_mm)
        left.plot(angle, ring + np.append(deviation, deviation[0]) / division, color=colour, linestyle=line,
                  label=f"{test.feed_mm_min:.0f} mm/min ({hz:g} Hz)")  # fmt: skip
    left.plot([0.0], [ring], marker="o", markersize=4, color=BLACK, linestyle="none", label="start and stop")
    left.set_rlim(0.0, ring + 1.5)
    left.set_rticks([ring - 4, ring - 2, ring], ["−0.4", "−0.2", "0 µm"], fontsize="x-small")
    left.set_thetagrids(range(0, 360, 90), ["+X", "+Y", "−X", "−Y"])
    left.grid(color="0.85", linewidth=0.5)
    left.set_title(f"{controller}, R = 1 mm, magnification {1e3 / (ring * division):,.0f} : 1", fontsize="small")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=2, frameon=False, fontsize="small")
    marks = dict(zip(RADIUS, ((VERMILION, "-", "o"), (BLUE, "--", "s"), (GREEN, "-.", "^"), (PURPLE, ":", "D")),
                     strict=True))  # fmt: skip
    for name, (colour, line, mark) in marks.items():
        sizes = [circles.radius(name, hz) for hz in HZ]
        label = f"FSMC at 4 kHz ({TABLE[name].params.lam:g} 1/s)" if name in TABLE else name
        right.plot(HZ, sizes, color=colour, linestyle=line, marker=mark, markersize=4, label=label)
    right.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    right.set_xscale("log")
    right.set_yscale("symlog", linthresh=0.01)
    right.set_xticks(HZ, [f"{hz:g}" for hz in HZ])
    right.minorticks_off()
    right.set(xlabel="turns per second (Hz)", ylabel="D, change of the radius (µm)", title="R = 1 mm")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower right", ncols=2, frameon=False, fontsize="small")
    return figure


def bar_reading(circles: Circles) -> Figure:
    """True path and reading over the angle, for a law that the bar sees and one that it does not."""
    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    for axes, name in zip(panels, ("ours.fsmc_4khz", "corrected.fsmc"), strict=True):
        test = circles.of(name, CIRCLES["r5"])
        reading = read_by(circles.bar, test)
        for what, found, colour, line in (("bar", reading, ORANGE, "-"), ("true path", test, BLUE, "-")):
            assert found.ccw is not None
            order = np.argsort(np.mod(np.degrees(found.ccw.angle) + 1e-6, 360.0))
            degrees = np.mod(np.degrees(found.ccw.angle) + 1e-6, 360.0)[order]
            axes.plot(degrees, found.ccw.deviation_um(test.radius_mm)[order], color=colour, linestyle=line,
                      linewidth=1.0, label=what)  # fmt: skip
        axes.set(ylabel="radial deviation (µm)")
        axes.set_title(f"{name}: G(b) {both(test).circular:.3f} µm, by the bar {both(reading).circular:.2f} µm",
                       fontsize="small")  # fmt: skip
    panels[-1].set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel="angle (degrees)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    return figure
