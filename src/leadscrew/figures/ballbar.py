"""The polar plot of a circular test, as instruments print it: deviations magnified about the nominal circle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLACK, BLUE, VERMILION

if TYPE_CHECKING:
    from leadscrew.analysis.circular.paths import CircularTest, Floats

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


def polar(axes: Any, paths: dict[str, tuple[Floats, Floats]], division: float, test: CircularTest) -> None:
    """Deviations of each direction (angles and um) on polar axes, ``division`` um a division."""
    full = np.linspace(0.0, 2.0 * math.pi, 721)
    axes.plot(full, np.full(full.size, CIRCLE), color=BLACK, linewidth=1.0)
    for direction, (angle, deviation) in paths.items():
        # Closed where the turn ends next to its start.
        closed_at, closed = (
            np.append(angle, angle[0] + math.copysign(2.0 * math.pi, angle[-1] - angle[0])),
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
