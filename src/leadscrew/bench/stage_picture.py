"""The work-precision picture of the page on stiff friction, measured on this machine: error against speed.

python -m leadscrew.bench.stage_picture docs/images/stiff_friction.png
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.bench import stage
from leadscrew.bench.stage import BY_HAND, HOLDS, NM, TRUTH, angles, error_nm, every, real_time, rodas, speeds
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

SINE = "sine_fast"
SCHEMES = (
    *((rodas(r), "RODAS", f"rtol {r:.0e}".replace("e-0", "e-")) for r in (1e-3, 1e-4, 1e-6, 1e-8)),
    *((every("fixed", us), "SDIRK3, scalar", f"{us:g} us") for us in (250.0, 50.0, 25.0)),
    *((every("rk4", us), "RK4", f"{us:g} us") for us in (2.5, 2.0, 1.0)),
)
"""Ours: scheme, group and label."""
FORMS = {"euler": "explicit Euler", "exponential": "exponential Rosenbrock-Euler"}
"""Of the C, where it was built."""


class Point(NamedTuple):
    """A scheme in the work-precision picture."""

    group: str
    real_time: float
    error_nm: float
    label: str = ""


MARKS = {
    "RODAS": (BLUE, "o"),
    "SDIRK3, scalar": (GREEN, "s"),
    "RK4": (ORANGE, "^"),
    "exponential Rosenbrock-Euler": (PURPLE, "D"),
    "explicit Euler": (VERMILION, "v"),
    "SciPy LSODA": (SKY, "X"),
    "SciPy Radau": (BLACK, "P"),
}


def points(rounds: int = 5) -> list[Point]:
    """All schemes, measured in one process in turn; SciPy over the first 0.265 s."""
    truth = angles(SINE, TRUTH)
    ns, why = speeds(SINE, rounds, tuple(s for s, _, _ in SCHEMES))
    made = [Point(group, real_time(ns[s.name]), error_nm(SINE, s, truth), label) for s, group, label in SCHEMES]
    if not why:
        c = stage.ByHand(SINE)
        for form, us in (x for x in BY_HAND if x[0] in FORMS):
            error = float(NM * np.abs(c.run(form, us, len(truth)) - truth).max())
            made.append(Point(FORMS[form], real_time(ns[f"C {form} {us}"]), error, f"{us:g} us"))
    for method, tolerances in stage.METHODS.items():
        for rtol in tolerances:
            done = stage.scipy_run(SINE, method, rtol, HOLDS)
            error = float(NM * np.abs(done.angles - truth[:HOLDS]).max())
            each = real_time(done.seconds / HOLDS * 1e9)
            made.append(Point(f"SciPy {method}", each, error, f"rtol {rtol:.0e}".replace("e-0", "e-")))
    return made


def work_precision_figure(points: Sequence[Point], title: str) -> Figure:
    """Error against how many times faster than real time, of schemes that were measured in one run."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots()
    for group, (colour, mark) in MARKS.items():
        mine = sorted((p for p in points if p.group == group), key=lambda p: p.real_time)
        if not mine:
            continue
        axes.loglog([p.real_time for p in mine], [p.error_nm for p in mine], color=colour, marker=mark, label=group)
        for p in mine:
            axes.annotate(p.label, (p.real_time, p.error_nm), textcoords="offset points", xytext=(6, 5), fontsize=8)
    axes.margins(x=0.1)
    axes.axhline(0.5, color=BLACK, linestyle=":", linewidth=1.0)
    axes.axvline(500.0, color=BLACK, linestyle=":", linewidth=1.0)
    axes.set_xlabel("times faster than real time, one core (1)")
    axes.set_ylabel("largest error of the position (nm)")
    axes.set_title(title)
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def figure(rounds: int = 5) -> Figure:
    """The picture."""
    return work_precision_figure(points(rounds), "The stage on sin 2 pi t mm, torque held for 250 us")


if __name__ == "__main__":
    figure().savefig(sys.argv[1], dpi=90)
