"""The types of the C that is printed: numbers, NamedTuples, tuples that a function returns, and arrays."""

from __future__ import annotations

from dataclasses import dataclass, field, replace


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
    local: bool = field(default=False, compare=False)
    """Whether it lies in the function that is printed, and must not leave it."""


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
        return Array(a.element, a.shape, a.const or b.const, a.local or b.local)
    if isinstance(a, Struct) and isinstance(b, Struct) and (a.name, len(a.fields)) == (b.name, len(b.fields)):
        kinds = [(f, joined(x, y)) for (f, x), (_, y) in zip(a.fields, b.fields, strict=True)]
        return Struct(a.name, tuple((f, k) for f, k in kinds if k is not None)) if all(k for _, k in kinds) else None
    return a if a == b else None


def sized(kind: Type, name: str) -> Type:
    """An argument's type, with sizes that are known only at run time under names of their own."""
    if not isinstance(kind, Array):
        return kind
    shape = tuple(n if isinstance(n, int) else f"{name}_size{i}" for i, n in enumerate(kind.shape))
    return Array(kind.element, shape, kind.const)


def arrays_of(kind: Type) -> list[Array]:
    """The arrays that a value of a type holds."""
    if isinstance(kind, Array):
        return [kind]
    parts = [k for _, k in kind.fields] if isinstance(kind, Struct) else kind.items if isinstance(kind, Pair) else ()
    return [array for part in parts for array in arrays_of(part)]


def as_local(kind: Type, local: bool = True) -> Type:
    """A type with all its arrays marked as lying in the function that is printed, or not."""
    if isinstance(kind, Struct):
        return Struct(kind.name, tuple((f, as_local(k, local)) for f, k in kind.fields))
    if isinstance(kind, Pair):
        return Pair(tuple(as_local(k, local) for k in kind.items))
    return replace(kind, local=local) if isinstance(kind, Array) else kind


def sizes_of(kind: Type) -> list[str]:
    """The sizes of an array that are known only at run time; they follow it as arguments."""
    return [n for n in kind.shape if isinstance(n, str)] if isinstance(kind, Array) else []


def has_arrays(kind: Type) -> bool:
    """Whether a value of a type holds an array somewhere."""
    return bool(arrays_of(kind))
