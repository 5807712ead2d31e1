"""Force controllers taken apart, to be called by those that guard them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from leadscrew.kernel.block import Block
from leadscrew.references._cutting_program import CutCommand
from leadscrew.sensors._load_cell import CutReading
from leadscrew.util.errors import BlockError


class Inner(NamedTuple):
    """A force controller, and how it is given command and reading."""

    block: Block
    law: Callable[..., Any]
    align: Callable[..., Any]
    told: Callable[..., Any]
    """Of a command: what the controller takes."""
    shown: Callable[..., Any]
    """Of a reading and what was :class:`~leadscrew.controllers._guard.watching.Seen`: what it takes."""

    def ready(self, dt: float) -> Any:
        """What its step gets as ``p`` at this period."""
        return self.block.params if self.block.prepare is None else self.block.prepare(self.block.params, dt)


def whole(command):
    """What a command says of the cut."""
    return CutCommand(command.force, command.depth, command.next_depth, command.change_in_s)


def finite_command(command):
    """Whether all of that is finite."""
    return (
        math.isfinite(command.force)
        and math.isfinite(command.depth)
        and math.isfinite(command.next_depth)
        and math.isfinite(command.change_in_s)
    )


def finite_reading(feedback):
    """Whether a reading is finite."""
    return (
        math.isfinite(feedback.force)
        and math.isfinite(feedback.raw)
        and math.isfinite(feedback.travel)
        and math.isfinite(feedback.turns)
    )


def force_of(command):
    """The force of a command."""
    return command.force


def believed(feedback, seen):
    """A reading with the numbers that are believed."""
    return CutReading(seen.force, seen.raw, seen.travel, seen.turns)


def believed_force(feedback, seen):
    """The filtered force that is believed."""
    return seen.force


def taken_apart(inner: Block, maker: str) -> Inner:
    """``inner``, ready to be called.

    Raises:
        BlockError: it is not a sampled force controller with a bumpless start.
    """
    if inner.kind != "controller" or inner.continuous or inner.params is None or inner.state is None:
        raise BlockError(f"{maker}({inner.name}): needs a sampled controller with parameters and state")
    if inner.signals != ("command", "feedback", "dt") or inner.initial is not None:
        raise BlockError(f"{maker}({inner.name}): needs a controller that takes command, feedback and dt")
    if inner.align is None:
        raise BlockError(f"{maker}({inner.name}): needs a controller with a bumpless start (align=)")
    cut = bool(getattr(inner.step, "takes_cut", False))
    told, shown = (whole, believed) if cut else (force_of, believed_force)
    return Inner(inner, inner.step, inner.align, told, shown)
