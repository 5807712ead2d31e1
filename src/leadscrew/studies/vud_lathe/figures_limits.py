"""Pictures of the axis with limits: the fastest move beside the controllers, and where the PWM lets them stand."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.report.style import VERMILION, colour, pen
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe import limits as r
from leadscrew.studies.vud_lathe.controllers import CONTROLLERS
from leadscrew.studies.vud_lathe.runs import STEPS, Loops

DRAWN = ("corrected.vud_beta_e", "ours.pd")
FAST = {"linear": "ours.vud_fast", "limited": "ours.vud_fast_limited"}
"""The fastest controller that was made for the axis."""
FASTEST = {"color": VERMILION, "linestyle": "-.", "linewidth": 1.3, "label": "fastest move (bound)"}
UNTIL_S = {STEPS[0]: 1.1, STEPS[1]: 1.8}
TITLE = {"linear": "linear axis", "limited": "limited axis"}


def limits_pictures(loops: Loops) -> list[Picture]:
    """All of them, drawn on demand from the runs that the claims have made."""
    return [
        Picture("fastest_move_m170", "The step to -170 mm on the linear and on the limited axis: error, speed and "
                "current of the fastest move that there is, of the corrected VUD law, a PD controller and our fastest.",
                partial(fastest, loops, STEPS[1])),
        Picture("pwm_rest", "Where controllers stand after a step to -50 mm on the limited axis: with duties in whole "
                "counts of a PWM timer, and with the remainder of each period carried into the next.",
                partial(rest, loops, STEPS[0])),
    ]  # fmt: skip


def _current(run: Any, machine: str) -> np.ndarray:
    """Armature current in ampere; of the linear chain it is what its acceleration takes, T_s U_s / (K_v R) dv/dt."""
    if machine == "limited":
        return np.asarray(run["plant.current"])
    axis = r.AXIS
    both = axis.electrical_lag_s + axis.mechanical_lag_s
    slope = (run["plant.current"] - run["plant.speed"]) / axis.mechanical_lag_s
    return both * axis.supply_v / (axis.full_duty_speed_mm_s * axis.resistance_ohm) * slope


def fastest(loops: Loops, scenario: str) -> Figure:
    """Error on a logarithmic scale, speed and current, for both axes."""
    figure = Figure(figsize=(9.0, 7.2), layout="constrained")
    panels = figure.subplots(3, 2, sharex=True, sharey="row")
    distance, until = r.WAY_MM[scenario], UNTIL_S[scenario]
    for column, machine in enumerate(("linear", "limited")):
        best = r.played(distance, machine == "limited")
        error, speed, current = panels[:, column]
        for name in (c for c in (*DRAWN, FAST[machine]) if c in CONTROLLERS):
            run = loops.run(name, scenario, machine=machine, record=r.SEEN)
            shown = run.time <= until
            away = 1000.0 * np.abs(run["command"] - run["actual.position"])
            for axes, values in ((error, np.maximum(away, 1e-2)), (speed, np.abs(run["plant.speed"])),
                                 (current, -_current(run, machine))):  # fmt: skip
                axes.plot(run.time[shown], values[shown], **pen(name), linewidth=1.1)
        for axes, values in ((error, np.maximum(np.abs(best.error_um), 1e-2)), (speed, np.abs(best.speed)),
                             (current, best.current)):  # fmt: skip
            axes.plot(best.time, values, **FASTEST)
        error.axhline(2.0, color="0.5", linewidth=0.8, linestyle=":")
        error.set(yscale="log", title=f"{TITLE[machine]}: bound {r.bound(distance, machine == 'limited').time_s:.3f} s")
        if machine == "limited":
            speed.axhline(r.AXIS.top_speed_mm_s, color="0.5", linewidth=0.8, linestyle=":")
            for side in (-1.0, 1.0):
                current.axhline(side * r.AXIS.current_limit_a, color="0.5", linewidth=0.8, linestyle=":")
        current.set_xlabel("time (s)")
    for axes, label in zip(panels[:, 0], ("distance from target (µm)", "speed (mm/s)", "current (A)"), strict=True):
        axes.set_ylabel(label)
    named: dict[str, Any] = {}
    for axes in panels[0]:
        named.update(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=3, frameon=False)
    return figure


def rest(loops: Loops, scenario: str) -> Figure:
    """True error around the target with and without carrying the remainder, and the errors that ask for nothing."""
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, carry in zip(panels, (False, True), strict=True):
        for name in DRAWN:
            loop = loops.get(name, scenario, machine="limited").using({"actuator.carry": carry})
            run = loop.run(2.0, record=r.SEEN)
            axes.plot(run.time, 1000.0 * (run["command"] - run["actual.position"]), **pen(name), linewidth=1.1)
            far = r.standing_um(name, 0.5 / 1000.0)
            if not carry:
                axes.axhspan(-far, far, color=colour(name), alpha=0.12, linewidth=0)
        for side in (-2.0, 2.0):
            axes.axhline(side, color="0.5", linewidth=0.8, linestyle=":")
        axes.set(xlabel="time (s)", xlim=(0.2, 2.0), ylim=(-6.0, 6.0),
                 title="remainder carried over" if carry else "duty in whole counts of 1,000")  # fmt: skip
    panels[0].set_ylabel("true error (µm)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    return figure
