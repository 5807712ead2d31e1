"""What the panel's process drives: a simulated machine or a real one behind the same few calls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from leadscrew.panel.frames import Frame


@dataclass(frozen=True)
class Later:
    """An answer that takes time: ``work`` runs in a thread of its own, then ``done`` in the machine's, with its result.

    What ``work`` raises is the answer's error; ``done`` is then not called.
    """

    work: Callable[[], Any]
    done: Callable[[Any], dict[str, Any]]


class Machine(Protocol):
    """A machine under the panel. Everything but ``Later.work`` is called from one thread."""

    columns: list[str]
    """Of the frames, without ``time``."""

    def begin(self) -> Later | None:
        """Called once, first: what has to be built before there is anything to describe; None where nothing has."""
        ...

    def describe(self) -> dict[str, Any]:
        """The ``machine`` message."""
        ...

    def tick(self, now: float) -> list[Frame]:
        """Moves on to ``now`` (monotonic s) and gives what is new to see; called every 20 ms, never blocks longer."""
        ...

    def ask(self, do: str, args: dict[str, Any]) -> dict[str, Any] | Later:
        """Obeys one command whose form was checked.

        Raises:
            LeadscrewError: refused; the machine is as before.
        """
        ...

    def state(self) -> dict[str, Any]:
        """The machine's part of the ``state`` message: the hub adds who writes and who watches."""
        ...

    def news(self) -> list[tuple[str, dict[str, Any]]]:
        """Since the last call: ("machine", {}) where ``describe`` changed, ("notice", {level, text}), and
        ("capture", {"capture": {...}, "frame": Frame}).
        """
        ...

    def why(self, views: tuple[str, ...]) -> dict[str, Any]:
        """``t`` and ``views`` of the ``why`` message, those named; empty where there is none."""
        ...

    def fail(self, text: str) -> None:
        """An error of ours was met: stand still, with ``text`` as the message."""
        ...

    def close(self) -> str:
        """The end; a real machine is left as it is safe. Gives what has to be said then, empty where nothing has."""
        ...


__all__ = ["Later", "Machine"]
