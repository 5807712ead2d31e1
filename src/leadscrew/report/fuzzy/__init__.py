"""Pictures of a fuzzy system: its membership functions, its control surface, its rules along a run.

All are Matplotlib figures that belong to nobody: save them with ``figure.savefig(path)``, or show them in a notebook.
"""

from __future__ import annotations

from leadscrew.report.fuzzy.membership import membership_figure
from leadscrew.report.fuzzy.rules import activity_figure
from leadscrew.report.fuzzy.surfaces import Surface, surface, surface_figure

__all__ = ["Surface", "activity_figure", "membership_figure", "surface", "surface_figure"]
