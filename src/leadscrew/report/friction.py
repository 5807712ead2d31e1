"""Pictures of the friction models and of backlash, computed from the models when they are drawn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from leadscrew.analysis.friction import (
    break_away,
    break_away_after_rest,
    friction_along,
    friction_velocity,
    imposed_reversal,
    path_through,
    stick_slip,
)
from leadscrew.figures.figure import Figure
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.friction.asymmetric import LuGreSlide
from leadscrew.friction.dahl import Dahl
from leadscrew.friction.maxwell_slip import MaxwellSlip
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.kernel.block import Block
from leadscrew.plants._backlash import DeadBand, Play, followed, reaction
from leadscrew.plants._mass_dahl import mass_dahl
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.plants._mass_maxwell_slip import mass_maxwell_slip
from leadscrew.plants._mass_stribeck import mass_stribeck

PENS: dict[str, dict[str, Any]] = {
    "static map": {"color": BLACK, "linestyle": ":"},
    "Dahl": {"color": GREEN, "linestyle": "-."},
    "LuGre": {"color": BLUE, "linestyle": "-"},
    "Maxwell slip": {"color": VERMILION, "linestyle": "--"},
}
"""How each model is drawn, here and on the page."""
PLANTS: dict[str, Block] = {
    "static map": mass_stribeck,
    "Dahl": mass_dahl,
    "LuGre": mass_lugre,
    "Maxwell slip": mass_maxwell_slip,
}


def _panels(rows: int, columns: int, height: float) -> tuple[Figure, np.ndarray]:
    figure = Figure(figsize=(4.4 * columns + 0.4, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.ravel():
        ax.grid(color="0.92", linewidth=0.6)
    return figure, axes


def _below(figure: Figure, *all_axes: Any, columns: int = 4) -> None:
    """One legend below, for the labels of all panels, each once."""
    found: dict[str, Any] = {}
    for axes in all_axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=columns, frameon=False)


def friction_velocity_figure() -> Figure:
    """Friction against steady speed, static maps; and against a speed that swings, where the models have memory."""
    figure, ((left, right),) = _panels(1, 2, 3.9)
    speeds = np.concatenate([-np.geomspace(8e-3, 1e-7, 300), np.geomspace(1e-7, 8e-3, 300)])
    strong = Sliding(viscous=20.0)
    maps = (
        ("Coulomb", TwoSided(Sliding(static=1.0, viscous=0.0), Sliding(static=1.0, viscous=0.0)), GREEN, "-."),
        (
            "Coulomb and viscous",
            TwoSided(Sliding(static=1.0, viscous=20.0), Sliding(static=1.0, viscous=20.0)),
            SKY,
            "--",
        ),
        ("Stribeck", TwoSided(strong, strong), BLUE, "-"),
        ("Stribeck, unlike sides", TwoSided(strong, Sliding(0.7, 0.9, 0.002, 40.0)), ORANGE, (0, (5, 1, 1, 1, 1, 1))),
    )
    for name, f, colour, line in maps:
        left.plot(1e3 * speeds, friction_velocity(f, speeds), color=colour, linestyle=line, linewidth=1.4, label=name)
    left.set(xlabel="speed (mm/s)", ylabel="friction (N)", title="static maps (viscous part: 20 N s/m)")
    for w, colour in ((1.0, SKY), (10.0, BLUE), (25.0, BLACK)):
        t = np.linspace(0.0, 4.0 * math.pi / w, 20001)
        speed = 1e-3 * (1.5 + np.cos(w * t))
        path = 1e-3 * (1.5 * t + np.sin(w * t) / w)
        half = len(t) // 2
        right.plot(1e3 * speed[half:], friction_along(LuGreSlide(), path, t[1])[half:], color=colour, linewidth=1.3,
                   label=f"LuGre, {w:.0f} rad/s")  # fmt: skip
    t = np.linspace(0.0, 4.0 * math.pi / 25.0, 20001)
    forces = friction_along(MaxwellSlip(damping=0.0), 1e-3 * (1.5 * t + np.sin(25.0 * t) / 25.0), t[1])[10000:]
    right.plot(1.5 + np.cos(25.0 * t[10000:]), forces, linewidth=1.3,
               label="Maxwell slip, 25 rad/s", **PENS["Maxwell slip"])  # fmt: skip
    right.set(xlabel="speed (mm/s)", ylabel="friction (N)", title="one-way motion at a swinging speed")
    _below(figure, left, right)
    return figure


def presliding_figure() -> Figure:
    """Friction against travel of a few micrometres: loops, and what is remembered of an inner loop."""
    figure, axes = _panels(1, 3, 3.9)
    points = [0.0, 4e-5, -1e-5, 1.5e-5, -1e-5, -4e-5, 4e-5]
    path = path_through(points, 1e-7)
    inner = slice(400 + 500, 400 + 500 + 500 + 1)
    models = {
        "Dahl": Dahl(stiffness=5e4, coulomb=1.5, viscous=0.0),
        "LuGre": LuGreSlide(stiffness=5e4, damping=0.0, viscous=0.0, coulomb=1.5),
        "Maxwell slip": MaxwellSlip(damping=0.0, viscous=0.0, coulomb=1.5),
    }
    for ax, (name, f) in zip(axes[0], models.items(), strict=True):
        forces = friction_along(f, path, 1e-3)
        ax.plot(1e6 * path, forces, color="0.7", linewidth=1.2, label="path 0, 40, -10, 15, -10, -40, 40 um")
        ax.plot(1e6 * path[inner], forces[inner], color=PENS[name]["color"], linewidth=1.8, label=f"{name}, inner loop")
        start, end = inner.start, inner.stop - 1
        ax.plot(1e6 * path[[start]], forces[[start]], "o", color=BLACK, markersize=5, label="turning point, first time")
        ax.plot(
            1e6 * path[[end]], forces[[end]], "x", color=BLACK, markersize=7, label="the same place, after the loop"
        )
        ax.set(xlabel="travel (um)", title=f"{name}: {forces[start]:+.3f} N, then {forces[end]:+.3f} N")
    axes[0, 0].set_ylabel("friction (N)")
    _below(figure, *axes[0], columns=3)
    return figure


def break_away_figure() -> Figure:
    """Break-away against the rate of the force, and against the time at rest before."""
    figure, ((left, right),) = _panels(1, 2, 3.7)
    rates = np.geomspace(1.0, 50.0, 9)
    for name, plant in PLANTS.items():
        shown = plant(**{"friction.viscous": 0.0}) if name == "Dahl" else plant
        left.plot(rates, break_away(shown, list(rates)), marker=".", label=name, **PENS[name])
    left.set(xscale="log", xlabel="rate of the force (N/s)", ylabel="largest friction (N)", ylim=(0.9, 1.6),
             title="break-away from rest")  # fmt: skip
    rests = [1.0, 2.0, 5.0, 10.0, 20.0]
    for name in ("static map", "LuGre", "Maxwell slip"):
        right.plot(rests, break_away_after_rest(PLANTS[name], rests), marker=".", label=name, **PENS[name])
    right.set(xscale="log", xlabel="time at rest (s)", title="after a rest, at 5 N/s: no model ages", ylim=(0.9, 1.6))
    right.set_xticks(rests, [f"{r:g}" for r in rests])
    right.minorticks_off()
    left.set_xticks([1, 2, 5, 10, 20, 50], ["1", "2", "5", "10", "20", "50"])
    left.minorticks_off()
    _below(figure, left, right)
    return figure


def stick_slip_figure() -> Figure:
    """A mass pulled through a soft spring at a constant speed, under each model."""
    figure, ((left, right),) = _panels(1, 2, 3.7)
    for name, plant in PLANTS.items():
        run = stick_slip(plant, sample=2e-3)
        left.plot(run.time, run["actual"], linewidth=1.3, label=name, **PENS[name])
        right.plot(run.time, run["plant.speed"], linewidth=1.2, label=name, **PENS[name])
    left.plot(run.time, run["command"], color="0.6", linewidth=1.0, label="end of the spring, 0.1 m/s")
    left.set(xlabel="time (s)", ylabel="position (m)", title="1 kg on a spring of 2 N/m")
    right.set(xlabel="time (s)", ylabel="speed (m/s)", title="speed of the mass")
    for ax in (left, right):
        ax.margins(x=0)
    _below(figure, left, right, columns=5)
    return figure


def classic_figure() -> Figure:
    """Classic backlash: the play's hysteresis and the dead band's reaction, with equal and with unlike sides."""
    figure, ((left, right),) = _panels(1, 2, 3.8)
    way = np.concatenate([np.linspace(0, 6, 200), np.linspace(6, -6, 400), np.linspace(-6, 6, 400)])
    equal = Play(1.0, 1.0)
    unlike = Play(0.5, 2.0, forward_slope=0.9, backward_slope=1.05)
    twist = np.linspace(-4, 4, 401)
    bands = (DeadBand(1.0, 1.0, 1e8, 1e8), DeadBand(0.5, 2.0, 5e7, 1.5e8))
    for p, band, colour, line, label in (
        (equal, bands[0], BLUE, "-", "equal sides, 1 um each"),
        (unlike, bands[1], ORANGE, "--", "unlike gaps (0.5 and 2 um) and slopes"),
    ):
        places, place = [], 0.0
        for x in way:
            place = followed(p, place, float(x))
            places.append(place)
        left.plot(way, places, color=colour, linestyle=line, linewidth=1.4, label=label)
        forces = [reaction(band, float(x)) * 1e-6 for x in twist]
        right.plot(twist, forces, color=colour, linestyle=line, linewidth=1.4, label=label)
    left.set(xlabel="drive (um)", ylabel="table (um)", title="play: the table follows one flank or stands")
    right.set(xlabel="twist, drive minus table (um)", ylabel="reaction (N)", title="dead band: force on the table")
    _below(figure, left, columns=2)
    return figure


def modern_figure() -> Figure:
    """Two masses: a reversal with an almost elastic and with a soft impact, against the classic play."""
    figure, ((left, right),) = _panels(1, 2, 3.8)
    radius, rate = 1e-3, 2.0 * math.pi
    for restitution, colour, line in ((0.9, BLUE, "-"), (0.05, VERMILION, "--")):
        run = imposed_reversal(radius, rate, restitution)
        since = 1e3 * (run.time - 0.25)
        near = (since > -5.0) & (since < 80.0)
        twist = 1e6 * (run["plant.motor"] - run["plant.table"])
        label = f"two masses, restitution {restitution:g}"
        left.plot(since[near], twist[near], color=colour, linestyle=line, linewidth=1.2, label=label)
        lag = 1e3 * run["plant.table_speed"]
        right.plot(since[near], lag[near], color=colour, linestyle=line, linewidth=1.2, label=label)
    screw = radius * np.sin(rate * run.time)
    table = -1e-6
    classic = []
    for x in screw:
        table = followed(Play(), table, float(x))
        classic.append(table)
    left.plot(since[near], 1e6 * (screw - classic)[near], color=BLACK, linestyle=":", label="classic play")
    speed = np.gradient(np.array(classic), run.time)
    right.plot(since[near], 1e3 * speed[near], color=BLACK, linestyle=":", label="classic play")
    left.set(xlabel="time after the reversal of the screw (ms)", ylabel="screw minus table (um)", title="2 um of play")
    right.set(xlabel="time after the reversal of the screw (ms)", ylabel="speed of the table (mm/s)",
              title="the table is hit, and bounces")  # fmt: skip
    _below(figure, left, columns=3)
    return figure
