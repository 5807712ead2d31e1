"""The types of the C that is printed: numbers, NamedTuples, tuples that a function returns, and arrays."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Number:
    """A scalar; of two that meet, the one of higher rank wins."""

    c: str
    rank: int


BOOL = Number("bool", 0)
INT = Number("int64_t", 1)
FLOAT = Number("float", 2)
DOUBLE = Number("double", 3)


@dataclass(frozen=True)
class Array:
    """An array of known rank; a size is a number, or the C text of one."""

    element: Number
    shape: tuple[int | str, ...]
    const: bool = False


@dataclass(frozen=True)
class Struct:
    """A NamedTuple of the module."""

    name: str
    fields: tuple[tuple[str, Type], ...]

    def field(self, name: str) -> Type:
        """The type of a field."""
        return dict(self.fields)[name]


@dataclass(frozen=True)
class Pair:
    """A tuple that a function returns, of any length."""

    items: tuple[Type, ...]


Type = Number | Array | Struct | Pair


def joined(a: Type, b: Type) -> Type | None:
    """The type of a value that is either; ``None`` where there is none."""
    if isinstance(a, Number) and isinstance(b, Number):
        return a if a.rank >= b.rank else b
    if isinstance(a, Pair) and isinstance(b, Pair) and len(a.items) == len(b.items):
        items = [joined(x, y) for x, y in zip(a.items, b.items, strict=True)]
        return None if None in items else Pair(tuple(i for i in items if i is not None))
    if isinstance(a, Array) and isinstance(b, Array) and (a.element, a.shape) == (b.element, b.shape):
        return Array(a.element, a.shape, a.const or b.const)
    return a if a == b else None


def sized(kind: Type, name: str) -> Type:
    """An argument's type, with sizes that are known only at run time under names of their own."""
    if not isinstance(kind, Array):
        return kind
    shape = tuple(n if isinstance(n, int) else f"{name}_size{i}" for i, n in enumerate(kind.shape))
    return Array(kind.element, shape, kind.const)


def sizes_of(kind: Type) -> list[str]:
    """The sizes of an array that are known only at run time; they follow it as arguments."""
    return [n for n in kind.shape if isinstance(n, str)] if isinstance(kind, Array) else []


def has_arrays(kind: Type) -> bool:
    """Whether a value of a type holds an array somewhere."""
    if isinstance(kind, Struct):
        return any(has_arrays(k) for _, k in kind.fields)
    if isinstance(kind, Pair):
        return any(has_arrays(k) for k in kind.items)
    return isinstance(kind, Array)
