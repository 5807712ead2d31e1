"""The views that explain a running machine, worked out only while somebody looks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from leadscrew.operate.why import Circle, explainer
from leadscrew.panel.strict_json import plain

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.operate.operated import Operated


class Explanations:
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
        self._row: np.ndarray | None = None
        """The last row under this controller; none before its first period."""

    def feed(self, operated: Operated, rows: np.ndarray) -> None:
        """Rows of the machine under this controller, at least one, all columns."""
        self._row = rows[-1]
        if self.circle is not None:
            self.circle.feed(rows, _loops(operated))

    def look(self, operated: Operated, views: tuple[str, ...]) -> dict[str, Any]:
        """The views named that there are, now; none before the first period under this controller."""
        if self._row is None:
            return {}
        wanted = tuple(v for v in views if v in self.explainer.views)
        found: dict[str, Any] = {}
        if wanted:
            row = dict(zip(self._columns, self._row.tolist(), strict=True))
            found = self.explainer.look(operated.live, row, wanted)
        if "circle" in views and self.circle is not None:
            found = {**found, "circle": self.circle.look()}
        return plain(found)


def _loops(operated: Operated) -> tuple[Any, ...]:
    return tuple(live.loop for live in operated.lives)


__all__ = ["Explanations"]
