"""Panels of a figure, and one legend for all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


def grid(width: float, height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """A figure (inches) and its axes, one or an array."""
    from leadscrew.figures.figure import Figure

    fig = Figure(figsize=(width, height), layout="constrained")
    return fig, fig.subplots(rows, columns, **options)


def with_legend(fig: Figure, *panels: Any, columns: int = 2, **options: Any) -> Figure:
    """The figure with one legend below it, each name of the panels once."""
    handles: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    fig.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns, frameon=False, **options)
    return fig
