"""How nested NamedTuples lie in flat vectors: every scalar a place in one vector, every array a stretch of another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import prod
from operator import attrgetter
from typing import Any

import numpy as np

from leadscrew.kernel.parameters import SILENT, Note, leaf_type, notes


@dataclass(frozen=True)
class Leaf:
    """One scalar or array inside nested NamedTuples."""

    key: str
    """Dotted name."""
    kind: str
    """``float``, ``int``, ``bool`` or ``array``."""
    at: int
    """Place in the scalar vector, or start of the stretch in the array vector."""
    shape: tuple[int, ...] = ()

    @property
    def size(self) -> int:
        """How many numbers it holds."""
        return prod(self.shape)


@dataclass(frozen=True)
class Branch:
    """A NamedTuple of leaves and further branches."""

    key: str
    type: Any
    parts: tuple[Leaf | Branch, ...]


def is_branch(value: Any) -> bool:
    """Whether a value is a NamedTuple."""
    return isinstance(value, tuple) and hasattr(value, "_fields")


def copied(value: Any) -> Any:
    """A value whose arrays are its own."""
    if isinstance(value, np.ndarray):
        return value.copy()
    return type(value)(*(copied(v) for v in value)) if is_branch(value) else value


class Layout:
    """The layout of one value, and the packing of values of its type."""

    def __init__(self, value: Any) -> None:
        self.scalars: list[Leaf] = []
        self.arrays: list[Leaf] = []
        self.array_size = 0
        self.tree = self._grow("", value, SILENT)

    def _grow(self, key: str, value: Any, note: Note) -> Leaf | Branch:
        if is_branch(value):
            cls: Any = type(value)
            sheet = notes(cls)
            parts = tuple(
                self._grow(f"{key}.{f}" if key else f, v, sheet.get(f, SILENT))
                for f, v in zip(value._fields, value, strict=True)
            )
            return Branch(key, type(value), parts)
        kind = leaf_type(note, value)
        if kind == "array":
            shape = np.shape(value)
            leaf = Leaf(key, kind, self.array_size, shape)
            self.array_size += leaf.size
            self.arrays.append(leaf)
        else:
            leaf = Leaf(key, kind, len(self.scalars))
            self.scalars.append(leaf)
        return leaf

    @property
    def keys(self) -> dict[str, Leaf]:
        """Every leaf by its dotted key."""
        return {leaf.key: leaf for leaf in (*self.scalars, *self.arrays)}

    def pack(self, value: Any) -> tuple[np.ndarray, np.ndarray]:
        """The scalar vector and the array vector of a value with this layout."""
        scalars, arrays = np.zeros(max(1, len(self.scalars))), np.zeros(max(1, self.array_size))
        self._pack(self.tree, value, scalars, arrays)
        return scalars, arrays

    def places(self, key: str, scalars: int, start: int) -> list[int]:
        """Where every number below a dotted key lies, with the array vector behind ``scalars`` numbers."""
        found: list[int] = []
        for leaf in leaves(self.part(key)):
            first = start + leaf.at + (scalars if leaf.kind == "array" else 0)
            found += range(first, first + (leaf.size if leaf.kind == "array" else 1))
        return found

    def part(self, key: str) -> Leaf | Branch:
        """The leaf or branch under a dotted key."""
        node: Leaf | Branch = self.tree
        while node.key != key:
            assert isinstance(node, Branch)
            node = next(p for p in node.parts if key == p.key or key.startswith(f"{p.key}."))
        return node

    def _pack(self, node: Leaf | Branch, value: Any, scalars: np.ndarray, arrays: np.ndarray) -> None:
        if isinstance(node, Branch):
            for part, item in zip(node.parts, value, strict=True):
                self._pack(part, item, scalars, arrays)
        elif node.kind == "array":
            arrays[node.at : node.at + node.size] = np.asarray(value, dtype=np.float64).ravel()
        else:
            scalars[node.at] = value

    def unpack(self, scalars: np.ndarray, arrays: np.ndarray) -> Any:
        """The value that the two vectors hold; arrays are copies."""
        return self._unpack(self.tree, scalars, arrays)

    def _unpack(self, node: Leaf | Branch, scalars: np.ndarray, arrays: np.ndarray) -> Any:
        if isinstance(node, Branch):
            return node.type(*(self._unpack(p, scalars, arrays) for p in node.parts))
        if node.kind == "array":
            return arrays[node.at : node.at + node.size].reshape(node.shape).copy()
        x = scalars[node.at]
        return int(x) if node.kind == "int" else bool(x) if node.kind == "bool" else float(x)


def numbers_of(value: Any) -> Iterator[float]:
    """Every number of a value, in the order of its layout's leaves."""
    for item in value if is_branch(value) else (value,):
        if isinstance(item, tuple):
            yield from numbers_of(item)
        elif isinstance(item, np.ndarray):
            yield from item.ravel().tolist()
        else:
            yield item


def reader_of(example: Any) -> Callable[[Any], list[float]]:
    """:func:`numbers_of` for many values of the same structure as ``example``: ten times faster."""
    if not is_branch(example):
        return lambda value: list(numbers_of(value))
    paths: list[tuple[str, bool]] = []

    def walk(value: Any, lead: str) -> None:
        for name, item in zip(value._fields, value, strict=True):
            if is_branch(item):
                walk(item, f"{lead}{name}.")
            else:
                paths.append((lead + name, isinstance(item, np.ndarray | tuple)))

    walk(example, "")
    # one path more than there are: attrgetter of a single one gives no tuple
    get = attrgetter(*(path for path, _ in paths), paths[0][0])
    if not any(inner for _, inner in paths):
        return lambda value: list(get(value)[:-1])

    def read(value: Any) -> list[float]:
        found: list[float] = []
        for item, (_, inner) in zip(get(value), paths, strict=False):
            if inner:
                found += item.ravel().tolist() if isinstance(item, np.ndarray) else numbers_of(item)
            else:
                found.append(item)
        return found

    return read


def leaves(node: Leaf | Branch) -> list[Leaf]:
    """All leaves below a node, in order."""
    if isinstance(node, Leaf):
        return [node]
    return [leaf for part in node.parts for leaf in leaves(part)]
