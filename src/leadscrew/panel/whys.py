"""The views that explain a running machine, worked out only while somebody looks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from leadscrew.operate.why import Circle, explainer
from leadscrew.panel.plain import plain

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.operate.operated import Operated


class Whys:
    """The explainer of a controller, and the ball bar of two axes on a circle.

    Raises:
        ValueRefused: a circle is asked of what makes none.
    """

    def __init__(self, operated: Operated) -> None:
        self.explainer = explainer(operated.loop, operated.controller)
        self.circle = Circle(list(_loops(operated)), operated.columns) if operated.start.circle else None
        self.reason = "" if self.circle else self.explainer.reason
        """Why there is no view, where there is none."""
        self.views = (*self.explainer.views, *(("circle",) if self.circle else ()))
        self._columns = list(operated.columns)

    def feed(self, operated: Operated, rows: np.ndarray) -> None:
        """Rows of the machine, all columns."""
        if self.circle is not None:
            self.circle.feed(rows, _loops(operated))

    def look(self, operated: Operated, row: np.ndarray, views: tuple[str, ...]) -> dict[str, Any]:
        """The views named that there are, now."""
        wanted = tuple(v for v in views if v in self.explainer.views)
        found: dict[str, Any] = {}
        if wanted:
            found = self.explainer.look(operated.live, dict(zip(self._columns, row.tolist(), strict=True)), wanted)
        if "circle" in views and self.circle is not None:
            found = {**found, "circle": self.circle.look()}
        return plain(found)


def _loops(operated: Operated) -> tuple[Any, ...]:
    return tuple(live.loop for live in operated.lives)


__all__ = ["Whys"]
