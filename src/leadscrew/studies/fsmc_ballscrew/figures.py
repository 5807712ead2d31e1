"""The study's figures: those of the paper, drawn from our runs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.circular.quantities import centred
from leadscrew.analysis.friction import friction_velocity
from leadscrew.figures.ballbar import COLOURS, WORDS, division_um, polar
from leadscrew.figures.panels import grid, with_legend
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, colour, pen
from leadscrew.friction.lugre import TABLE_2, LuGre
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.plants._backlash import DeadBand, reaction
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.exhibits import figure
from leadscrew.studies.fsmc_ballscrew.backlash import (
    BOTH,
    HARD,
    MOTOR,
    SOFT,
    TABLE,
    backlash_run,
    circle,
    crossing_of_parabola,
    impact,
)
from leadscrew.studies.fsmc_ballscrew.circles import (
    CIRCLES,
    HZ,
    IDEAL,
    NAMES,
    PID,
    SLOW_FSMC,
    Way,
    around_reversal,
    both,
    circle_of,
    radius_um,
    slow_circle,
)
from leadscrew.studies.fsmc_ballscrew.laws import LAM, PHI, SYSTEMS
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.tracking import LAWS, SECONDS, settled_run, sine_run
from leadscrew.studies.lab import Lab

if TYPE_CHECKING:
    from leadscrew.analysis.circular.paths import CircularTest
    from leadscrew.figures.figure import Figure

# A line that only guides the eye: a limit, a target.
GUIDE: dict[str, Any] = {"color": "0.5", "linewidth": 0.8, "linestyle": ":", "zorder": 0}
MOST = 2000
"""Points a curve is drawn with, where it has more: extremes of stretches, so that no peak is lost."""
UM_PER_RAD = 1e3 * TRAVEL_MM_PER_RAD


def thinned(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At most :data:`MOST` points of a curve, the smallest and the largest of every stretch among them."""
    stretch = -(-2 * len(t) // MOST)
    if stretch <= 2:
        return t, x
    blocks = x[: len(t) // stretch * stretch].reshape(-1, stretch)
    first = stretch * np.arange(len(blocks))
    chosen = np.unique(np.concatenate([first + blocks.argmin(axis=1), first + blocks.argmax(axis=1), [len(t) - 1]]))
    return t[chosen], x[chosen]


# ---- section 2: backlash and friction
@figure(
    "Figures 1 and 2: reaction of the classical backlash, a dead band whose gaps and slopes may differ by side; and "
    "after a reversal of sin 2πt mm the screw crosses 2 µm of play, hits the table, and the table bounces.",
)
def fig1_2_backlash(lab: Lab) -> Figure:
    fig, (left, middle, right) = grid(10.8, 3.8, 1, 3)
    twist = np.linspace(-5.0, 5.0, 501)
    for band, label, ink, line in (
        (DeadBand(1.0, 1.0, 1e8, 1e8), "1 µm and 100 N/µm each side", BLUE, "-"),
        (DeadBand(0.5, 2.5, 1.5e8, 6e7), "0.5 µm, 150 N/µm; 2.5 µm, 60 N/µm", ORANGE, "--"),
    ):
        left.plot(twist, [1e-6 * reaction(band, float(d)) for d in twist], color=ink, linestyle=line, label=label)
    for e, ink, line in ((HARD, PURPLE, "-"), (SOFT, VERMILION, "--")):
        found = impact(lab, "sine_fast", e)
        near = (found.since_s > -0.005) & (found.since_s < 0.08)
        for axes, y in ((middle, found.twist_um), (right, found.beyond_um)):
            axes.plot(1e3 * found.since_s[near], y[near], color=ink, linestyle=line, label=f"restitution {e:.2g}")
    for axes in (middle, right):
        axes.axvline(1e3 * crossing_of_parabola("sine_fast"), label="√(2b/(Rω²))", **GUIDE)
        axes.set_xlabel("time after the reversal (ms)")
    left.set(xlabel="screw minus table (µm)", ylabel="force on the table (N)", title="Figure 1: classical")
    middle.set(ylabel="screw minus table (µm)", title="Figure 2: dead band and impact")
    right.set(ylabel="table minus classical play (µm)", title="what the impact adds")
    return with_legend(fig, left, middle, columns=3)


@figure(
    "Figures 3 and 4: static, dynamic and viscous friction without a Stribeck effect; equation (3) with the viscous "
    "term by the three columns of Table 2, and its fall at the Stribeck speeds of 1 and 5 mrad/s.",
)
def fig3_4_friction(lab: Lab) -> Figure:
    fig, (left, middle, right) = grid(10.8, 3.8, 1, 3)
    f, wide = LuGre(), np.geomspace(1e-5, 6.0, 300)
    way, speed = Sliding(coulomb=f.coulomb, static=f.coulomb, viscous=f.viscous), np.linspace(1e-9, 6.0, 100)
    for sign in (-1.0, 1.0):
        left.plot(sign * speed, friction_velocity(TwoSided(way, way), sign * speed), color=BLUE)
    left.plot([0.0, 0.0], [-f.static, f.static], color=VERMILION, linewidth=2.2, label="at rest: up to F_S")
    near = np.linspace(1e-6, 0.016, 400)
    pens = {"plant": (BLACK, "-"), "hat": (BLUE, "--"), "tilde": (ORANGE, "-.")}
    for name, model in TABLE_2.items():
        style = dict(zip(("color", "linestyle"), pens[name], strict=True))
        middle.plot(wide, friction_velocity(model, wide), label=name, **style)
        right.plot(1e3 * near, friction_velocity(model, near), **style)
    left.set(xlabel="speed (rad/s)", ylabel="friction (N·m)", title="Figure 3: classical")
    middle.set(xlabel="speed (rad/s)", title="Figure 4: modern")
    right.set(xlabel="speed (mrad/s)", title="the fall", ylim=(6.0, 9.6))
    return with_legend(fig, left, middle, columns=4)


# ---- section 4: the layer and the fuzzy system
@figure(
    "Figure 7 with motions in it: a bare step of 1 mm under SMC and CSMC. Both come down the line of slope −λ and stop "
    "in their layers, CSMC in the one of half the width."
)
def fig7_boundary_layer(lab: Lab) -> Figure:
    fig, panels = grid(9.6, 4.2, 1, 2)
    x = np.array([-1200.0, 200.0])
    for law, half in (("corrected.smc", 1.0), ("paper.csmc", 0.5)):
        run = lab.run(law, "step_raw", 0.2, sample=2e-5)
        e, rate = -1e3 * run["true_error"], TRAVEL_MM_PER_RAD * run["plant.speed"]
        for axes in panels:
            axes.plot(e, rate, **pen(law))
            for side in (-1.0, 1.0):
                edge = TRAVEL_MM_PER_RAD * (side * half * PHI - LAM * x / UM_PER_RAD)
                axes.plot(x, edge, color=colour(law), linestyle=":", linewidth=1.1)
    panels[0].set(xlabel="e (µm)", ylabel="e' (mm/s)", xlim=(-1050.0, 60.0), title="the whole step")
    title = f"near the target: φ/λ = {UM_PER_RAD * PHI / LAM:.2f} µm"
    panels[1].set(xlabel="e (µm)", xlim=(-2.2, 2.2), ylim=(-0.45, 0.45), title=title)
    return with_legend(fig, panels[0])


SETS = {"N": VERMILION, "Z": GREEN, "P": BLUE, "NB": VERMILION, "NS": ORANGE, "ZO": GREEN, "PS": SKY, "PB": BLUE}
RULES = {"printed": "as printed", "corrected": "corrected", "without_dead_corner": "without the dead corner"}


@figure(
    "Figures 8 to 10 and the rules: the sets over their scales, and K as surfaces. The printed rules act along "
    "s − s_c, the corrected ones along s + s_c. At rest on the target s = −s_c: dashed with S_c = S, dash-dotted with "
    "S_c = 4 S; where K is 0 on it, nothing holds the friction."
)
def fig8_to_10_fuzzy(lab: Lab) -> Figure:
    fig, panels = grid(10.8, 7.0, 2, 3)
    system, x = SYSTEMS["corrected"], np.linspace(-1.6, 1.6, 641)
    for axes, variable, label, title in (
        (panels[0, 0], system.inputs[0], "s/S, s_c/S_c (1)", "Figure 8: inputs"),
        (panels[0, 1], system.outputs[0], "K (1)", "Figure 9: output"),
    ):
        for term in variable.terms:
            low, peak, high = term.parameters
            left = np.ones_like(x) if np.isinf(low) else np.clip((x - low) / (peak - low), 0.0, 1.0)
            right = np.ones_like(x) if np.isinf(high) else np.clip((high - x) / (high - peak), 0.0, 1.0)
            axes.plot(x, np.minimum(left, right), color=SETS[term.name])
            axes.text(peak, 1.04, term.name, ha="center", color=SETS[term.name])
        axes.set(xlabel=label, ylim=(0.0, 1.18), title=title)
    panels[0, 0].set_ylabel("membership (1)")
    s = np.linspace(-4.0, 4.0, 201)
    for rules, ratio, ink, line in (
        ("printed", 4.0, SKY, "--"), ("corrected", 4.0, GREEN, "-"), ("corrected", 1.0, ORANGE, "-"),
        ("without_dead_corner", 4.0, PURPLE, "-."),
    ):  # fmt: skip
        held = 120.0 * np.asarray(SYSTEMS[rules].many(s=s / 0.65, s_c=-s / (0.65 * ratio)))
        panels[0, 2].plot(s, held, color=ink, linestyle=line, label=f"{RULES[rules]}, S_c = {ratio:g} S")
    panels[0, 2].set(xlabel="s = −s_c = λ²ξ (rad/s)", ylabel="U K (N·m)", title="Figure 10: our scales, at rest")
    y = np.linspace(-1.25, 1.25, 81)
    for axes, (rules, words) in zip(panels[1], RULES.items(), strict=True):
        k = SYSTEMS[rules].many(s=y[None, :], s_c=y[:, None])
        shade = axes.pcolormesh(y, y, k, cmap="RdBu", vmin=-1.0, vmax=1.0, shading="auto", rasterized=True)
        axes.plot(y, -y, color=BLACK, linestyle="--")
        axes.plot(y, -y / 4.0, color=BLACK, linestyle="-.")
        axes.set(title=words, xlabel="s/S (1)", aspect="equal")
    panels[1, 0].set_ylabel("s_c/S_c (1)")
    fig.colorbar(shade, ax=list(panels[1]), label="K (1)", shrink=0.85)
    return with_legend(fig, panels[0, 2], columns=4)


# ---- section 6: Figures 11 to 14
ROWS = {"corrected.smc": "paper.smc", "paper.csmc": None, "corrected.fsmc": "paper.fsmc"}
"""The paper's three laws from the top, panels (a) to (f), and the printed law beside each."""


def draw_rows(lab: Lab, runs: dict[str, Any], seconds: float, title: str) -> tuple[Figure, Any]:
    """Errors and torques of the five laws: six panels."""
    fig, panels = grid(9.6, 7.6, 3, 2, sharex="col")
    fig.suptitle(title)
    for (law, beside), (left, right) in zip(ROWS.items(), panels, strict=True):
        for name in filter(None, (law, beside)):
            run, style = runs[name], pen(name) | {"linewidth": 1.5 if name == law else 0.9}
            left.plot(*thinned(run["time"], 1e6 * run["true_error"]), **style)
            right.plot(*thinned(run["time"], run["output"]), **style)
        left.set_ylabel("error (nm)")
        right.set_ylabel("torque (N·m)")
    for axes in panels[-1]:
        axes.set(xlabel="time (s)", xlim=(0.0, seconds))
    return fig, panels


@figure(
    "Figure 11: 1 mm in 50 ms. SMC keeps an error, CSMC one that takes minutes to go, FSMC none; the torque at rest "
    "bends the bristles under all three. Grey: FSMC with f̂ from the measured speed, whose torque has no mean at rest."
)
def fig11_step(lab: Lab) -> Figure:
    runs = {law: lab.run(law, "step_quintic") for law in LAWS}
    fig, panels = draw_rows(lab, runs, 0.6, "1 mm in 50 ms")
    free, style = settled_run(lab, "corrected.fsmc"), {"color": "0.6", "linewidth": 0.6, "zorder": 0}
    panels[2, 0].plot(*thinned(free["time"], 1e6 * free["true_error"]), label="f̂ from the measured speed", **style)
    panels[2, 1].plot(*thinned(free["time"], free["output"]), **style)
    return with_legend(fig, *panels[:, 0], columns=3)


def draw_sine(lab: Lab, scenario: str) -> Figure:
    runs = {law: sine_run(lab, law, scenario) for law in LAWS}
    fig, panels = draw_rows(lab, runs, SECONDS[scenario], str(SINES[scenario]))
    return with_legend(fig, *panels[:, 0], columns=3)


@figure("Figure 12: 0.01 sin t mm in continuous time. Left the true error, right the torque; each row has its scale.")
def fig12_slow_sine(lab: Lab) -> Figure:
    return draw_sine(lab, "sine_slow")


@figure("Figure 13: 5 sin t mm in continuous time. Left the true error, right the torque; each row has its scale.")
def fig13_wide_sine(lab: Lab) -> Figure:
    return draw_sine(lab, "sine_wide")


@figure("Figure 14: sin 2πt mm in continuous time. Left the true error, right the torque; dashed as printed.", key=True)
def fig14_fast_sine(lab: Lab) -> Figure:
    return draw_sine(lab, "sine_fast")


# ---- section 7: circles
def draw_circles(tests: dict[str, CircularTest], division: float | None = None) -> Figure:
    """Polar plots side by side, each with its own magnification unless there is a common division."""
    from matplotlib.lines import Line2D

    fig, panels = grid(3.8 * len(tests), 4.8, 1, len(tests), squeeze=False, subplot_kw={"projection": "polar"})
    for axes, (name, test) in zip(panels[0], tests.items(), strict=True):
        paths = centred(test)
        polar(axes, paths, division or division_um(max(float(np.abs(r).max()) for _, r in paths.values())), test)
        axes.set_title(f"{name}: G(b) {both(test).circular:.3f} µm\n{axes.get_title()}", fontsize="small")
        axes.set_xlabel("angle (°)")
    lines = [Line2D([], [], color=ink) for ink in COLOURS.values()]
    fig.legend(lines, [WORDS[d] for d in COLOURS], loc="outside lower center", ncols=2, frameon=False)
    return fig


@figure(
    "Circles of R = 5 mm at 300 mm/min by the paper's three laws in continuous time, as a double ball bar without "
    "error would draw them (Figure 16)."
)
def fig16_circles(lab: Lab) -> Figure:
    return draw_circles({law: circle_of(lab, law, CIRCLES["r5"]) for law in IDEAL})


@figure(
    "Stick motion (Figure 17): the axis stays at rest behind its reversal until its error has built up the torque to "
    "break away, on a circle of R = 5 mm at 300 mm/min; and its trace on the circle (Figure 18), clockwise in red."
)
def fig17_18_stick_motion(lab: Lab) -> Figure:
    from leadscrew.figures.figure import Figure

    fig = Figure(figsize=(9.6, 4.6), layout="constrained")
    place, trace = fig.add_subplot(1, 2, 1), fig.add_subplot(1, 2, 2, projection="polar")
    for law, ink in ((PID, ORANGE), (SLOW_FSMC, GREEN)):
        ms, command, table = around_reversal(lab, law, CIRCLES["r5"])
        place.plot(ms, table, color=ink, label=NAMES[law])
    place.plot(ms, command, label="command", **(GUIDE | {"color": BLACK}))
    place.set(xlabel="time from the commanded reversal (ms)", ylabel="distance from the end (µm)", title="X at its end")
    test = circle_of(lab, PID, CIRCLES["r5"])
    paths = centred(test)
    polar(trace, paths, division_um(max(float(np.abs(r).max()) for _, r in paths.values())), test)
    trace.set_title(f"{NAMES[PID]}\n{trace.get_title()}", fontsize="small")
    return with_legend(fig, place, columns=3)


PLAY = {
    "motor encoders, ours.pd_dob": ("ours.pd_dob", MOTOR, VERMILION, "--"),
    "linear encoders, ours.fsmc_4khz": ("ours.fsmc_4khz", TABLE, colour("ours.fsmc_4khz"), "-"),
    "both encoders, ours.pd_dob": ("ours.pd_dob", BOTH, colour("ours.pd_dob"), "-"),
}
"""Controller, lag of the table's reading, colour and line."""


@figure(
    "Figure 19: circle of 1 mm at 1 Hz with 2 µm of play on both axes. With motor encoders the step of half the play "
    "stays; with linear encoders it is compensated, which takes time and leaves peaks."
)
def fig19_compensated_reversal(lab: Lab) -> Figure:
    fig, axes = grid(8.4, 4.2)
    for words, (who, lag, ink, line) in PLAY.items():
        turn = circle(backlash_run(lab, who, "sine_fast", "play", lag), 1.0).ccw
        assert turn is not None
        degrees, deviation = np.degrees(turn.angle), turn.deviation_um(1.0)
        axes.plot(degrees, deviation, color=ink, linestyle=line, linewidth=1.1, label=words)
    for reversal in range(0, 361, 90):
        axes.axvline(reversal, **GUIDE)
    axes.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel="angle (°)", ylabel="radius less 1 mm (µm)")
    return with_legend(fig, axes, columns=3)


@figure(
    "Stick-slip (Figure 20): a circle so slow that each axis jerks where it is slower than a few µm/s. Grey: there."
)
def fig20_stick_slip(lab: Lab) -> Figure:
    fig, axes = grid(8.4, 4.0)
    test = slow_circle(lab)
    angle, deviation = centred(test)["ccw"]
    degrees = np.mod(np.degrees(angle), 360.0)
    order = np.argsort(degrees, kind="stable")
    axes.plot(degrees[order], deviation[order], color=GREEN, linewidth=1.0)
    for reversal in range(0, 361, 90):
        axes.axvspan(reversal - 14.5, reversal + 14.5, color="0.92", zorder=0)
    title = f"R = {test.radius_mm:g} mm at {test.feed_mm_min:g} mm/min, {NAMES[SLOW_FSMC]}"
    axes.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel="angle (°)", ylabel="radial deviation (µm)", title=title)
    return fig


@figure("Figure 21: circles of R = 1 mm by FSMC in continuous time at three feeds, and the radius under each law.")
def fig21_radius(lab: Lab) -> Figure:
    fig, (left, right) = grid(9.6, 4.4, 1, 2)
    for hz, ink, line in ((0.1, BLUE, "-"), (2.0, ORANGE, "--"), (5.0, VERMILION, "-.")):
        turn = circle_of(lab, "corrected.fsmc", Way(1.0, 2.0 * math.pi * hz)).ccw
        assert turn is not None
        degrees = np.mod(np.degrees(turn.angle), 360.0)
        order = np.argsort(degrees)
        left.plot(degrees[order], turn.deviation_um(1.0)[order], color=ink, linestyle=line, label=f"{hz:g} Hz")
    left.set(xlim=(0, 360), xticks=range(0, 361, 90), xlabel="angle (°)", ylabel="radial deviation (µm)", title="FSMC")
    left.legend(fontsize="small", frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.15))
    for name in IDEAL:
        right.plot(HZ, [radius_um(lab, name, hz) for hz in HZ], marker="o", markersize=4, **pen(name))
    right.axhline(0.0, **GUIDE)
    right.set(xscale="log", xlabel="turns per second (Hz)", ylabel="D, change of the radius (µm)", title="R = 1 mm")
    right.set_yscale("symlog", linthresh=0.01)
    right.set_xticks(HZ, [f"{hz:g}" for hz in HZ])
    return with_legend(fig, right, columns=4)
