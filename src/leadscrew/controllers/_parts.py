"""Finds the controller inside others: what a wrapper holds, and where its parameters and state lie."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from leadscrew.fuzzy.engine import Engine
from leadscrew.kernel.block import Block

WRAPPED = ("inner", "feed")
"""Fields under which a controller keeps the parameters of the one inside it."""
DEEPEST = 8


@dataclass(frozen=True)
class Part:
    """A controller, and the way to it through those around it."""

    block: Block
    params: tuple[str, ...] = ()
    """Fields that lead to its parameters from those of the outermost one."""
    state: tuple[str, ...] = ()
    around: tuple[str, ...] = ()
    """Names of the modules of the steps around it."""

    @property
    def column(self) -> str:
        """What its recorded states begin with."""
        return ".".join(("controller", *self.state)) + "."


def follow(value: Any, way: tuple[str, ...]) -> Any:
    """The field of a field of a value."""
    for name in way:
        value = getattr(value, name)
    return value


def named_by(function: Callable[..., Any] | None) -> Iterator[tuple[str, Any]]:
    """What a function, and the functions that it holds in turn, were made with; by the names that they use."""
    seen: set[int] = set()
    todo: list[Any] = [function]
    while todo:
        one = todo.pop(0)
        code = getattr(one, "__code__", None)
        if code is None or id(one) in seen:
            continue
        seen.add(id(one))
        for name, cell in zip(code.co_freevars, one.__closure__ or (), strict=True):
            try:
                value = cell.cell_contents
            except ValueError:  # a name that is not bound yet
                continue
            yield name, value
            todo.append(value)


def inside(block: Block, field: str) -> Block | None:
    """The controller whose parameters are the field ``field`` of a wrapper's; None where it cannot be told.

    Wrappers hold it as a block, or its step under the name ``law`` and its ``prepare`` under the name ``before``.
    """
    params, state = getattr(block.params, field), block.state
    for function in (block.prepare, block.step, block.align):
        for _, value in named_by(function):
            found = value if isinstance(value, Block) else getattr(value, "block", None)
            if isinstance(found, Block) and type(found.params) is type(params):
                return replace(found, params=params)
    law = next((v for n, v in named_by(block.step) if n == "law" and callable(v)), None)
    before = next((v for n, v in named_by(block.prepare) if n == "before"), None)
    if law is None:
        return None
    own = getattr(state, field) if field in getattr(state, "_fields", ()) else state
    return replace(
        block,
        name=getattr(law, "__name__", block.name),
        step=law,
        params=params,
        state=own,
        prepare=before,
        align=None,
        initial=None,
    )


def parts(block: Block) -> Iterator[Part]:
    """A controller and those inside it, from the outermost in."""
    part = Part(block)
    for _ in range(DEEPEST):
        yield part
        fields = getattr(part.block.params, "_fields", ())
        field = next((f for f in WRAPPED if f in fields), None)
        found = None if field is None else inside(part.block, field)
        if field is None or found is None:
            return
        own = field in getattr(part.block.state, "_fields", ())
        part = Part(
            found,
            (*part.params, field),
            (*part.state, field) if own else part.state,
            (*part.around, part.block.step.__module__),
        )


def engine_of(block: Block) -> Engine | None:
    """The fuzzy system that a block was made of; None where it was made of none."""
    for function in (block.prepare, block.step):
        for _, value in named_by(function):
            if isinstance(value, Engine):
                return value
    return None
