"""The study's figures: its moves, the universes along them, the old servo, sensors, limits, positioning."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.controllers._vud import universe
from leadscrew.controllers._vud.power_law import power_law
from leadscrew.figures.panels import grid, with_legend
from leadscrew.figures.positioning import draw as draw_positioning
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
from leadscrew.identify.heydemann import fit_ellipse
from leadscrew.sensors.grating import _counting as counting
from leadscrew.sensors.grating._moire import GRATING
from leadscrew.sensors.grating._quadrature import first_order_error, interpolation_error, quadrature
from leadscrew.studies.exhibits import figure
from leadscrew.studies.lab import Lab
from leadscrew.studies.vud_lathe import curvature, limits
from leadscrew.studies.vud_lathe.axes import errors_um, spread
from leadscrew.studies.vud_lathe.iso_230_2 import run_test
from leadscrew.studies.vud_lathe.laws import FLOOR, FULL_SCALE_MM, LABELS, SEED, SETS, TAU, TRIAL, moves
from leadscrew.studies.vud_lathe.old_servo import play
from leadscrew.studies.vud_lathe.scenarios import PERIOD_S, STEPS, TABLE_1_STEPS, Step

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure
    from leadscrew.fuzzy.partition import Partition
    from leadscrew.kernel.run import Run

PAPER, CORRECTED, OLD, PD = "paper.vud", "corrected.vud_beta_e", "ours.original_fit", "ours.pd"
# A line that only guides the eye: a limit, a target.
GUIDE: dict[str, Any] = {"color": "0.5", "linewidth": 0.8, "linestyle": ":", "zorder": 0}
# What the paper measured.
POINTS: dict[str, Any] = {"color": BLACK, "linestyle": "none", "marker": "o", "markersize": 3.5}
SET_COLOURS = dict(zip(LABELS, (PURPLE, BLUE, SKY, GREEN, ORANGE, VERMILION), strict=True))
UNIVERSE_TICKS = (-1.0, -0.1, -0.01, 0.0, 0.01, 0.1, 1.0)


# ---- what several figures share
def signed(value: float, position: int | None = None, form: str = ",g") -> str:
    """A number with the minus of print; also a formatter of ticks, for scales whose powers have small exponents."""
    return f"{value:z{form}}".replace("-", "−")


def symmetric_log(axes: Any, *which: str) -> None:
    """Both signs of a universe on a logarithmic scale, linear within 0.001."""
    for name in which:
        getattr(axes, f"set_{name}scale")("symlog", linthresh=1e-3)
        axes.set(
            **{
                f"{name}ticks": UNIVERSE_TICKS,
                f"{name}ticklabels": map(signed, UNIVERSE_TICKS),
                f"{name}lim": (-1.5, 1.5),
            }
        )


def draw_run(
    axes: Any, run: Run, controller: str, values: np.ndarray, since: float = 0.0, until: float = 2.0, **more: Any
) -> None:
    shown = (run.time >= since) & (run.time <= until)
    axes.plot(run.time[shown], values[shown], **{**pen(controller), **more})


def draw_sets(axes: Any, sets: Partition, low: float = 0.0, named: bool = True) -> None:
    """Fuzzy sets: straight lines between their centres; ``low`` is where a membership of 0 stands."""
    x = np.array(sets.centres)
    for centre, label, membership in zip(x, sets.labels, sets.memberships(x).T, strict=True):
        axes.plot(x, low + membership, color=SET_COLOURS[label], linewidth=1.3, label=label)
        if named:
            axes.text(centre, low + 1.03, label, ha="center", fontsize="small", color=SET_COLOURS[label])


# ---- the steps of Figures 11 and 12
def draw_step(lab: Lab, step: Step) -> Figure:
    fig, axes = grid(7.0, 4.0)
    for controller in (PAPER, CORRECTED, OLD):
        run = limits.tried_on(lab, controller, step.scenario, "linear")
        draw_run(axes, run, controller, run["actual.position"])
    axes.axhline(-step.way_mm, **GUIDE)
    axes.plot([step.near_s] * 2, [0.0, -step.way_mm], **pen("paper says", f"paper: near target at {step.near_s:g} s"))
    axes.set(xlabel="time (s)", ylabel="true position (mm)", title=f"Step to {step}")
    return with_legend(fig, axes)


@figure("Step to −50 mm (Figure 11 a).")
def fig11a_position_m50(lab: Lab) -> Figure:
    return draw_step(lab, STEPS["m50"])


@figure("Step to −170 mm (Figure 11 b).", key=True)
def fig11b_position_m170(lab: Lab) -> Figure:
    return draw_step(lab, STEPS["m170"])


@figure("True error after 2 s (Figure 12).")
def fig12_error(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 4.0, 1, 2)
    for axes, step in zip(panels, STEPS.values(), strict=True):
        for controller in (CORRECTED, f"{CORRECTED}_half", OLD):
            run = lab.run(controller, step.scenario)
            draw_run(axes, run, controller, 1000.0 * run["true_error"], since=2.0, until=4.0)
        for band in (-2.0, 2.0):
            axes.axhline(band, **pen("paper says", "paper: VUD within 2 µm"))
        printed = limits.tried_on(lab, PAPER, step.scenario, "linear").metrics["error_after_2s"]
        axes.annotate(
            f"{PAPER}: still up to {printed:.0f} mm away",
            xy=(0.98, 0.03),
            xycoords="axes fraction",
            ha="right",
            color=colour(PAPER),
        )
        axes.set(xlabel="time (s)", ylabel="true error (µm)", title=f"Step to {step}", ylim=(-2.9, 2.9))
    return with_legend(fig, *panels)


@figure("The printed law on its whole way: a creep at 6 mm/s.")
def creep(lab: Lab) -> Figure:
    fig, axes = grid(7.0, 4.0)
    for step in STEPS.values():
        for controller in (PAPER, CORRECTED):
            run = limits.tried_on(lab, controller, step.scenario, "linear")
            axes.plot(run.time[::20], run["actual.position"][::20], **pen(controller))
    run = limits.tried_on(lab, PAPER, STEPS["m170"].scenario, "linear")
    first, last = np.interp((3.0, 5.0), run.time, run["actual.position"])
    axes.set(
        xlabel="time (s)",
        ylabel="true position (mm)",
        title=f"The printed law creeps: {abs(last - first) / 2.0:.2f} mm/s",
    )
    return with_legend(fig, axes)


# ---- universes and sets
@figure("How the universes of e and ec shrink.")
def universes(lab: Lab) -> Figure:
    fig, panels = grid(7.0, 5.6, 2, 1, sharex=True)
    run = lab.run(CORRECTED, STEPS["m50"].scenario)
    shown = run.time <= 1.2
    for axes, name in zip(panels, ("e", "ec"), strict=True):
        alpha = run[f"controller.alpha_{name}"][shown]
        axes.fill_between(run.time[shown], -alpha, alpha, color=BLUE, alpha=0.2, lw=0, label=f"universe of {name}")
        axes.plot(run.time[shown], run[f"controller.{name}"][shown], color=ORANGE, label=name)
        symmetric_log(axes, "y")
        axes.set_ylabel(f"{name} (1)")
        axes.legend(frameon=False, loc="upper right")
    panels[0].set_title(f"{CORRECTED}, step to {STEPS['m50']}")
    panels[1].set_xlabel("time (s)")
    return fig


@figure("e and ec, and the universes around them at the times that are written beside them.")
def phase(lab: Lab) -> Figure:
    from matplotlib.patches import Rectangle

    fig, panels = grid(9.0, 5.2, 1, 2)
    times = {PAPER: (3.0, 7.0, 8.0, 10.0), CORRECTED: (0.05, 0.6, 0.8, 1.15)}
    for axes, controller in zip(panels, times, strict=True):
        run = limits.tried_on(lab, controller, STEPS["m50"].scenario, "linear")
        e, ec = run["controller.e"], run["controller.ec"]
        until = round((times[controller][-1] + 0.2) / PERIOD_S)
        axes.plot(e[:until], ec[:until], color=colour(controller), linewidth=0.9)
        for t in times[controller]:
            k = round(t / PERIOD_S)
            half_e, half_ec = run["controller.alpha_e"][k], run["controller.alpha_ec"][k]
            axes.add_patch(Rectangle((-half_e, -half_ec), 2 * half_e, 2 * half_ec, fill=False, color="0.45", lw=0.8))
            axes.plot(e[k], ec[k], "o", color=colour(controller), markersize=3.5)
            beside, side = ((-1, 2), "right") if half_e > 0.002 else ((2, -9), "left")
            axes.annotate(f"{t:g} s", (half_e, -half_ec), beside, textcoords="offset points", ha=side, fontsize="small")
        symmetric_log(axes, "x", "y")
        axes.tick_params(axis="x", labelsize="small")
        axes.set(xlabel="e (1)", ylabel="ec (1)", title=controller)
    return fig


@figure("The six sets of e, ec and the duty (Figures 6 to 8).")
def fig6_8_sets(lab: Lab) -> Figure:
    fig, axes = grid(7.0, 2.8)
    draw_sets(axes, SETS)
    axes.axvspan(-0.33, 0.33, color="0.93", zorder=0)
    axes.text(0.0, 1.17, "no set at zero: gap 0.66 against 0.34", ha="center", fontsize="small")
    axes.set(xlabel="e, ec, duty (1)", ylabel="membership (1)", ylim=(0.0, 1.3))
    return fig


@figure("The sets contracted for the worked example (Figures 9 and 10).")
def fig9_10_sets(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 3.0, 1, 2)
    for axes, name, value in zip(panels, ("e", "ec"), (-0.25, 0.12), strict=True):
        reach = universe.contraction(value, TAU, FLOOR, 1.0)
        draw_sets(axes, SETS.contracted(reach))
        axes.axvline(value, color=BLACK, linestyle=":", linewidth=1.0)
        axes.set(
            xlabel=f"{name} (1)",
            ylabel="membership (1)",
            ylim=(0.0, 1.15),
            title=f"{name} = {signed(value)} in [−{reach:.4f}, {reach:.4f}]",
        )
    return fig


@figure("Our stand-in for the original servo against Table 1.")
def table1_fit(lab: Lab) -> Figure:
    fig, axes = grid(7.0, 4.0)
    for move, scenario in zip(moves().values(), TABLE_1_STEPS.values(), strict=True):
        run = lab.run(OLD, scenario)
        draw_run(axes, run, OLD, run["true_error"] / FULL_SCALE_MM)
        axes.plot(move.time_s, move.error, **POINTS, label="Table 1")
    axes.set(xlabel="time (s)", ylabel="normalised error e (1)")
    return with_legend(fig, axes)


@figure("Error on commands with limited acceleration and jerk.")
def gentle_moves(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 4.0, 1, 2)
    titles = {"trapezoid_m170": "trapezoid to −170 mm", "s_curve_m170": "S-curve to −170 mm"}
    for axes, scenario in zip(panels, titles, strict=True):
        for controller in (CORRECTED, PD):
            run = lab.run(controller, scenario)
            draw_run(axes, run, controller, run["true_error"])
        axes.set(xlabel="time (s)", ylabel="true error (mm)", title=titles[scenario])
    return with_legend(fig, *panels)


@figure(
    f"The sets of e and ec along the step to −50 mm under {CORRECTED}: at k = 600 they are those that Figures 9 and 10 "
    "mean to show, with the state that the simulation has there."
)
def contraction(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 6.6, 1, 2, sharey=True)
    run, instants_s = lab.run(CORRECTED, STEPS["m50"].scenario), (0.0, 0.1, 0.2, 0.3, 0.45, 0.6)
    for axes, name in zip(panels, ("e", "ec"), strict=True):
        for row, t in enumerate(reversed(instants_s)):
            k, low = round(t / PERIOD_S), 1.5 * row
            value, reach = run[f"controller.{name}"][k], run[f"controller.alpha_{name}"][k]
            draw_sets(axes, SETS.contracted(reach), low, named=False)
            axes.plot([value] * 2, [low, low + 1.0], color=BLACK, linestyle=":", linewidth=1.4)
            axes.axhline(low, color="0.8", linewidth=0.6, zorder=0)
            state = f"{name} = {signed(value, form='.2g')} in ±{reach:.2g}"
            axes.text(0.0, low + 1.1, f"k = {k}: {state}", ha="center", fontsize="small")
        axes.set(xlabel=f"{name} (1)", xlim=(-0.6, 0.6), ylim=(-0.05, 1.5 * len(instants_s)))
    panels[0].set_yticks(
        [1.5 * row + end for row in range(len(instants_s)) for end in (0, 1)], ["0", "1"] * len(instants_s)
    )
    panels[0].set_ylabel("membership (1), a row an instant")
    fig.suptitle(f"{CORRECTED}: the universes shrink around the state (dotted)")
    return with_legend(fig, panels[0], columns=6)


# ---- the old servo, and the circuit of Figure 5 on it
@figure("Laws fitted to the errors of Table 1: errors, what is left, and the duty that no fit saw.")
def original_fits(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 8.0, 3, 2, sharex=True, sharey="row")
    laws = {
        "p_289": (VERMILION, ":", "P at 289 mm/s"),
        "pid_209": (GREEN, "--", "PID at 209 mm/s"),
        "power_289": (ORANGE, "-", "c |e|^p at 289 mm/s"),
        "power_216": (BLUE, "-.", "c |e|^p at 216 mm/s"),
    }
    for (top, middle, bottom), move in zip(panels.T, (moves()[f"r=-{way}"] for way in (190, 50)), strict=True):
        way, at = abs(move.error[0]), np.rint(move.time_s / PERIOD_S).astype(int)
        for law, (color, line, label) in laws.items():
            played = play(lab, law)
            error = played.error_mm(move.target_mm) / FULL_SCALE_MM
            shown, style = played.time_s <= move.time_s[-1], {"color": color, "linestyle": line, "linewidth": 1.4}
            top.plot(played.time_s[shown], error[shown] / way, label=label, **style)
            middle.plot(move.time_s, 100.0 * (error[at] - move.error) / way, marker=".", **style)
            bottom.plot(played.time_s[shown], played.duty[played.row(move.target_mm)][shown], **style)
        top.plot(move.time_s, move.error / way, **POINTS, label="Table 1")
        bottom.plot(move.time_s[1:], move.duty[1:], **POINTS)
        middle.axhline(0.0, **GUIDE)
        top.set_title(f"move r = {signed(move.target_mm)} mm")
        bottom.set_xlabel("time (s)")
    for axes, label in zip(panels[:, 0], ("error over way (1)", "law minus table (% of way)", "duty (1)"), strict=True):
        axes.set_ylabel(label)
    return with_legend(fig, panels[0, 0], columns=3)


@figure("What the circuit of Figure 5 reads along a move, beside the second derivative that it is said to show.")
def fig5_differentiator(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 4.0, 1, 2, sharey=True)
    size, smooth, old = np.geomspace(0.02, 1.0, 200), curvature.step_run(-190.0, 6.0), power_law.params
    cases = {
        "cubic, known curvature": (curvature.TRUE[0] * size, (smooth.time, smooth.e, smooth.ec, smooth.duty)),
        OLD: (
            curvature.power_curvature(size, old.gain, old.exponent),
            curvature.signals(lab.run(OLD, TABLE_1_STEPS["r=-190"])),
        ),
    }
    for axes, (title, (true, signals)) in zip(panels, cases.items(), strict=True):
        read = curvature.scope(*signals)
        shown = (np.abs(read.e) >= size[0]) & (read.time > 3.0 * curvature.STAGE_LAG_S)
        axes.plot(abs(read.e)[shown], read.over_e[shown], color=ORANGE, lw=1.2, label="circuit: (d²u/dt²) / (d²e/dt²)")
        axes.plot(size, true, color=BLUE, linewidth=1.6, label="|∂²u/∂e²|")
        axes.axhline(curvature.TRUE[0], **pen("paper says", f"paper, (8): {curvature.TRUE[0]}"))
        axes.set(
            xscale="log",
            yscale="log",
            title=title,
            xlim=(1.2, 0.017),
            ylim=(0.02, 300.0),
            xlabel="|e| (1), the move runs to the right",
        )
        axes.xaxis.set_major_formatter(signed)
        axes.yaxis.set_major_formatter(signed)
    panels[0].set_ylabel("size of the second derivative (1)")
    return with_legend(fig, panels[0], columns=3)


# ---- the grating ruler
@figure("Grating ruler on a travel with a reversal: the slide, the two signals, the eight comparators, the count.")
def grating_count(lab: Lab) -> Figure:
    time_ms = np.linspace(0.0, 10.0, 1001)
    there, back = np.clip(time_ms / 6.0, 0.0, 1.0), np.clip((time_ms - 6.0) / 4.0, 0.0, 1.0)
    x_mm = 0.018 * there**2 * (3.0 - 2.0 * there) - 0.012 * back**2 * (3.0 - 2.0 * back)
    u, v = quadrature(x_mm)
    code, count_um = counting.comparators(u, v), 1000.0 * GRATING.resolution_mm
    fig, panels = grid(7.0, 6.4, 3, 1, sharex=True, height_ratios=(1.0, 1.5, 1.4))
    panels[0].plot(time_ms, u, color=BLUE, label="u")
    panels[0].plot(time_ms, v, color=ORANGE, linestyle="--", label="v")
    panels[0].set(ylabel="signal (1)", title=f"One count is {count_um:g} µm")
    for i, bit in enumerate(code.T):
        panels[1].step(time_ms, i + 0.7 * bit, where="post", color=BLACK, linewidth=0.9)
    panels[1].set(yticks=np.arange(8) + 0.35, yticklabels=[f"w{i}" for i in range(8)], ylabel="comparators, 0 or 1 (1)")
    x_um = count_um * counting.counts(counting.sectors(code))
    panels[2].step(time_ms, x_um, where="post", color=GREEN, label="count")
    panels[2].plot(time_ms, 1000.0 * x_mm, color=VERMILION, linestyle=":", label="slide")
    panels[2].set(ylabel="position (µm)", xlabel="time (ms)")
    panels[2].annotate("reversal", (6.0, 1.0), textcoords="offset points", xytext=(4, 0), fontsize="small", color="0.4")
    for axes in panels:
        axes.axvline(6.0, **GUIDE)
    for axes in (panels[0], panels[2]):
        axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return fig


@figure("Signals with errors before and after Heydemann's correction, and the error of position over a pitch.")
def grating_heydemann(lab: Lab) -> Figure:
    x_mm = GRATING.pitch_mm * np.arange(1000) / 1000
    u, v = quadrature(x_mm, errors=TRIAL, noise=0.005, seed=SEED)
    fig, (left, right) = grid(8.4, 4.4, 1, 2, width_ratios=(1.0, 1.35))
    dots = {"linestyle": "none", "marker": ".", "markersize": 2.0}
    cases = {"before": (VERMILION, 3, (u, v)), "after": (BLUE, 4, fit_ellipse(u, v).corrected(u, v))}
    for name, (color, digits, (sine, cosine)) in cases.items():
        error_um = 1000.0 * interpolation_error(x_mm, sine, cosine)
        left.plot(cosine, sine, color=color, **dots)
        rms = f"{error_um.std():.{digits}f} µm rms about the mean"
        right.plot(1000.0 * x_mm, error_um, color=color, label=f"{name}: {rms}", **dots)
    first_um = 1000.0 * first_order_error(x_mm, errors=TRIAL)
    right.plot(1000.0 * x_mm, first_um, color=BLACK, linewidth=1.0, label="first-order formula")
    left.axhline(0.0, **GUIDE)
    left.axvline(0.0, **GUIDE)
    left.set(xlabel="v, in amplitudes of u (1)", ylabel="u, in amplitudes of u (1)", aspect="equal")
    right.set(xlabel="position in the pitch (µm)", ylabel="error of position (µm)")
    return with_legend(fig, right, columns=2, markerscale=4.0)


# ---- many axes, limits, the positioning test
@figure(
    "Sensor and controller, two by two: share of 200 drawn axes whose error after 2 s stays below a value. Only the "
    "grating with the new controller is inside 2 µm on all of them."
)
def two_by_two(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 5.6, 2, 2, sharex=True, sharey=True)
    ticks, laws = (0.01, 0.1, 1.0, 2.0, 10.0), {OLD: "old controller", CORRECTED: "corrected VUD"}
    for axes, (controller, sensor) in zip(panels.flat, product(laws, ("encoder", "grating")), strict=True):
        for step, line in zip(STEPS.values(), ("-", "--"), strict=True):
            errors = np.sort(errors_um(lab, controller, step.scenario, sensor))
            share = 100.0 * np.arange(1, len(errors) + 1) / len(errors)
            label = f"{step}: 95 % below {spread(errors).p95:.2g} µm"
            axes.step(errors, share, line, where="post", color=colour(controller), label=label)
        for limit in (2.0, 10.0):
            axes.axvline(limit, **GUIDE)
        where = {"encoder": "encoder on the screw", "grating": "grating on the table"}[sensor]
        axes.set(xscale="log", xticks=ticks, xticklabels=map(signed, ticks), xlim=(0.005, 20.0))
        axes.set(
            title=f"{laws[controller]}, {where}", xlabel="largest error after 2 s (µm)", ylabel="share of axes (%)"
        )
        axes.label_outer()
        axes.legend(edgecolor="none", loc="upper left" if errors[-1] > 2.0 else "lower right", fontsize="small")
    return fig


def armature_current(run: Run, machine: str) -> np.ndarray:
    """Armature current in A; of the linear chain what its acceleration takes, ``T_s U_s / (K_v R) dv/dt``."""
    if machine == "limited":
        return np.asarray(run["plant.current"])
    axis = limits.AXIS
    slope_s = (run["plant.current"] - run["plant.speed"]) * (1.0 + axis.electrical_lag_s / axis.mechanical_lag_s)
    return np.asarray(slope_s * axis.supply_v / (axis.full_duty_speed_mm_s * axis.resistance_ohm))


@figure(
    "The step to −170 mm on the linear and on the limited axis: error, speed and current of the fastest move that "
    "there is, of the corrected VUD law, a PD controller and our fastest."
)
def fastest_move_m170(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 7.2, 3, 2, sharex=True, sharey="row")
    step, axis, fast = STEPS["m170"], limits.AXIS, {"linear": "ours.vud_fast", "limited": "ours.vud_fast_limited"}
    for (error, speed, current), machine in zip(panels.T, fast, strict=True):
        for name in (CORRECTED, PD, fast[machine]):
            run = limits.tried_on(lab, name, step.scenario, machine)
            away_um = np.maximum(1000.0 * np.abs(run["true_error"]), 1e-2)
            values = (away_um, np.abs(run["plant.speed"]), -armature_current(run, machine))
            for axes, drawn in zip((error, speed, current), values, strict=True):
                draw_run(axes, run, name, drawn, until=1.8, linewidth=1.1)
        best = limits.played(lab, step.way_mm, machine == "limited")
        style = {"color": VERMILION, "linestyle": "-.", "linewidth": 1.3, "label": "fastest move (bound)"}
        values = (np.maximum(np.abs(best.error_um), 1e-2), np.abs(best.speed), best.current)
        for axes, drawn in zip((error, speed, current), values, strict=True):
            axes.plot(best.time, drawn, **style)
        error.axhline(2.0, **GUIDE)
        bound_s = limits.bound(lab, step.way_mm, machine == "limited").time_s
        error.set(yscale="log", title=f"{machine} axis: bound {bound_s:.3f} s")
        if machine == "limited":
            speed.axhline(axis.top_speed_mm_s, **GUIDE)
            for side in (-1.0, 1.0):
                current.axhline(side * axis.current_limit_a, **GUIDE)
        current.set_xlabel("time (s)")
    for axes, label in zip(panels[:, 0], ("distance from target (µm)", "speed (mm/s)", "current (A)"), strict=True):
        axes.set_ylabel(label)
    panels[0, 0].yaxis.set_major_formatter(signed)
    return with_legend(fig, *panels[0], columns=3)


@figure(
    "Where controllers stand after a step to −50 mm on the limited axis: with duties in whole counts of a PWM timer, "
    "and with the remainder of each period carried into the next."
)
def pwm_rest(lab: Lab) -> Figure:
    fig, panels = grid(8.4, 3.8, 1, 2, sharey=True)
    scenario = STEPS["m50"].scenario
    for name in (CORRECTED, PD):
        runs = limits.tried_on(lab, name, scenario, "limited"), limits.with_timer(lab, name, scenario, "carry", True)
        for axes, run in zip(panels, runs, strict=True):
            draw_run(axes, run, name, 1000.0 * run["true_error"], linewidth=1.1)
        quiet_um, label = limits.standing_um(name, 0.5 / 1000.0), f"{name}: asks for less than half a count"
        panels[0].axhspan(-quiet_um, quiet_um, color=colour(name), alpha=0.12, linewidth=0, label=label)
    for axes, title in zip(panels, ("duty in whole counts of 1,000", "remainder carried over"), strict=True):
        for side in (-2.0, 2.0):
            axes.axhline(side, **GUIDE)
        axes.set(xlabel="time (s)", xlim=(0.2, 2.0), ylim=(-6.0, 6.0), title=title)
    panels[0].set_ylabel("true error (µm)")
    return with_legend(fig, *panels)


@figure(
    "Positioning test of ISO 230-2, simulated: true deviations of the table behind the encoder, behind the encoder "
    "with the compensation table of the first test, and behind the grating (each panel has its own scale)."
)
def iso_230_2(lab: Lab) -> Figure:
    fig, panels = grid(9.0, 4.2, 1, 3)
    cases = {
        "encoder": run_test(lab, "encoder"),
        "encoder, compensated": run_test(lab, "encoder", compensated=True),
        "grating": run_test(lab, "grating"),
    }
    for axes, (title, test) in zip(panels, cases.items(), strict=True):
        assert test.both is not None
        draw_positioning(axes, test)
        result = f"A = {test.both.accuracy:.2g} µm, R = {test.both.repeatability:.2g} µm"
        axes.set(title=f"{title}\n{result}", ylabel="deviation (µm)" if axes is panels[0] else "")
    return with_legend(fig, panels[0], columns=3)
