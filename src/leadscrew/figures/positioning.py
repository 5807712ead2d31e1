"""Deviations of positioning against target, as ISO 230-2 shows them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from leadscrew.figures.style import BLACK, BLUE, VERMILION

if TYPE_CHECKING:
    from leadscrew.analysis.positioning import Positioning


def draw(axes: Any, test: Positioning) -> None:
    """The picture's lines into axes of a figure."""
    for x, way, name, colour, mark in (
        (test.up_um, test.up, "+", BLUE, "^"),
        (test.down_um, test.down, "-", VERMILION, "v"),
    ):
        if x is None or way is None:
            continue
        axes.plot(test.targets_mm, x, mark, color=colour, markersize=3, alpha=0.5, linewidth=0)
        axes.plot(test.targets_mm, way.mean, color=colour, linewidth=1.4, label=f"mean, direction {name}")
        axes.fill_between(test.targets_mm, way.mean - 2 * way.s, way.mean + 2 * way.s, color=colour, alpha=0.18,
                          linewidth=0, label=f"mean ± 2 s, direction {name}")  # fmt: skip
    if test.both is not None:
        axes.plot(test.targets_mm, test.both.mean, color=BLACK, linewidth=1.0, linestyle="--",
                  label="mean of both directions")  # fmt: skip
    axes.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    axes.set(xlabel="target position (mm)", ylabel="deviation (µm)")
