"""What is known of a value before a step runs: the kind of a number, and which array is meant.

Machine code gives every local one type and every array one place. A value that is a whole number on one path and a
float on another is a float there, plain Python keeps the whole number; an array that is one array on one path and
another on another has no one place.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel.sheet import SILENT, leaf_type, notes
from leadscrew.kernel.subset import is_named_tuple_type

WHOLE, FLOAT, MIXED, SIGNAL, ANY = "whole", "float", "mixed", "signal", "any"
"""Numbers: whole, float, either by path; a float or a NamedTuple of floats; what is not known."""
STATE, PARAMETERS, TABLE, FRESH = "the state", "the parameters", "a constant table", "a new array"


class Array(NamedTuple):
    """One array: where it comes from, which one of these, and whether it holds whole numbers."""

    origin: str
    key: Any
    whole: bool = False
    rank: int = 0
    """Its dimensions, 0 where they are not known."""


class Record(NamedTuple):
    """A NamedTuple."""

    cls: Any
    parts: tuple[Any, ...]

    def part(self, field: str) -> Any:
        """One field."""
        return self.parts[self.cls._fields.index(field)]


class Several(NamedTuple):
    """A plain tuple."""

    items: tuple[Any, ...]


class Clash(NamedTuple):
    """What paths disagree on."""

    what: str


Value = Any
"""A kind of number, or one of the classes above."""
ARRAYS = Clash("is one array on one path and another on another; use each under an 'if' of its own")
SHAPES = Clash("is a number, an array or a NamedTuple by path; give each a name of its own")


def number_of(value: Value) -> Value:
    """The kind of a value where it is used as a number."""
    return FLOAT if value == SIGNAL else value


def met(a: Value, b: Value) -> Value:
    """The kind of what two numbers give in arithmetic."""
    kinds = {number_of(a), number_of(b)}
    return next(k for k in (FLOAT, ANY, MIXED, WHOLE) if k in kinds)


def joined(a: Value, b: Value) -> Value:
    """What is known of a value that is either of two."""
    if a == b:
        return a
    if ANY in (a, b):
        return ANY
    if isinstance(a, Record) and isinstance(b, Record) and a.cls is b.cls:
        return Record(a.cls, tuple(joined(x, y) for x, y in zip(a.parts, b.parts, strict=True)))
    if isinstance(a, Several) and isinstance(b, Several) and len(a.items) == len(b.items):
        return Several(tuple(joined(x, y) for x, y in zip(a.items, b.items, strict=True)))
    if isinstance(a, str) and isinstance(b, str):
        kinds = {number_of(a), number_of(b)}
        return kinds.pop() if len(kinds) == 1 else MIXED
    if isinstance(a, Clash) or isinstance(b, Clash):
        return a if isinstance(a, Clash) else b
    return ARRAYS if isinstance(a, Array) and isinstance(b, Array) else SHAPES


def inside(value: Value, kind: type) -> Any:
    """The first part of a value that is of a class, or ``None``."""
    if isinstance(value, kind):
        return value
    parts = value.parts if isinstance(value, Record) else value.items if isinstance(value, Several) else ()
    return next((found for p in parts if (found := inside(p, kind)) is not None), None)


def renewed(value: Value, call: int) -> Value:
    """What a function returned, its new arrays told apart from those of other calls."""
    if isinstance(value, Array) and value.origin == FRESH:
        return value._replace(key=(call, value.key))
    if isinstance(value, Record):
        return Record(value.cls, tuple(renewed(p, call) for p in value.parts))
    return Several(tuple(renewed(p, call) for p in value.items)) if isinstance(value, Several) else value


def of_class(cls: Any, origin: str, key: str = "") -> Record:
    """What is known of a NamedTuple by its annotations; its arrays are named by their dotted keys."""
    sheet = notes(cls)
    parts: list[Value] = []
    for field in cls._fields:
        note, name = sheet.get(field, SILENT), f"{key}.{field}" if key else field
        if is_named_tuple_type(note.base):
            parts.append(of_class(note.base, origin, name))
            continue
        kind = leaf_type(note, cls._field_defaults.get(field))
        parts.append(Array(origin, name) if kind == "array" else FLOAT if kind == "float" else WHOLE)
    return Record(cls, tuple(parts))


def table(name: str, value: np.ndarray) -> Array:
    """A constant array of the module."""
    return Array(TABLE, name, value.dtype.kind == "i", value.ndim)


def other_array(old: Value, new: Value, key: str = "") -> str | None:
    """The dotted key of the first array of a state that is another one in the next."""
    if isinstance(old, Array):
        return key if new not in (old, ANY) else None
    if isinstance(old, Record) and isinstance(new, Record) and old.cls is new.cls:
        for field, a, b in zip(old.cls._fields, old.parts, new.parts, strict=True):
            found = other_array(a, b, f"{key}.{field}" if key else field)
            if found is not None:
                return found
    return None
