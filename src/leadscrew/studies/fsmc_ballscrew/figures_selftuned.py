"""Pictures of friction found from one record: what the record holds, and what comes of it."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadscrew.analysis.friction import friction_along, friction_velocity
from leadscrew.friction.lugre import LuGre
from leadscrew.identify.friction import FrictionFit
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.references.friction_test import ROWS
from leadscrew.report.style import BLACK, BLUE, VERMILION
from leadscrew.studies.fsmc_ballscrew.fits import Fits
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.selftuned import record_loop
from leadscrew.studies.study import Picture

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


def selftuned_pictures(loops: Loops, fits: Fits | None = None) -> list[Picture]:
    """Both, drawn on demand; ``fits`` of the claims saves making them again."""
    kept = fits or Fits(loops)
    return [
        Picture("friction_test_record", "The record that determines all six parameters: position and torque at 4 kHz "
                "with a scale of 10 nm. Right, its part of some um: the torque creeps up while the bristles hold, the "
                "stage slips, and back.", partial(record, loops)),
        Picture("friction_fit", "Friction as found from two records, against the truth: at a steady speed, along an "
                "imposed path before sliding, and by parameter. Sines of millimetres do not determine F_S and v_s, and "
                "the fit says so.", partial(fit, kept)),
    ]  # fmt: skip


def record(loops: Loops) -> Figure:
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
    push.set(ylabel="torque (N m)", xlabel="time (s)")
    slow.set(ylabel="torque (N m)", xlabel="time (s)")
    _finish(figure, place, push, near, slow)
    return figure


def fit(fits: Fits) -> Figure:
    """Stribeck curve, pre-sliding loop, and errors by parameter."""
    found = {kind: fits.of(kind) for kind in ("test", "sines")}
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
    stribeck.set(xlabel="steady speed (µm/s)", ylabel="friction (N m)", title="sliding (Stribeck curve)")
    loop.set(xlabel="travel (µm)", ylabel="friction (N m)",
             title=f"before sliding: ±{LOOP_UM:g} µm at {LOOP_HZ:g} Hz")  # fmt: skip
    _errors(share, found)
    _finish(figure, stribeck, loop, share)
    return figure


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


def _finish(figure: Figure, *panels: Axes) -> None:
    """A pale grid, and one legend below that hides nothing."""
    shown: dict[str, Any] = {}
    for axes in panels:
        axes.grid(color="0.92", linewidth=0.6)
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            shown.setdefault(label, handle)
    figure.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=3, frameon=False)
