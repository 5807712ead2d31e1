"""What can be undone and done again."""

from __future__ import annotations

from dataclasses import dataclass

from leadscrew.kernel.errors import ValueRefused
from leadscrew.operate.session import Event

DEPTH = 200
"""Changes that can be undone at most."""


@dataclass(frozen=True)
class Step:
    """A change, and the one that takes it back; the periods in them say nothing."""

    back: Event
    forth: Event


class History:
    """Changes done, and changes undone."""

    def __init__(self) -> None:
        self.done: list[Step] = []
        self.undone: list[Step] = []

    def add(self, step: Step) -> None:
        """A new change: what was undone before cannot be done again."""
        self.done = [*self.done[-(DEPTH - 1) :], step]
        self.undone = []

    def last(self) -> Step:
        """The change to be undone.

        Raises:
            ValueRefused: there is none.
        """
        if not self.done:
            raise ValueRefused("there is nothing to undo")
        return self.done[-1]

    def next(self) -> Step:
        """The change to be done again.

        Raises:
            ValueRefused: there is none.
        """
        if not self.undone:
            raise ValueRefused("there is nothing to redo")
        return self.undone[-1]

    def taken_back(self) -> None:
        """The last change was undone."""
        self.undone.append(self.done.pop())

    def done_again(self) -> None:
        """The change was done again."""
        self.done.append(self.undone.pop())


__all__ = ["History", "Step"]
