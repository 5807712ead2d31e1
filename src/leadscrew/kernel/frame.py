"""The composite types of a loop: its parameters, its state and its signals as nested NamedTuples."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel.layout import Branch, Layout, Leaf, is_branch, leaves
from leadscrew.util.errors import BlockError

SLOTS = ("reference", "disturbance", "output_disturbance", "sensor", "controller", "actuator", "plant")
"""The places of a loop that hold one block each."""


class Clock(NamedTuple):
    """What a loop needs to know of time, chance and limits."""

    period: float
    step: float
    substeps: int
    seed: int
    bound: float


def bundle(type_name: str, values: dict[str, Any]) -> Any:
    """A NamedTuple made for the occasion, annotated with the types of its values."""
    kinds = tuple((k, np.ndarray if isinstance(v, np.ndarray) else type(v)) for k, v in values.items())
    return _bundle_type(type_name, kinds)(**values)


@lru_cache(maxsize=1024)
def _bundle_type(type_name: str, kinds: tuple[tuple[str, type], ...]) -> Any:
    cls: Any = namedtuple(type_name, [k for k, _ in kinds])  # type: ignore[misc]
    cls.__annotations__ = dict(kinds)
    return cls


def as_floats(signal: Any) -> Any:
    """A signal with every leaf a float, keeping its NamedTuple types."""
    if is_branch(signal):
        return type(signal)(*(as_floats(x) for x in signal))
    if isinstance(signal, bool | int | float | np.floating | np.integer | np.bool_):
        return float(signal)
    raise BlockError(f"a signal is a float or a NamedTuple of floats, not {type(signal).__name__} ({signal!r})")


def signal_tree(signal: Any) -> Leaf | Branch:
    """The layout of a signal."""
    return Layout(as_floats(signal)).tree


@dataclass(frozen=True)
class Pair:
    """A leaf of the command and the leaf of a measured signal that it is compared with."""

    suffix: str
    command: str
    other: str


def _position(node: Leaf | Branch) -> Leaf | Branch:
    """The position inside a motion (a NamedTuple with a field ``position``), else the node itself."""
    if isinstance(node, Branch):
        for part in node.parts:
            if part.key.rsplit(".", 1)[-1] == "position":
                return part
    return node


def pairs(command: Leaf | Branch, other: Leaf | Branch) -> list[Pair]:
    """What an error is the difference of: positions where there are positions, axis by axis where names agree.

    A command that is a motion is compared by its position; two NamedTuples by the fields that both have; where
    nothing agrees, the first number of each.
    """
    a, b = _position(command), _position(other)
    if isinstance(a, Branch) and isinstance(b, Branch):
        theirs = {p.key.rsplit(".", 1)[-1]: p for p in b.parts}
        found = []
        for part in a.parts:
            field = part.key.rsplit(".", 1)[-1]
            if field in theirs:
                for inner in pairs(part, theirs[field]):
                    found.append(Pair(f".{field}{inner.suffix}", inner.command, inner.other))
        if found:
            return found
    return [Pair("", leaves(a)[0].key, leaves(b)[0].key)]


def under(root: str, key: str) -> str:
    """``root.key``, or ``root`` for a signal that is one number."""
    return f"{root}.{key}" if key else root
