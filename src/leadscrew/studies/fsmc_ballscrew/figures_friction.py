"""Pictures of the friction: Figures 3 and 4 of the paper, and what tells LuGre and Maxwell slip apart on the stage."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadscrew.analysis.friction import friction_velocity
from leadscrew.friction.lugre import TABLE_2, LuGre
from leadscrew.friction.maxwell_slip import MaxwellSlipScrew
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.studies.fsmc_ballscrew import friction_experiments as x
from leadscrew.studies.fsmc_ballscrew.claims_friction import TORQUES, inner_loop
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.study import Picture

RATES = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Of the rising torque, N m/s."""
MODELS: dict[str, dict[str, Any]] = {
    "LuGre": {"color": BLUE, "linestyle": "-"},
    "Maxwell slip": {"color": VERMILION, "linestyle": "--"},
}


def friction_pictures(loops: Loops) -> list[Picture]:
    """Drawn on demand, from the models themselves."""
    return [
        Picture("fig3_friction_classical", "Figure 3 redrawn: static, dynamic and viscous friction of the stage, "
                "without a Stribeck effect: at rest up to F_S, sliding F_C and the viscous part.", fig3),
        Picture("fig4_friction_modern", "Figure 4 redrawn: the fall from static to dynamic friction, then the viscous "
                "rise, by equation (3) with the three columns of Table 2. Right: the fall itself, at the Stribeck "
                "speed of 1 or 5 mrad/s.", fig4),
        Picture("friction_break_away", "Torque at which the stage breaks away (20 mrad/s) against the rate at which it "
                "rises. LuGre lets go early because its bristles creep; the Maxwell elements hold until they slip.",
                partial(break_away, loops)),
        Picture("friction_presliding", "Before sliding, on a path with an inner loop: Maxwell slip closes it and goes "
                "on as if it had not been, LuGre does not.", presliding),
    ]  # fmt: skip


def _panels(columns: int, height: float = 3.6) -> tuple[Figure, Any]:
    figure = Figure(figsize=(4.3 * columns, height), layout="constrained")
    panels = figure.subplots(1, columns, squeeze=False)[0]
    for axes in panels:
        axes.grid(color="0.92", linewidth=0.6)
    return figure, panels


def fig3() -> Figure:
    """The classical map."""
    figure, (axes,) = _panels(1)
    f = LuGre()
    way = Sliding(coulomb=f.coulomb, static=f.coulomb, viscous=f.viscous)
    speed = np.concatenate([np.linspace(-6.0, -1e-9, 100), np.linspace(1e-9, 6.0, 100)])
    friction = friction_velocity(TwoSided(way, way), speed)
    for part in (speed < 0.0, speed > 0.0):
        axes.plot(
            speed[part], friction[part], color=BLUE, label="sliding: F_C and viscous" if speed[part][0] > 0 else None
        )
    axes.plot([0.0, 0.0], [-f.static, f.static], color=VERMILION, linewidth=2.2, label="at rest: up to F_S")
    axes.plot(speed, np.sign(speed) * f.coulomb, color="0.6", linestyle=":", label="F_C alone")
    axes.set(xlabel="speed (rad/s)", ylabel="friction (N m)")
    axes.legend(frameon=False, loc="lower right", fontsize="small")
    return figure


def fig4() -> Figure:
    """Equation (3) and the viscous term, by the columns of Table 2."""
    figure, (left, right) = _panels(2)
    pens = {"plant": (BLACK, "-"), "hat": (BLUE, "--"), "tilde": (ORANGE, "-.")}
    wide = np.concatenate([-np.geomspace(6.0, 1e-5, 300), np.geomspace(1e-5, 6.0, 300)])
    near = np.linspace(1e-6, 0.016, 400)
    for name, f in TABLE_2.items():
        colour, line = pens[name]
        left.plot(wide, friction_velocity(f, wide), color=colour, linestyle=line, label=name)
        right.plot(1e3 * near, friction_velocity(f, near), color=colour, linestyle=line, label=name)
    left.set(xlabel="speed (rad/s)", ylabel="friction (N m)", title="static, Stribeck and viscous")
    right.set(xlabel="speed (mrad/s)", ylabel="friction (N m)", title="the fall", ylim=(6.0, 9.6))
    for axes in (left, right):
        axes.legend(frameon=False, loc="lower right" if axes is left else "upper right", fontsize="small")
    return figure


def break_away(loops: Loops) -> Figure:
    """Both models under rising torques."""
    figure, (axes,) = _panels(1)
    lugre = [x.break_away_torque(loops, rate) for rate in RATES]
    slip = []
    for rate in RATES:
        run = x.gms_rise(loops, rate, 9.5, samples=8000, step=max(9.5 / rate / 1e6, 5e-7))
        slip.append(x.crossing(run["output"], run["plant.speed"], x.SLIDES))
    axes.plot(RATES, lugre, marker="o", markersize=4, label="LuGre", **MODELS["LuGre"])
    axes.plot(RATES, slip, marker="s", markersize=4, label="Maxwell slip, six elements", **MODELS["Maxwell slip"])
    axes.plot(
        list(TORQUES), list(TORQUES.values()), "x", color=BLACK, markersize=8, label="LuGre, digest (SciPy Radau)"
    )
    for level, name in ((LuGre().static, "F_S"), (LuGre().coulomb, "F_C")):
        axes.axhline(level, color="0.6", linewidth=0.8)
        axes.text(RATES[-1], level, f" {name}", color="0.4", va="center", ha="left")
    axes.set(xscale="log", xlabel="rate of the torque (N m/s)", ylabel="torque at break-away (N m)", ylim=(5.0, 9.8))
    axes.set_xticks((0.05, 0.1, 0.5, 1.0, 5.0, 10.0), ("0.05", "0.1", "0.5", "1", "5", "10"))
    axes.minorticks_off()
    axes.legend(frameon=False, loc="lower left", fontsize="small")
    return figure


def presliding() -> Figure:
    """Torque against angle, quasi-static, one panel a model."""
    figure, panels = _panels(2)
    models: tuple[tuple[str, LuGre | MaxwellSlipScrew], ...] = (
        ("LuGre", LuGre()),
        ("Maxwell slip", MaxwellSlipScrew()),
    )
    for axes, (name, f) in zip(panels, models, strict=True):
        path, torque, missed = inner_loop(f)
        inner = slice(350, 551)
        axes.plot(1e6 * path, torque, color="0.65", linewidth=1.1, label="150, -50, 50, -50, -150, 150 urad")
        axes.plot(1e6 * path[inner], torque[inner], linewidth=1.8, label="inner loop", **MODELS[name])
        axes.plot(1e6 * path[350], torque[350], "o", color=BLACK, markersize=5, label="turn, first time")
        axes.plot(1e6 * path[550], torque[550], "x", color=GREEN if missed else SKY, markersize=8,
                  label="the same place, after the loop")  # fmt: skip
        axes.set(xlabel="angle (urad)", title=f"{name}: off by {missed:+.2f} N m")
    panels[0].set_ylabel("friction (N m)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    return figure
