"""What the wrappers of this package share: a controller of the force that adds to its ``output``, taken apart."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from leadscrew.controllers._force.with_output import WITH_OUTPUT
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.by_position import whole
from leadscrew.util.errors import BlockError


class Inner(NamedTuple):
    """A controller taken apart, to be called inside another one."""

    block: Block
    law: Callable[..., Any]
    align: Any
    its: Callable[..., Any]
    """Of what the wrapper is told or reads: what the controller is told or reads."""

    with_output: Callable[..., Any]
    """Of its state and another output: the state with that output."""


def force_of(signal):
    """The force in a command or in a reading."""
    return signal.force


def takes_cut(block: Block) -> bool:
    """Whether a controller is told the programme and reads all sensors; any other gets forces alone."""
    return bool(getattr(block.step, "takes_cut", False))


def wrapped(inner: Block, maker: str) -> Inner:
    """``inner``, taken apart.

    Raises:
        BlockError: it is not a sampled, incremental controller of command, feedback and dt whose output can be set.
    """
    if inner.kind != "controller" or inner.continuous or inner.signals != ("command", "feedback", "dt"):
        raise BlockError(f"{maker}({inner.name}): needs a sampled controller that takes command, feedback and dt")
    sets = getattr(inner.step, "with_output", None) or WITH_OUTPUT.get(type(inner.state))
    if sets is None or inner.initial is not None or inner.params is None:
        raise BlockError(
            f"{maker}({inner.name}): needs a controller that adds to its output and says how that is set; see "
            "leadscrew.controllers._force.with_output"
        )
    if getattr(inner.params, "positional", False):
        raise BlockError(f"{maker}({inner.name}): needs an incremental controller; this one is positional")
    return Inner(inner, inner.step, inner.align, whole if takes_cut(inner) else force_of, sets)


def same_kind(
    step: Any, part: Inner, params: Any, state: Any, says: str, cut: bool, align: Any = None, **more: Any
) -> Block:
    """A controller that drives what the wrapped one drives; ``says`` is added to the sentence that describes it.

    ``cut``: whether it gets the programme and reads all sensors. ``align`` counts where the wrapped one has one.
    """
    inner = part.block
    step.takes_cut = cut
    return make(
        "controller", step, params, state, unit=inner.unit, drive=inner.drive, full_scale=inner.full_scale,
        sense=inner.sense, doc=f"{inner.doc} {says}", align=align if part.align is not None else None, **more,
    )  # fmt: skip
