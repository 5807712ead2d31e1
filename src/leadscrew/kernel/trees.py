"""Copying and walking syntax trees, fast: a loop's tree is copied many times on its way to one function.

Trees may be deep, and hold no cycles: Python stops recursion at 1,000 calls, which a sum of 250 terms needs, and half
of a compilation went into looking for cycles; see :func:`treework`.
"""

from __future__ import annotations

import ast
import gc
import sys
import threading
import types
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from leadscrew.util.errors import SubsetError

Swap = Callable[[ast.Name], ast.expr]
Rules = Mapping[type, Callable[[Any], ast.AST]]
"""What stands in place of the nodes of a class."""
_PLAIN = {"ctx", "op", "ops", "id", "attr", "arg", "kind", "type_comment", "type_ignores", "type_params"}

MARKS = ("is_local", "wraps", "meets_float")
"""What the normaliser and the flow note on nodes."""


_ONE_AT_A_TIME = threading.RLock()
"""CPython 3.11 counts the depth of a tree that it makes in one place for all threads, and fails where two make trees
at a time: SystemError, "AST constructor recursion depth mismatch"."""


def parsed(text: str) -> ast.Module:
    """The tree of a text of Python."""
    with _ONE_AT_A_TIME:
        return ast.parse(text)


def expression(text: str) -> ast.expr:
    """The tree of an expression."""
    with _ONE_AT_A_TIME:
        return ast.parse(text, mode="eval").body


def code_of(tree: ast.Module, filename: str) -> types.CodeType:
    """A tree, compiled; what it lacks of line numbers is added."""
    with _ONE_AT_A_TIME:
        return compile(ast.fix_missing_locations(tree), filename, "exec")


class _Inner(dict[type, tuple[str, ...]]):
    """The fields of each class of node in which further nodes stand."""

    def __missing__(self, cls: type[ast.AST]) -> tuple[str, ...]:
        found = () if cls is ast.Constant else tuple(f for f in cls._fields if f not in _PLAIN)
        self[cls] = found
        return found


INNER = _Inner()


def clone(node: Any, swap: Swap | None = None) -> Any:
    """A copy of a tree without its own line numbers, constants shared; ``swap`` says what stands for each name."""
    cls = node.__class__
    if cls is ast.Name:
        return ast.Name(node.id, node.ctx) if swap is None else swap(node)
    if cls is ast.Constant:
        return node
    new = cls.__new__(cls)
    old, made = node.__dict__, new.__dict__
    for field in cls._fields:
        value = old.get(field)
        if value.__class__ is list:
            made[field] = [clone(v, swap) if isinstance(v, ast.AST) and v._fields else v for v in value]
        elif isinstance(value, ast.AST) and value._fields:
            made[field] = clone(value, swap)
        else:
            made[field] = value
    if isinstance(new, ast.stmt):
        new.lineno = 1  # what ast.unparse asks of a statement
    return new


def copied(node: Any) -> Any:
    """A copy of a tree with its line numbers and our marks; what others hung on its nodes stays behind."""
    cls = node.__class__
    new = cls.__new__(cls)
    old, made = node.__dict__, new.__dict__
    for field in (*cls._fields, *cls._attributes, *MARKS):
        if field not in old:
            continue
        value = old[field]
        if value.__class__ is list:
            made[field] = [copied(v) if isinstance(v, ast.AST) and v._fields else v for v in value]
        elif isinstance(value, ast.AST) and value._fields:
            made[field] = copied(value)
        else:
            made[field] = value
    return new


def each(node: ast.AST) -> Iterator[Any]:
    """Every node of a tree that has fields, in no order that matters."""
    stack: list[Any] = [node]
    pop, push, inner = stack.pop, stack.append, INNER
    while stack:
        n = pop()
        yield n
        held = n.__dict__
        for field in inner[n.__class__]:
            value = held.get(field)
            if value.__class__ is list:
                for v in value:
                    if isinstance(v, ast.AST):
                        push(v)
            elif isinstance(value, ast.AST):
                push(value)


def names(node: ast.AST) -> Iterator[ast.Name]:
    """Every name in a tree."""
    for n in each(node):
        if n.__class__ is ast.Name:
            yield n


def rewritten(node: Any, rules: Rules) -> Any:
    """A tree whose nodes are replaced, innermost first, by what the rule of their class gives; changed in place."""
    cls = node.__class__
    held = node.__dict__
    for field in INNER[cls]:
        value = held.get(field)
        if value.__class__ is list:
            value[:] = [rewritten(v, rules) if isinstance(v, ast.AST) else v for v in value]
        elif isinstance(value, ast.AST):
            held[field] = rewritten(value, rules)
    rule = rules.get(cls)
    return node if rule is None else rule(node)


def fingerprint(node: ast.AST) -> str:
    """A text that two trees share only if they are the same but for line numbers."""
    parts: list[str] = []

    def walk(n: Any) -> None:
        parts.append(n.__class__.__name__)
        for field in n._fields:
            value = getattr(n, field, None)
            if value.__class__ is list:
                parts.append("[")
                for v in value:
                    if isinstance(v, ast.AST):
                        walk(v)
                    else:
                        parts.append(repr(v))
                parts.append("]")
            elif isinstance(value, ast.AST):
                walk(value)
            else:
                parts.append(repr(value))

    walk(node)
    return " ".join(parts)


DEEPEST = 20_000
"""Calls in one another."""


@contextmanager
def treework() -> Iterator[None]:
    """Inside it, or in a function that it decorates, recursion may go deep, and the garbage collector waits.

    Raises:
        SubsetError: an expression lies too deep all the same.
    """
    collects, calls = gc.isenabled(), sys.getrecursionlimit()
    gc.disable()
    sys.setrecursionlimit(max(calls, DEEPEST))
    try:
        yield
    except RecursionError:
        raise SubsetError(
            "an expression is nested too deep to be compiled, or a function calls itself: divide it into statements"
        ) from None
    finally:
        sys.setrecursionlimit(calls)
        if collects:
            gc.enable()
