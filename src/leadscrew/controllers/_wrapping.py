"""What controllers that wrap another one share: the check of what they are given, and how they read its command."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, cast

from leadscrew.kernel.block import Block, make
from leadscrew.kernel.by_position import position_of, prepared, whole
from leadscrew.kernel.layout import copied
from leadscrew.util.errors import BlockError

PROBE_DT = 0.5e-3
"""Period at which a controller is asked what command it takes, s."""


class Inner(NamedTuple):
    """A controller taken apart, to be called inside another one."""

    block: Block
    law: Callable[..., Any]
    align: Any
    """Its ``align``; None where it has none, and then the wrapper has none (:func:`same_kind`)."""
    motion: bool
    """Whether its command is a :class:`~leadscrew.references.Motion`; else it is a number."""
    place: Callable[..., Any]
    """Of its command: the position."""

    def ready(self, dt: float) -> Any:
        """What its step gets as ``p`` at this period."""
        return prepared(self.block, dt)


def takes_motion(block: Block, dt: float = PROBE_DT) -> bool:
    """Whether a controller reads its command as a motion.

    A controller made here says it; any other is tried once, at rest, on a number: reading ``command.position`` of a
    number is the one thing that its step can do wrong in this.
    """
    said = getattr(block.step, "takes_motion", None)
    if said is not None:
        return bool(said)
    first = [] if block.params is None else [prepared(block, dt)]
    state = block.initial(block.params) if block.initial is not None else block.state
    first += [] if state is None else [copied(state)]
    given = {"command": 0.0, "feedback": 0.0, "dt": dt}
    try:
        block.step(*first, **{name: given[name] for name in block.signals if name in given})
    except AttributeError:
        return True
    return False


def wrapped(inner: Block, maker: str) -> Inner:
    """``inner``, taken apart.

    Raises:
        BlockError: it is not a sampled controller with parameters and state that takes command, feedback and dt.
    """
    if inner.kind != "controller" or inner.continuous or inner.params is None or inner.state is None:
        raise BlockError(f"{maker}({inner.name}): needs a sampled controller with parameters and state")
    if inner.signals != ("command", "feedback", "dt") or inner.initial is not None:
        raise BlockError(f"{maker}({inner.name}): needs a controller that takes command, feedback and dt")
    motion = takes_motion(inner)
    place = position_of if motion else whole
    return Inner(inner, inner.step, inner.align, motion, place)


@cache
def _class_around(name: str, inner: Any, own: Any) -> Any:
    return NamedTuple(name, [("inner", inner), *own])


def around(name: str, inner: Any, *own: tuple[str, Any]) -> Any:
    """A NamedTuple class: what the wrapped block has as ``inner``, then the wrapper's own fields.

    The same class for the same fields, so that a loop with other values is not compiled again.
    """
    return _class_around(name, cast(Any, type(inner)), own)


def same_kind(
    step: Any, part: Inner, params: Any, state: Any, says: str, motion: bool | None = None, align: Any = None,
    **more: Any,
) -> Block:  # fmt: skip
    """A controller that drives what the wrapped one drives; ``says`` is added to the sentence that describes it.

    ``motion``: whether it takes motions (default: whether the wrapped one does). ``align`` counts where the wrapped one
    has one.
    """
    inner = part.block
    step.takes_motion = part.motion if motion is None else motion
    return make(
        "controller", step, params, state, unit=inner.unit, drive=inner.drive, full_scale=inner.full_scale,
        sense=inner.sense, doc=f"{inner.doc} {says}", align=align if part.align is not None else None, **more,
    )  # fmt: skip
