"""Pictures of tangential cutting: a drawing with its headings; errors and offsets along the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.figures.style import BLACK, BLUE, GREEN, VERMILION
from leadscrew.tangent.compensate import Compensation
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


ARROWS = 40
"""Headings drawn, about, along all lines."""


def drawn_figure(strokes: Sequence[Stroke], settings: Settings) -> Figure:
    """The lines with the blade's heading on them, and how fast it turns along the way."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(10, 4.5), layout="constrained")
    plan, rate = figure.subplots(1, 2)
    total = sum(s.length for s in strokes)
    begun = 0.0
    for k, stroke in enumerate(strokes):
        s = stroke.grid(0.2)
        at = stroke.at(s)
        plan.plot(at.x, at.y, color=BLUE, lw=1.2)
        few = stroke.at(np.linspace(0.0, stroke.length, max(int(ARROWS * stroke.length / total), 1), endpoint=False))
        angle = np.radians(few.heading)
        plan.quiver(few.x, few.y, np.cos(angle), np.sin(angle), color=VERMILION, width=0.004, scale=28, zorder=3)
        plan.plot(at.x[:1], at.y[:1], "o", ms=4, color=BLACK, label="plunge" if k == 0 else None)
        rate.plot(begun + s, np.degrees(at.curvature) * settings.feed / 60.0, color=BLUE, lw=1.2)
        rate.axvline(begun, color=BLACK, lw=0.5, ls=":")
        begun += stroke.length
    plan.set_aspect("equal")
    plan.set(xlabel="x / mm", ylabel="y / mm", title="line, and heading of the blade")
    plan.legend(loc="upper left", bbox_to_anchor=(0.0, -0.12), frameon=False)
    top = 1.15 * max(max(abs(v) for v in rate.get_ylim()), 1.0)
    rate.set_ylim(-top, top)
    if settings.swivel < top:
        for side in (-1.0, 1.0):
            rate.axhline(side * settings.swivel, color=VERMILION, lw=0.8, ls="--")
    rate.set(xlabel="distance / mm", ylabel="turn of the blade / deg/s", title=f"at F{settings.feed:g}")
    return figure


def learned_figure(found: Compensation) -> Figure:
    """Error of the measured piece, error predicted for the next, and the offsets of both."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(10, 5.5), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    begun = 0.0
    for k, one in enumerate(found.learned):
        s = begun + one.travel
        first = k == 0
        top.plot(s, one.before, color=VERMILION, lw=1.2, label="measured piece" if first else None)
        top.plot(s, one.predicted, color=BLUE, lw=1.2, label="next piece, predicted" if first else None)
        bottom.plot(s, one.old, color=VERMILION, lw=1.2, label="measured piece" if first else None)
        bottom.plot(s, one.new, color=GREEN, lw=1.2, label="next piece" if first else None)
        begun += one.stroke.length
    top.set(ylabel="error of the tangent / deg")
    bottom.set(xlabel="distance / mm", ylabel="offset of the axis / deg")
    for axes in (top, bottom):
        axes.axhline(0.0, color=BLACK, lw=0.5)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    return figure
