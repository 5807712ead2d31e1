"""Images of the pages on learned and on identified friction, drawn from runs of the study ``fsmc_ballscrew``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadscrew import resolve
from leadscrew.analysis.circular.paths import CircularTest
from leadscrew.analysis.friction import friction_along, friction_velocity
from leadscrew.figures.panels import grid, with_legend
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION, pen
from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction import FrictionFit, fit_friction
from leadscrew.plants import TRAVEL_MM_PER_RAD
from leadscrew.references._friction_test import ROWS
from leadscrew.report.ballbar import CIRCLE, centred, division_um
from leadscrew.studies.fsmc_ballscrew.circles import CIRCLES, circle_of
from leadscrew.studies.fsmc_ballscrew.figures import GUIDE, draw_circles, thinned
from leadscrew.studies.fsmc_ballscrew.learned import BEFORE, OURS, SECONDS, by_reversal_um, half_period_s, learned_run
from leadscrew.studies.fsmc_ballscrew.records import record_loop
from leadscrew.studies.fsmc_ballscrew.scenarios import PERIOD_S, SINES
from leadscrew.studies.fsmc_ballscrew.tracking import largest_um, sampled_error_um
from leadscrew.studies.lab import Lab

# ---- learned on the way
NEAR = {"sine_slow": 1.5, "sine_wide": 0.03, "sine_fast": 0.012}
"""Time on both sides of a reversal that is drawn on the right, s."""


def learned_parameters(lab: Lab) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time in s, and by name what is learned on the fast sine over the stage's parameter."""
    periods = round(SECONDS["sine_fast"] / PERIOD_S)
    run = lab.loop(OURS, "sine_fast").start().advance(periods, record=("controller",), every=4)
    truth = LuGre()
    return run.time, {
        "F_C": run["controller.coulomb"] / truth.coulomb,
        "σ₀": run["controller.coulomb"] / run["controller.bend"] / truth.stiffness,
        "σ₁": run["controller.bristle_damping"] / truth.damping,
        "σ₂": run["controller.viscous"] / truth.viscous,
    }


def around(error: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Time in s from the reversal with the largest error of the second half, and half a period to both sides.

    A reversal at the negative end is drawn with its error turned round, as if it were at the positive one.
    """
    half = 0.5 * period
    worst = len(error) // 2 + int(np.abs(error[len(error) // 2 :]).argmax())
    reversal = math.floor(worst * PERIOD_S / half)
    t = np.arange(len(error)) * PERIOD_S - (reversal + 0.5) * half
    inside = (np.abs(t) <= half) & (np.arange(len(error)) >= len(error) // 2)
    return t[inside], (1.0 if reversal % 2 == 0 else -1.0) * error[inside]


def learned_sines(lab: Lab) -> Figure:
    fig, panels = grid(9.6, 7.2, 3, 2, sharey="row", width_ratios=(3, 2))
    for (left, right), scenario in zip(panels, SINES, strict=True):
        largest = []
        learned = 1e3 * learned_run(lab, scenario)["true_error"]
        for name, error in ((BEFORE, sampled_error_um(lab, BEFORE, scenario)), (OURS, learned)):
            largest.append(np.abs(error[len(error) // 2 :]).max())
            t, e = around(error, 2.0 * half_period_s(scenario))
            near = np.abs(t) <= NEAR[scenario]
            left.plot(*thinned(t, e), linewidth=0.8, **pen(name))
            right.plot(*thinned(1e3 * t[near], e[near]), linewidth=1.0, **pen(name))
        left.set_title(f"{SINES[scenario]}: largest {largest[0]:.3f} and {largest[1]:.3f} µm", loc="left")
        left.set_ylabel("true error (µm)")
    panels[-1, 0].set_xlabel("time from the reversal (s)")
    panels[-1, 1].set_xlabel("time from the reversal (ms)")
    return with_legend(fig, panels[0, 0])


def learned_way(lab: Lab) -> Figure:
    fig, (above, below) = grid(7.4, 7.0, 2, 1)
    for scenario, ink, mark in (("sine_wide", BLUE, "s"), ("sine_fast", BLACK, "o")):
        peaks = by_reversal_um(lab, scenario)
        above.semilogy(np.arange(1, len(peaks) + 1), peaks, color=ink, marker=mark, markersize=4,
                       label=f"learning, {SINES[scenario]}")  # fmt: skip
        before = largest_um(lab, BEFORE, scenario)
        above.axhline(before, color=ink, linestyle="--", linewidth=1.0, label=f"{BEFORE}, {SINES[scenario]}")
    above.set(xlabel="reversal (1)", ylabel="largest error around it (µm)")
    t, found = learned_parameters(lab)
    for (name, values), ink, line in zip(
        found.items(), (BLUE, VERMILION, GREEN, ORANGE), ("-", "--", "-.", ":"), strict=True
    ):
        below.semilogx(*thinned(t, values), color=ink, linestyle=line, label=name)
    below.axhline(1.0, **GUIDE)
    below.set(xlabel="time on sin 2πt mm (s)", ylabel="learned over true (1)", xlim=(t[1], t[-1]))
    for axes in (above, below):
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    return fig


TURNS = 5.0
"""Of the circle; the last one counts."""


def learned_circle(lab: Lab, name: str) -> CircularTest:
    """R = 100 mm at 1,000 mm/min, counter-clockwise: five turns to learn in, one and a quarter for others."""
    return circle_of(lab, name, CIRCLES["r100"], turns=TURNS if name == OURS else 1.25)


def learned_circle_r100(lab: Lab) -> Figure:
    tests = {name: learned_circle(lab, name) for name in (BEFORE, OURS)}
    paths = [centred(test).values() for test in tests.values()]
    division = max(division_um(max(float(np.abs(r).max()) for _, r in p)) for p in paths)
    fig = draw_circles(tests, division)
    axes: Any
    for axes in fig.axes:
        axes.set_rlim(0.0, CIRCLE + max(float(r.max()) for p in paths for _, r in p) / division + 0.6)
    return fig


# ---- identified from a record
UM_PER_RAD = 1e3 * TRAVEL_MM_PER_RAD
SLOW_FROM = sum(periods / frequency for _, frequency, periods in ROWS[:2])
"""When the rows of some um begin, s."""
LOOP_UM, LOOP_HZ = 0.25, 0.25
"""Amplitude and rate of the imposed pre-sliding loop: it creeps at some v_s / 4, where static friction matters."""
PENS: dict[str, dict[str, Any]] = {
    "truth": {"color": BLACK, "linewidth": 3.2, "alpha": 0.35},
    "test": {"color": BLUE, "linewidth": 1.3, "label": "found from the friction test, 7.5 s"},
    "sines": {"color": VERMILION, "linewidth": 1.3, "linestyle": "--", "label": "found from 5 sin t + sin 2 pi t mm"},
}
NAMES = {"stiffness": r"$\sigma_0$", "damping": r"$\sigma_1$", "viscous": r"$\sigma_2$", "coulomb": "$F_C$",
         "static": "$F_S$", "stribeck_speed": "$v_s$"}  # fmt: skip


def identified(kind: str) -> FrictionFit:
    """Friction from a record: torque and reading of the scale, nothing else."""
    loop, seconds = record_loop(kind)
    run = loop.run(seconds, record=("output", "feedback"))
    return fit_friction(run.time, run["output"], run["feedback"] / TRAVEL_MM_PER_RAD)


def friction_test_record() -> Figure:
    """Command, position and torque of the friction test."""
    loop, seconds = record_loop("test")
    run = loop.run(seconds, record=("command.position", "output", "feedback"))
    t, command, reading, torque = run.time, run["command.position"], run["feedback"], run["output"]
    small = t >= SLOW_FROM
    figure = Figure(figsize=(10.4, 5.4), layout="constrained")
    (place, near), (push, slow) = figure.subplots(2, 2, sharex="col", width_ratios=(1, 1.3))
    place.plot(t, command, color=BLACK, linestyle=":", label="command")
    place.plot(t, reading, color=BLUE, linewidth=1.0, label="position, as the scale reads")
    push.plot(t, torque, color=VERMILION, linewidth=1.0, label="torque")
    near.plot(t[small], 1e3 * command[small], color=BLACK, linestyle=":")
    near.plot(t[small], 1e3 * reading[small], color=BLUE, linewidth=1.0)
    slow.plot(t[small], torque[small], color=VERMILION, linewidth=1.0)
    place.set(ylabel="position (mm)", title="all of it")
    near.set(ylabel="position (µm)", title="its slow and its short part")
    push.set(ylabel="torque (N·m)", xlabel="time (s)")
    slow.set(ylabel="torque (N·m)", xlabel="time (s)")
    return with_legend(figure, place, push, columns=3)


def friction_fit() -> Figure:
    """Stribeck curve, pre-sliding loop, and errors by parameter."""
    found = {kind: identified(kind) for kind in ("test", "sines")}
    models = {"truth": LuGre(), "test": found["test"].friction, "sines": found["sines"].friction}
    figure = Figure(figsize=(12.0, 4.4), layout="constrained")
    stribeck, loop, share = figure.subplots(1, 3)
    speeds = np.geomspace(1e-5, 10.0, 400)
    t = np.arange(0.0, 1.25 / LOOP_HZ, 1e-4)
    path = LOOP_UM / UM_PER_RAD * np.sin(2.0 * math.pi * LOOP_HZ * t)
    for kind, model in models.items():
        look = {"label": "truth"} | PENS[kind]
        stribeck.semilogx(UM_PER_RAD * speeds, friction_velocity(model, speeds), **look)
        loop.plot(UM_PER_RAD * path, friction_along(model, path, 1e-4), **look)
    stribeck.set(xlabel="steady speed (µm/s)", ylabel="friction (N·m)", title="sliding (Stribeck curve)")
    loop.set(xlabel="travel (µm)", ylabel="friction (N·m)",
             title=f"before sliding: ±{LOOP_UM:g} µm at {LOOP_HZ:g} Hz")  # fmt: skip
    _errors(share, found)
    return with_legend(figure, stribeck, columns=3)


def _errors(axes: Axes, found: dict[str, FrictionFit]) -> None:
    """Size of found less true, and the fit's own standard error, in per cent of the truth."""
    truth = LuGre()
    for shift, (kind, mark) in zip((-0.15, 0.15), (("test", "o"), ("sines", "s")), strict=True):
        off, doubt = [], []
        for name in NAMES:
            true = getattr(truth, name)
            off.append(100.0 * abs(getattr(found[kind].friction, name) / true - 1.0))
            doubt.append(100.0 * found[kind].standard_error[name] / true)
        place = np.arange(len(NAMES)) + shift
        axes.semilogy(place, off, color=PENS[kind]["color"], marker=mark, linestyle="none")
        known = np.isfinite(doubt)
        axes.semilogy(place[known], np.array(doubt)[known], color=PENS[kind]["color"], marker="_", markersize=14,
                      markeredgewidth=1.6, linestyle="none")  # fmt: skip
        for k in np.flatnonzero(~known):
            axes.annotate("not\nidenti-\nfiable", (place[k], off[k]), xytext=(0, -9), textcoords="offset points",
                          ha="center", va="top", fontsize="small", color=PENS[kind]["color"])  # fmt: skip
    axes.set_xticks(range(len(NAMES)), NAMES.values())
    axes.set_xlim(-0.6, len(NAMES) - 0.2)
    axes.set(ylabel="share of the true value (%)", title="error (dot), standard error (dash)")


def images() -> dict[str, Figure]:
    """The images by name."""
    lab = Lab(resolve.study("fsmc_ballscrew"))
    learned = {
        "learned_sines": learned_sines,
        "learned_way": learned_way,
        "learned_circle": learned_circle_r100,
    }
    found = {name: draw(lab) for name, draw in learned.items()}
    return found | {"friction_test_record": friction_test_record(), "friction_fit": friction_fit()}
