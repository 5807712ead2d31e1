"""The polar plot of a circular test: deviations drawn much larger than the circle, as ball-bar software draws them.

The nominal circle is drawn with a radius of ``CIRCLE`` divisions; a division is a round number of micrometres chosen so
that the largest deviation takes about three. The magnification is how much larger deviations are drawn than the circle:
``R / (CIRCLE division)``. Angles and radii are about the common least-squares centre: the centring does not show.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.circular.evaluation import Evaluation
from leadscrew.analysis.circular.paths import SOURCES, TURN, Circle, CircularTest, Floats, Turn
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.report.style import BLACK, BLUE, VERMILION

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CIRCLE = 8.0
"""Divisions from the middle of the plot to the nominal circle."""
WANTED = 3.0
"""Divisions that the largest deviation should take."""
COLOURS = {"ccw": BLUE, "cw": VERMILION}
WORDS = {"ccw": "counter-clockwise", "cw": "clockwise"}


def division_um(largest_um: float) -> float:
    """A round number of micrometres a division: 1, 2 or 5 times a power of ten."""
    if largest_um <= 0.0:
        return 0.001
    exact = largest_um / WANTED
    ten = 10.0 ** math.floor(math.log10(exact))
    return max(next(float(f"{m * ten:.12g}") for m in (1.0, 2.0, 5.0, 10.0) if m * ten >= exact * (1.0 - 1e-9)), 1e-6)


def centre_of(found: Evaluation) -> Circle:
    """The least-squares centre of all paths, mm."""
    q = found.quantities
    way = q.both or q.ccw or q.cw
    assert way is not None
    return Circle(1e-3 * way.centre_x, 1e-3 * way.centre_y, found.test.radius_mm)


def about(turn: Turn, centre: Circle, radius_mm: float) -> tuple[Floats, Floats]:
    """Angles in order of travel and deviations, um, about a centre."""
    u, v = turn.x_mm - centre.x, turn.y_mm - centre.y
    return np.unwrap(np.arctan2(v, u)), 1000.0 * (np.hypot(u, v) - radius_mm)


def centred(test: CircularTest) -> dict[str, tuple[Floats, Floats]]:
    """Angles and deviations of each direction of a test, see :func:`about`, about the centre of all its paths."""
    q = quantities(test)
    way = q.both or q.ccw or q.cw
    assert way is not None
    centre = Circle(1e-3 * way.centre_x, 1e-3 * way.centre_y, test.radius_mm)
    return {t.direction: about(t, centre, test.radius_mm) for t in test.turns}


def picture(found: Evaluation) -> Figure:
    """Polar plot, and the same deviations over the angle."""
    from matplotlib.figure import Figure

    test, centre = found.test, centre_of(found)
    paths = {t.direction: about(t, centre, test.radius_mm) for t in test.turns}
    division = division_um(max(float(np.abs(r).max()) for _, r in paths.values()))
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    left = figure.add_subplot(1, 2, 1, projection="polar")
    right = figure.add_subplot(1, 2, 2)
    polar(left, paths, division, test)
    for direction, (angle, deviation) in paths.items():
        degrees = np.mod(np.degrees(angle) + 1e-9, 360.0)
        order = np.argsort(degrees, kind="stable")
        right.plot(degrees[order], deviation[order], color=COLOURS[direction], linewidth=1.0, label=WORDS[direction])
    for reversal in (0, 90, 180, 270, 360):
        right.axvline(reversal, color="0.8", linewidth=0.6, zorder=0)
    right.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    right.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel="angle (degrees)", ylabel="radial deviation (µm)")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    feed = "" if test.feed_mm_min is None else f", {test.feed_mm_min:g} mm/min"
    figure.suptitle(
        f"radius {test.radius_mm:g} mm{feed}, axes {test.axes[0]}{test.axes[1]}, {SOURCES[test.source]}\n"
        "deviations from the nominal radius, about the least-squares centre",
        fontsize="small",
    )
    return figure


def polar(axes: Any, paths: dict[str, tuple[Floats, Floats]], division: float, test: CircularTest) -> None:
    """Deviations of each direction (angles and um, see :func:`about`) on polar axes, ``division`` um a division."""
    full = np.linspace(0.0, TURN, 721)
    axes.plot(full, np.full(full.size, CIRCLE), color=BLACK, linewidth=1.0)
    for direction, (angle, deviation) in paths.items():
        # Closed where the turn ends next to its start.
        closed_at, closed = (
            np.append(angle, angle[0] + math.copysign(TURN, angle[-1] - angle[0])),
            np.append(deviation, deviation[0]),
        )
        axes.plot(closed_at, CIRCLE + closed / division, color=COLOURS[direction], linewidth=1.0)
    start = math.radians(test.start_deg)
    first = paths[test.turns[0].direction][1][0]
    axes.plot([start], [CIRCLE + first / division], marker="o", markersize=4, color=BLACK, linestyle="none")
    most = max(CIRCLE + max(float(r.max()) for _, r in paths.values()) / division, CIRCLE + 1.0)
    rings = [k for k in range(-4, 5) if k != 0 and CIRCLE + k <= most + 0.5]
    axes.set_rlim(0.0, most + 0.6)
    axes.set_rticks([CIRCLE + k for k in (*rings, 0)], [*(_ring(k, division) for k in rings), "0"], fontsize="x-small")
    axes.set_rlabel_position(22.5)
    x, y = test.axes
    axes.set_thetagrids(range(0, 360, 45), [f"+{x}", "", f"+{y}", "", f"−{x}", "", f"−{y}", ""])
    axes.grid(color="0.85", linewidth=0.5)
    magnification = 1000.0 * test.radius_mm / (CIRCLE * division)
    axes.set_title(f"{division:g} µm a division, magnification {magnification:,.0f} : 1, ● start", fontsize="small")


def _ring(k: int, division: float) -> str:
    return f"{'+' if k > 0 else '−'}{abs(k) * division:g}" if k % 2 == 0 else ""
