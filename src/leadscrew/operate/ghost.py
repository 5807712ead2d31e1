"""The ghost: the same machine running on under the setting before the last change, with the same noise and loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadscrew.operate import change
from leadscrew.operate.axes import Axes, Later
from leadscrew.util.errors import ValueRefused

MODES = ("previous", "pinned", "off")
"""``previous``: the setting before the last change; ``pinned``: the setting before the first; ``off``: none."""


@dataclass(frozen=True)
class Ghost:
    """What the ghost is, for its label."""

    label: str
    """The change that it has not made."""
    since: int
    """Period from which it goes its own way."""


class Follower:
    """Keeps the ghost beside the machine."""

    def __init__(self) -> None:
        self.mode = "previous"
        self.axes: Axes | None = None
        self.shown: Ghost | None = None

    def choose(self, mode: str) -> None:
        """Changes the mode; ``off`` ends the ghost that there is.

        Raises:
            ValueRefused: no such mode.
        """
        if mode not in MODES:
            raise ValueRefused(f"compare = {mode!r}: allowed are {', '.join(MODES)}")
        self.mode = mode
        if mode == "off":
            self.axes, self.shown = None, None

    def wanted(self) -> bool:
        """Whether the next change of the operator moves the ghost."""
        return self.mode == "previous" or (self.mode == "pinned" and self.axes is None)

    def place(self, axes: Axes, label: str) -> None:
        """The ghost goes on from a copy of the machine before the change."""
        self.axes, self.shown = axes, Ghost(label, axes.period)

    def also(self, parts: list[dict[str, Any]]) -> None:
        """What reaches the ghost too, at once; of a controller that it does not have it takes nothing."""
        if self.axes is None or self.axes.diverged:
            return
        known = _known(self.axes, parts)
        if any(known):
            change.make(self.axes, known, change.AT_ONCE)

    def later(self, later: Later) -> None:
        """What will reach the ghost too."""
        if self.axes is not None:
            self.axes.later(replace(later, parts=tuple(_known(self.axes, later.parts))))

    def advance(self, periods: int, columns: list[str]) -> np.ndarray | None:
        """Rows in the machine's columns, NaN in those that only one of the two has and after the ghost is lost."""
        if self.axes is None:
            return None
        rows = self.axes.advance(periods)
        if self.axes.columns == columns and len(rows) == periods:
            return rows
        whole = np.full((periods, len(columns)), np.nan)
        at = {c: i for i, c in enumerate(self.axes.columns)}
        both = [(i, at[c]) for i, c in enumerate(columns) if c in at]
        whole[: len(rows), [i for i, _ in both]] = rows[:, [j for _, j in both]]
        return whole


def _known(axes: Axes, parts: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    both = zip(axes.lives, parts, strict=True)
    return [{k: v for k, v in part.items() if k in live.loop.sheet} for live, part in both]


__all__ = ["MODES", "Follower", "Ghost"]
